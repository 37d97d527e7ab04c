"""Public names of the rope, to be imported from ``rope_model``; docs/reference/python.md describes them."""

import logging
import subprocess
from typing import Literal, get_args

from rope_model.cases import ROPE_CASES, Level, RopeCase, at_level, rope_120, rope_240
from rope_model.catalogue import BEARINGS, CONSTRUCTIONS, Datum, DatumStatus, KnownRope, rope
from rope_model.engine import NativeRope
from rope_model.files import WriteError
from rope_model.numerics.kernels import last_words
from rope_model.parameters import CHOICES, Layout, Rope, Scene, Swivel
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
from rope_model.simulation.contact.neighbours import Account, Contacts, Neighbours
from rope_model.simulation.contact.point_forces import PointForces
from rope_model.simulation.contact.shaft import BODIES
from rope_model.simulation.ends.paths import EndMotion
from rope_model.simulation.fidelity import FIDELITIES
from rope_model.simulation.interface import BalanceRope, Snapshot, Status
from rope_model.simulation.outputs.neglected_effects import (
    Effect,
    neglected_effects,
    neglected_text,
)
from rope_model.simulation.outputs.signal_table import CAUSES as GUARD_CAUSES
from rope_model.simulation.outputs.signal_table import SIGNALS, Signal
from rope_model.simulation.simulator import RopeSimulator
from rope_model.simulation.state import RopeState
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
        ``auto`` takes the native form. It takes the Python form where there is no native one, or where
        ``scene.solver.kernels`` names kernels of the Python form. ``reference`` is the published system alone, in
        plain Python to be read: far slower, and it refuses scenes that hold more.

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
        If ``native`` finds no C compiler, or ``python`` lacks compiled kernels that the scene asks for.
    OSError, subprocess.CalledProcessError
        If ``native`` finds a C compiler that fails.
    """
    if not isinstance(scene, Scene):
        kind = type(scene).__name__
        raise TypeError(
            f"scene is a {kind} and must be a Scene; that of a case is rope_120().scene"
        )
    if form not in get_args(Form):
        raise ValueError(
            f"form = {form!r} must be 'auto', 'native', 'python' or 'reference'; "
            "'auto' takes the fastest to be had"
        )
    rope = _rope(scene, form)
    log.info("the rope runs as a %s", type(rope).__name__)
    return rope


def _rope(scene: Scene, form: Form) -> BalanceRope:
    if form == "native":
        return NativeRope(scene)
    if form == "reference":
        # imported here: it takes optimizers of scipy that no other form needs
        from rope_model.reference.rope import ReferenceRope

        return ReferenceRope(scene)
    if form == "auto" and scene.solver.kernels == "auto":
        try:
            return NativeRope(scene)
        except RuntimeError as error:  # no compiler
            log.info("the native rope cannot be had: %s", error)
        except WriteError as error:
            log.warning(
                "the native rope cannot be had: %s; the Python form takes some ten times as long",
                error,
            )
        except (OSError, subprocess.CalledProcessError) as error:
            log.warning(
                "the native rope cannot be had: %s; the Python form takes some ten times as long. Repair the compiler, "
                "name another in CC, or ask for form='python'",
                last_words(error),
            )
    return RopeSimulator(scene)
