"""A curvature that the reel left in the rope: in the loop's plane, across it, and against it."""

import math
from dataclasses import replace

from rope_model import EndMotion, balance_rope, rope_120

TRAVEL = 90.0  # m
DURATION = 20.0  # s
H = 0.02  # s, communication step
# assumed: a tenth of what a reel with a radius of 2 m bends
CURVATURE = 0.05  # 1/m


def ends(t: float) -> tuple[EndMotion, EndMotion]:
    """The left conveyance rises by TRAVEL in DURATION, the right one falls."""
    s = min(t / DURATION, 1.0)
    y = TRAVEL * s**3 * (10 - 15 * s + 6 * s * s)
    v = TRAVEL / DURATION * 30 * (s * (1 - s)) ** 2
    a = TRAVEL / DURATION**2 * 60 * s * (1 - s) * (1 - 2 * s)
    return EndMotion(y=y, vy=v, ay=a), EndMotion(y=TRAVEL - y, vy=-v, ay=-a)


def winding(curvature: float, angle: float) -> tuple[float, float, float]:
    """Least and largest yaw of the loop (rad), and the end moment in its plane at first (N m)."""
    scene = rope_120().scene
    bent = replace(scene.rope, initial_curvature=curvature, initial_curvature_angle=angle)
    rope = balance_rope(scene.with_(rope=bent))
    status = rope.initialize(0.0, *ends(0.0))
    read = rope.reader(("loop.yaw", "left.mz"))
    seen = [read()]
    for k in range(1, round(DURATION / H) + 1):
        status = rope.advance_to(k * H, *ends(k * H))
        if not status.valid:
            raise RuntimeError(status.message)
        seen.append(read())
    yaws = [yaw for yaw, _ in seen]
    return min(yaws), max(yaws), seen[0][1]


cases = {
    "straight": winding(0.0, 0.0),
    "as the loop bends": winding(CURVATURE, 0.0),
    "across": winding(CURVATURE, 0.5 * math.pi),
    "against the loop": winding(CURVATURE, 0.9 * math.pi),
}
for name, (least, largest, moment) in cases.items():
    turned = f"{math.degrees(least):6.1f} to {math.degrees(largest):5.1f} deg"
    print(f"{name:18} the loop yaws by {turned}, the left end takes {moment:6.1f} N m at first")
added = cases["straight"][2] - cases["as the loop bends"][2]
print("moment that the curvature adds in the loop's plane, over EI times the curvature:")
print(added / (rope_120().scene.rope.EI * CURVATURE))
