"""A rope in moving air."""

from rope_model import (
    EndMotion,
    Mesh,
)
from rope_model.parameters import Rope, Scene
from rope_model.shaft_parameters import Air, Shaft, Sump

STEP = 0.01
LENGTH = 10.0


def scene(**air: float) -> Scene:
    rope = Rope(length=LENGTH)
    shaft = Shaft(air=Air(**air), sump=Sump(level=-4.2))
    return Scene(rope=rope, mesh=Mesh("eem", elements=10), shaft=shaft)


def ends(t: float) -> tuple[EndMotion, EndMotion]:
    """Both go aside and down at a growing speed."""
    left, right = (
        EndMotion(x=2 * t**3, vx=6 * t**2, ax=12 * t, y=-y * t**3, vy=-3 * y * t**2, ay=-6 * y * t)
        for y in (2.0, 1.0)
    )
    return left, right
