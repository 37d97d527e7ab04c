"""Motions of an end whose position, speed and acceleration do not fit."""

from dataclasses import replace

import numpy as np

from rope_model import (
    EndMotion,
)
from rope_model.solver_parameters import FidelityChoice

H = 0.01
TRAVEL = 20.0


def unfit(t: float, fidelity: FidelityChoice) -> EndMotion:
    """Rounded, with time stamps that are off, every third sample sent again, as far as the model can follow."""
    k = round(t / H) - (round(t / H) % 3 == 0)
    at = k * H + np.random.default_rng(abs(k)).uniform(-0.002, 0.002)
    end = EndMotion(y=round(0.25 * at * at, 3), vy=0.5 * at, ay=0.5)
    if fidelity == "rigid":
        return end
    end = replace(end, x=round(0.01 * at * at, 4), vx=0.02 * at, ax=0.02)
    if fidelity == "planar":
        return end
    end = replace(end, z=round(0.02 * at * at, 4), vz=0.04 * at, az=0.04)
    if fidelity == "spatial":
        return end
    return replace(end, yaw=round(0.1 * at * at, 3), yaw_rate=0.2 * at)
