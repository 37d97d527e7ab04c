"""A host of one's own: the left conveyance rises by 10 m in 8 s while the right one falls.

It prints the end forces every second.
"""

from dataclasses import replace

from rope_model import SIGNALS, BalanceRope, EndMotion, Swivel, balance_rope, rope_120

FORCES = ("left.fy", "right.fy")


def ends(t: float) -> tuple[EndMotion, EndMotion]:
    """One smooth motion: of the left end from 0 m up, of the right end from 90 m down."""
    s = min(t / 8.0, 1.0)
    y = 10.0 * (10 * s**3 - 15 * s**4 + 6 * s**5)
    v = 10.0 / 8.0 * 30 * s**2 * (1 - s) ** 2
    a = 10.0 / 8.0**2 * (60 * s - 180 * s**2 + 120 * s**3)
    return EndMotion(y=y, vy=v, ay=a), EndMotion(y=90.0 - y, vy=-v, ay=-a)


def wind(rope: BalanceRope, seconds: int) -> dict[str, float]:
    """The end forces (N) after so many seconds in steps of 10 ms."""
    for k in range(round(100 * rope.time) + 1, 100 * seconds + 1):
        status = rope.advance_to(0.01 * k, *ends(0.01 * k))
        if not status.valid:
            raise RuntimeError(status.message)
    return rope.signals(FORCES)


scene = rope_120().scene
scene = scene.with_(
    rope=replace(scene.rope, EI=500.0), right=Swivel(mode="coulomb", release_time=1.0)
)
rope = balance_rope(scene)
print(
    rope.initialize(0.0, *ends(0.0)),
    f"{rope.elements} elements, {rope.form}, {rope.fidelity}: {rope.fidelity_reason}",
)
for second in range(1, 10):
    saved = rope.save()
    first = wind(rope, second)
    rope.restore(saved)  # one second back
    print(
        second, "s", first, SIGNALS["left.fy"].unit, "again the same:", wind(rope, second) == first
    )
print(len(rope.signals()), "signals;", rope.added_mass(), "kg;", rope.warnings() or "no warnings")
