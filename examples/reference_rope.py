"""Two forms of one rope on one motion: the engine in C, and the published system in plain Python.

They share tables and formulas, and no control flow: what one of them does wrong shows as a difference.
"""

from dataclasses import replace

from rope_model import BalanceRope, EndMotion, balance_rope, rope_120

END = 3.0  # s
H = 0.02  # s, communication step
TRAVEL = 1.0  # m, of the left end in END, upwards; the right end falls as far
SIGNALS = ("left.fy", "right.fy", "loop.y", "loop.yaw")


def ends(t: float) -> tuple[EndMotion, EndMotion]:
    """Return the motions of both ends, which rest at 0 and at END."""
    s = t / END
    y = TRAVEL * (10 * s**3 - 15 * s**4 + 6 * s**5)
    v = TRAVEL / END * 30 * (s * (1 - s)) ** 2
    a = TRAVEL / END**2 * 60 * s * (1 - s) * (1 - 2 * s)
    return EndMotion(y=y, vy=v, ay=a), EndMotion(y=30.0 - y, vy=-v, ay=-a)


def followed(rope: BalanceRope) -> list[dict[str, float]]:
    """Return the signals after each step."""
    status = rope.initialize(0.0, *ends(0.0))
    rows = []
    for k in range(round(END / H)):
        t = H * (k + 1)
        status = rope.advance_to(t, *ends(t))
        if not status.valid:
            raise RuntimeError(status.message)
        rows.append(rope.signals(SIGNALS))
    return rows


scene = rope_120().scene
# a rope of 60 m: the reference takes milliseconds for a step
scene = scene.with_(rope=replace(scene.rope, length=60.0))
scene = scene.with_(model=replace(scene.model, fidelity="torsional"))
engine = followed(balance_rope(scene))
reference = followed(balance_rope(scene, form="reference"))
for name in SIGNALS:
    largest = max(abs(row[name]) for row in engine)
    difference = max(abs(one[name] - two[name]) for one, two in zip(engine, reference, strict=True))
    print(f"{name:<9} largest {largest:11.5g}, difference {difference:9.2g}")
forces = [abs(one["left.fy"] / two["left.fy"]) for one, two in zip(engine, reference, strict=True)]
print("pull on the left end, engine over reference, at the end:")
print(forces[-1])
