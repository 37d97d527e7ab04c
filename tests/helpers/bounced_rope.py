"""A short rope whose ends bounce."""

from scenes import smooth_step

from rope_model import (
    EndMotion,
)
from rope_model.parameters import Rope, Swivel


def bounce(t: float) -> tuple[EndMotion, EndMotion]:
    """The left end is dropped by .5 m faster than the rope falls, and caught."""
    y, v, a = (-0.5 * x for x in smooth_step(t, 0.1, 0.3))
    return EndMotion(y=y, vy=v, ay=a), EndMotion()


SWIVEL = Swivel(mode="coulomb", release_time=0.5)

SHORT = Rope(length=60.0, installed_twist=1.5)
