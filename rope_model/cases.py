"""Levels of accuracy and the two published ropes; lengths and heights are the source's, mass and stiffness assumed."""

from dataclasses import dataclass
from typing import Any, Literal

from rope_model.parameters import Rope, Scene, Swivel
from rope_model.solver_parameters import Accuracy, Mesh, Model, Solver

Level = Literal["draft", "standard", "reference"]
#: accuracy, solver and model of each level, checked in docs/accuracy.md.  A draft is for end
#: forces: it may leave out torsion and motion out of plane if that changes the forces by an
#: estimated 0.2 % at most
LEVELS: dict[Level, dict[str, Any]] = {
    "draft": {
        "accuracy": Accuracy(end_force=1e-2, loop=0.1),
        "solver": Solver(step_max=0.04, newton_tolerance=1e-5),
        "model": Model(force_tolerance=2e-3),
    },
    "standard": {"accuracy": Accuracy(), "solver": Solver(), "model": Model()},
    "reference": {
        "accuracy": Accuracy(end_force=1e-5, loop=4e-4),
        "solver": Solver(step_max=2.5e-3, newton_tolerance=1e-7),
        "model": Model(),
    },
}


def at_level(scene: Scene, level: Level) -> Scene:
    """Return the scene with a fitted mesh and with accuracy, solver and model of a level.

    Parameters
    ----------
    scene : Scene
        Its own mesh, accuracy, solver and model are replaced.
    level : {"draft", "standard", "reference"}
        Standard suits most uses.

    Returns
    -------
    Scene
        A new scene.

    Raises
    ------
    ValueError
        If there is no such level.
    """
    if level not in LEVELS:
        raise ValueError(
            f"level = {level!r} must be one of {', '.join(LEVELS)}; standard suits most uses"
        )
    return scene.with_(mesh=Mesh("auto"), **LEVELS[level])


@dataclass(frozen=True)
class RopeCase:
    """Scene with a winding: the left end starts at the height ``start``, the right end at ``travel``."""

    scene: Scene  #: data of the rope
    travel: float  #: height of the right end, which the left one rises, m
    speed: float  #: largest speed, m/s
    start: float = 0.0  #: height of the left end, m


def rope_120(level: Level = "standard") -> RopeCase:
    """Return the 120 m rope: swivels locked, 90 m of travel at up to 8 m/s."""
    return RopeCase(at_level(Scene(), level), travel=90.0, speed=8.0)


def rope_240(level: Level = "standard") -> RopeCase:
    """Return the 240 m rope: healthy swivels released at t = 20 s, 200 m of travel at up to 10 m/s."""
    swivel = Swivel(mode="coulomb", release_time=20.0)
    scene = Scene(rope=Rope(length=240.0), left=swivel, right=swivel)
    return RopeCase(at_level(scene, level), travel=200.0, speed=10.0)


ROPE_CASES = {"rope-120": rope_120, "rope-240": rope_240}
