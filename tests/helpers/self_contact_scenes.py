"""A rope whose legs press each other."""

import math
from typing import Any

from rope_model import (
    Contact,
    EndMotion,
    Layout,
    Mesh,
    Rope,
    Scene,
    Shaft,
    Solver,
    Swivel,
)

D = Rope().diameter
K = 1e6

STEP = 0.01


def twisted(stiffness: float = K, **parts: Any) -> Scene:
    """A short rope, the legs of which come to lie against each other as its held ends twist it."""
    shaft = Shaft(contact=Contact(rope_stiffness=stiffness))
    mesh = Mesh("eem", elements=8)
    held = Scene(
        Rope(length=6.0, EI=100.0), Layout(0.3), left=Swivel("locked"), right=Swivel("locked")
    )
    return held.with_(shaft=shaft, mesh=mesh, solver=Solver(step_max=STEP, tolerance=1e3)).with_(
        **parts
    )


def end(t: float, turns: float, time: float) -> EndMotion:
    """Either end turns so far in this time, and twists the rope by as much."""
    s = min(t / time, 1.0)
    turn = 2.0 * math.pi * turns
    return EndMotion(
        yaw=turn * s**3 * (10 - 15 * s + 6 * s * s), yaw_rate=turn * 30 * (s * (1 - s)) ** 2 / time
    )
