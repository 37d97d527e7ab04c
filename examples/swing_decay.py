"""Swing of the loop after a winding: without losses, in air, and with wires that rub."""

from dataclasses import replace

from rope_model import Air, EndMotion, balance_rope, rope_120

TRAVEL = 90.0  # m
DURATION = 20.0  # s, of the trip
END = 140.0  # s
H = 0.02  # s, communication step
WINDOW = 30.0  # s, in which a swing is measured


def ends(t: float) -> tuple[EndMotion, EndMotion]:
    """The left conveyance rises by TRAVEL in DURATION, the right one falls."""
    s = min(t / DURATION, 1.0)
    y = TRAVEL * s**3 * (10 - 15 * s + 6 * s * s)
    v = TRAVEL / DURATION * 30 * (s * (1 - s)) ** 2
    a = TRAVEL / DURATION**2 * 60 * s * (1 - s) * (1 - 2 * s)
    return EndMotion(y=y, vy=v, ay=a), EndMotion(y=TRAVEL - y, vy=-v, ay=-a)


def swings(air: Air, EI_stick: float) -> tuple[float, float]:
    """From side to side (m), in the first 30 s after the winding and in the last."""
    scene = rope_120().scene
    rubbing = replace(scene.rope, EI_stick=EI_stick)
    rope = balance_rope(scene.with_(rope=rubbing, shaft=replace(scene.shaft, air=air)))
    status = rope.initialize(0.0, *ends(0.0))
    read = rope.reader(("loop.x",))
    places = []
    for k in range(1, round(END / H) + 1):
        status = rope.advance_to(k * H, *ends(k * H))
        if not status.valid:
            raise RuntimeError(status.message)
        if k * H > DURATION:
            places.append(read()[0])
    count = round(WINDOW / H)
    first = places[:count]
    last = places[-count:]
    return max(first) - min(first), max(last) - min(last)


smooth = 0.0  # N m^2: no friction
stuck = 2.4e4  # N m^2: no wire slides while friction holds
cases = {
    "without losses": swings(Air(), smooth),
    "in air": swings(Air(density=1.25), smooth),
    "wires that rub": swings(Air(), stuck),
}
for name, (first, last) in cases.items():
    print(
        f"{name:15} the loop swings by {first:.3f} m after the winding, "
        f"{END - DURATION:.0f} s later by {last:.3f} m"
    )
print("parts of the swing that wires and air have taken by then:")
least = cases["without losses"][1]
print(1 - cases["wires that rub"][1] / least, 1 - cases["in air"][1] / least)
