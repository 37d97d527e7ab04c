"""Air in the shaft during a winding: at rest, pushed by a conveyance, blown by a gallery."""

from dataclasses import replace
from functools import cache

import numpy as np

from rope_model import Air, EndMotion, balance_rope, rope_120

TRAVEL = 90.0  # m
DURATION = 20.0  # s, of the trip
END = 40.0  # s
H = 0.02  # s, communication step
LOOP = ("loop.x", "loop.z")
SIDES = ("left.fx", "left.fz", "right.fx", "right.fz")
STILL = Air(density=1.2)
GALLERY = replace(STILL, cross_y=TRAVEL / 2, cross_height=5.0)


def ends(t: float) -> tuple[EndMotion, EndMotion]:
    """The left conveyance rises by TRAVEL in DURATION, the right one falls."""
    s = min(t / DURATION, 1.0)
    y = TRAVEL * s**3 * (10 - 15 * s + 6 * s * s)
    v = TRAVEL / DURATION * 30 * (s * (1 - s)) ** 2
    a = TRAVEL / DURATION**2 * 60 * s * (1 - s) * (1 - 2 * s)
    return EndMotion(y=y, vy=v, ay=a), EndMotion(y=TRAVEL - y, vy=-v, ay=-a)


@cache
def wind(air: Air) -> np.ndarray:
    """The loop's place (m) and the ends' side forces (N) over the winding and as long after it."""
    scene = rope_120().scene
    rope = balance_rope(scene.with_(shaft=replace(scene.shaft, air=air)))
    status = rope.initialize(0.0, *ends(0.0))
    rows = []
    read = rope.reader((*LOOP, *SIDES))
    for k in range(1, round(END / H) + 1):
        status = rope.advance_to(k * H, *ends(k * H))
        if not status.valid:
            raise RuntimeError(status.message)
        rows.append(read())
    return np.array(rows)


cases = {
    "air at rest": (STILL, Air()),
    "conveyances of 6 m, b = 0.06": (replace(STILL, buffet=0.06, buffet_length=6.0), STILL),
    "conveyances of 6 m, b = 0.3": (replace(STILL, buffet=0.3, buffet_length=6.0), STILL),
    "10 m/s in a gallery, along x": (replace(GALLERY, vx=10.0), STILL),
    "10 m/s in a gallery, along z": (replace(GALLERY, vz=10.0), STILL),
    "10 m/s everywhere, along x": (replace(STILL, vx=10.0), STILL),
    "10 m/s everywhere, along z": (replace(STILL, vz=10.0), STILL),
}
print(f"{'changes by at most':32}{'loop, m':>10}{'side force, N':>16}")
for name, (air, before) in cases.items():
    change = np.abs(wind(air) - wind(before)).max(axis=0)
    loop = change[: len(LOOP)].max()
    force = change[len(LOOP) :].max()
    print(f"{name:32}{loop:10.5f}{force:16.2f}")
