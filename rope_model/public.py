"""Public names of the rope, to be imported from ``rope_model``; docs/reference/python.md describes them."""

import logging
from typing import Literal, get_args

from rope_model.analysis.neighbours import Account, Contacts, Neighbours
from rope_model.cases import ROPE_CASES, Level, RopeCase, at_level, rope_120, rope_240
from rope_model.catalogue import BEARINGS, CONSTRUCTIONS, Datum, DatumStatus, KnownRope, rope
from rope_model.engine import NativeRope
from rope_model.interface import BalanceRope, Snapshot, Status
from rope_model.parameters import CHOICES, Layout, Rope, Scene, Swivel
from rope_model.rules.bodies import BODIES
from rope_model.rules.end_paths import EndMotion
from rope_model.rules.fidelity import FIDELITIES
from rope_model.rules.neglected_effects import Effect, neglected_effects, neglected_text
from rope_model.rules.point_forces import PointForces
from rope_model.rules.signal_table import CAUSES as GUARD_CAUSES
from rope_model.rules.signal_table import SIGNALS, Signal
from rope_model.rules.state import RopeState
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
from rope_model.simulation.simulator import RopeSimulator
from rope_model.solver_parameters import Accuracy, Inputs, Mesh, Model, Solver, Stations

__all__ = [
    "BEARINGS",
    "BODIES",
    "CHOICES",
    "CONSTRUCTIONS",
    "FAR",
    "FIDELITIES",
    "GUARD_CAUSES",
    "ROPE_CASES",
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
    "RopeSimulator",
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

Form = Literal["auto", "native", "python", "reference"]


def balance_rope(scene: Scene, form: Form = "auto") -> BalanceRope:
    """Return a rope for the scene, not yet initialised.

    Parameters
    ----------
    scene : Scene
        Rope, layout, swivels, mesh, solver and surroundings, in SI units.
    form : {"auto", "native", "python", "reference"}
        ``auto`` takes the native form, unless ``scene.solver.kernels`` names kernels of the Python form.
        ``reference`` is the published system alone, in plain Python to be read: far slower, and it
        refuses scenes that hold more.

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
        If there is no native rope: no library came with the package, and no C compiler is here or it fails. Or if
        ``python`` lacks compiled kernels that the scene asks for.
    OSError
        If the library cannot be kept in the cache folder.
    """
    if not isinstance(scene, Scene):
        kind = type(scene).__name__
        raise TypeError(
            f"scene is a {kind} and must be a Scene; that of a case is rope_120().scene"
        )
    if form not in get_args(Form):
        raise ValueError(
            f"form = {form!r} must be 'auto', 'native', 'python' or 'reference'; "
            "'auto' takes the native one"
        )
    rope = _rope(scene, form)
    log.info("the rope runs as a %s", type(rope).__name__)
    return rope


def _rope(scene: Scene, form: Form) -> BalanceRope:
    if form == "reference":
        # imported here: it takes optimizers of scipy that no other form needs
        from rope_model.reference.rope import ReferenceRope

        return ReferenceRope(scene)
    asks_for_kernels = form == "auto" and scene.solver.kernels != "auto"
    if form == "python" or asks_for_kernels:
        return RopeSimulator(scene)
    return NativeRope(scene)
