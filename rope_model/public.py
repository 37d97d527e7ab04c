"""Public names of the rope, to be imported from ``rope_model``; docs/reference/python.md describes them."""

import logging
from typing import Literal, get_args

from rope_model.analysis.neighbours import Account, Contacts, Neighbours
from rope_model.boundary.bodies import BODIES
from rope_model.boundary.end_paths import EndMotion
from rope_model.boundary.point_forces import PointForces
from rope_model.cases import ROPE_CASES, Level, RopeCase, at_level, rope_120, rope_240
from rope_model.catalogue import BEARINGS, CONSTRUCTIONS, Datum, DatumStatus, KnownRope, rope
from rope_model.engine import NativeRope
from rope_model.fidelity.choice import FIDELITIES
from rope_model.fidelity.neglected_effects import Effect, neglected_effects, neglected_text
from rope_model.interface import BalanceRope, Snapshot, Status
from rope_model.parameters import CHOICES, Layout, Rope, Scene, Swivel
from rope_model.physics.node import SIDES
from rope_model.shaft_parameters import (
    FAR,
    Air,
    Contact,
    Conveyance,
    Divider,
    Guard,
    HeadRopes,
    Lining,
    Shaft,
    Sump,
)
from rope_model.signals.signal_table import CAUSES as GUARD_CAUSES
from rope_model.signals.signal_table import SIGNALS, Signal
from rope_model.solver_parameters import Accuracy, Inputs, Mesh, Model, Solver, Stations
from rope_model.state import RopeState

__all__ = [
    "BEARINGS",
    "BODIES",
    "CHOICES",
    "CONSTRUCTIONS",
    "FAR",
    "FIDELITIES",
    "GUARD_CAUSES",
    "ROPE_CASES",
    "SIDES",
    "SIGNALS",
    "Account",
    "Accuracy",
    "Air",
    "BalanceRope",
    "Contact",
    "Contacts",
    "Conveyance",
    "Datum",
    "DatumStatus",
    "Divider",
    "Effect",
    "EndMotion",
    "Form",
    "Guard",
    "HeadRopes",
    "Inputs",
    "KnownRope",
    "Layout",
    "Level",
    "Lining",
    "Mesh",
    "Model",
    "Neighbours",
    "PointForces",
    "Rope",
    "RopeCase",
    "RopeState",
    "Scene",
    "Shaft",
    "Signal",
    "Snapshot",
    "Solver",
    "Stations",
    "Status",
    "Sump",
    "Swivel",
    "at_level",
    "balance_rope",
    "neglected_effects",
    "neglected_text",
    "rope",
    "rope_120",
    "rope_240",
]

log = logging.getLogger(__name__)

Form = Literal["native", "reference"]


def balance_rope(scene: Scene, form: Form = "native") -> BalanceRope:
    """Return a rope for the scene, not yet initialised.

    Parameters
    ----------
    scene : Scene
        Rope, layout, swivels, mesh, solver and surroundings, in SI units.
    form : {"native", "reference"}
        ``native`` is the engine, in C. ``reference`` is the published system alone, in plain Python to be read: it
        is far slower, and it refuses scenes that hold more.

    Returns
    -------
    BalanceRope
        A rope to be initialised with the motion of both ends.

    Raises
    ------
    TypeError
        If ``scene`` is no Scene.
    ValueError
        If the mesh does not fit the rope, ``form`` is unknown, or the scene holds more than ``reference`` knows.
    RuntimeError
        If there is no native rope: no library came with the package, and no C compiler is here or it fails.
    OSError
        If the library cannot be kept in the cache folder.
    """
    if not isinstance(scene, Scene):
        kind = type(scene).__name__
        raise TypeError(
            f"scene is a {kind} and must be a Scene; that of a case is rope_120().scene"
        )
    if form not in get_args(Form):
        raise ValueError(f"form = {form!r} must be 'native' or 'reference'")
    rope = _rope(scene, form)
    log.info("the rope runs as a %s", type(rope).__name__)
    return rope


def _rope(scene: Scene, form: Form) -> BalanceRope:
    if form == "reference":
        # imported here: it takes optimizers of scipy that no other form needs
        from rope_model.reference.rope import ReferenceRope

        return ReferenceRope(scene)
    return NativeRope(scene)
