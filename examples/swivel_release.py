"""A rope with half a turn of installed twist; its swivels are released after one second."""

import math
from dataclasses import replace

from rope_model import EndMotion, Swivel, balance_rope, rope_120

RELEASE = 1.0  # s
END = 40.0  # s
H = 0.02  # s, communication step
SIGNALS = ("left.swivel.angle", "left.swivel.torque", "left.swivel.slipping", "loop.yaw")
# ten times the friction of a healthy bearing
SWIVEL = Swivel(mode="coulomb", mu_static=0.018, mu_kinetic=0.013, release_time=RELEASE)

scene = rope_120().scene
scene = scene.with_(rope=replace(scene.rope, installed_twist=math.pi), left=SWIVEL, right=SWIVEL)
rope = balance_rope(scene)
ends = EndMotion(y=0.0), EndMotion(y=0.0)
status = rope.initialize(0.0, *ends)
slips = False
for k in range(round(END / H)):
    status = rope.advance_to(H * (k + 1), *ends)
    if not status.valid:
        raise RuntimeError(status.message)
    turned, torque, slipping, yaw = rope.signals(SIGNALS).values()
    if k % 100 == 49 or bool(slipping) != slips:
        slips = bool(slipping)
        print(
            f"{rope.time:6.2f} s  torque {torque:7.2f} N m, turned by {turned:5.3f} rad, "
            f"loop yawed by {math.degrees(yaw):5.1f} deg, {'slips' if slips else 'holds'}"
        )
tension = -rope.signals(("left.fy",))["left.fy"]
limit = 0.5 * SWIVEL.mu_static * SWIVEL.mean_diameter * tension
print("torque that is left, over the swivel's static limit:")
print(abs(rope.signals(("left.swivel.torque",))["left.swivel.torque"]) / limit)
