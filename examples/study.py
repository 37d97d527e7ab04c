"""A study in Python: the largest pull of an elastic and of a rigid balance rope.

The pull is that of an end whose conveyance speeds up. The runs are shared among two processes.
Windings with the whole hoist: balance-rope study.
"""

import math
from concurrent.futures import ProcessPoolExecutor
from itertools import product

from rope_model import EndMotion, Model, balance_rope, rope_120
from rope_model.solver_parameters import FidelityChoice

LOW = 40.0  # m
DURATION = 4.0  # s
H = 0.01  # s, communication step
ACCELERATIONS = (0.5, 1.0, 2.0)  # m/s^2, the largest of each run
MODELS: tuple[FidelityChoice, ...] = ("torsional", "rigid")


def rise(t: float, largest: float) -> tuple[float, float, float]:
    """Way (m), speed and acceleration from rest; the acceleration is a sine squared."""
    w = 2 * math.pi / DURATION
    y = largest * (t**2 / 4 + (math.cos(w * t) - 1) / (2 * w**2))
    v = largest * (t / 2 - math.sin(w * t) / (2 * w))
    return y, v, largest * math.sin(w * t / 2) ** 2


def largest_pull(case: tuple[float, FidelityChoice]) -> float:
    """N, on the right conveyance, which goes up."""
    acceleration, model = case
    rope = balance_rope(rope_120().scene.with_(model=Model(model)))
    status = rope.initialize(0.0, EndMotion(y=LOW), EndMotion(y=LOW))
    pulls = []
    for k in range(1, round(DURATION / H) + 1):
        y, v, a = rise(H * k, acceleration)
        left = EndMotion(y=LOW - y, vy=-v, ay=-a)
        right = EndMotion(y=LOW + y, vy=v, ay=a)
        status = rope.advance_to(H * k, left, right)
        if not status.valid:
            raise RuntimeError(status.message)
        pulls.append(-rope.signals(("right.fy",))["right.fy"])
    return max(pulls)


if __name__ == "__main__":
    cases = list(product(ACCELERATIONS, MODELS))
    with ProcessPoolExecutor(2) as pool:
        pulls = dict(zip(cases, pool.map(largest_pull, cases), strict=True))
    for a in ACCELERATIONS:
        elastic, rigid = (pulls[a, model] for model in MODELS)
        print(
            f"{a} m/s^2: {elastic:.1f} N, a rigid rope {rigid:.1f} N, "
            f"over the elastic one's {rigid / elastic:.6f}"
        )
