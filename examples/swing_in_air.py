"""How far the loop swings after a winding, with and without air that drags on the rope."""

from dataclasses import replace

from rope_model import Air, EndMotion, balance_rope, rope_120

TRAVEL, DURATION, END, H = 90.0, 20.0, 140.0, 0.02  # m, s


def ends(t: float) -> tuple[EndMotion, EndMotion]:
    """The left conveyance rises by TRAVEL in DURATION, the right one falls."""
    s = min(t / DURATION, 1.0)
    y = TRAVEL * s**3 * (10 - 15 * s + 6 * s * s)
    v = TRAVEL / DURATION * 30 * (s * (1 - s)) ** 2
    a = TRAVEL / DURATION**2 * 60 * s * (1 - s) * (1 - 2 * s)
    return EndMotion(y=y, vy=v, ay=a), EndMotion(y=TRAVEL - y, vy=-v, ay=-a)


def swings(air: Air) -> tuple[float, float]:
    """From side to side (m), in the first 30 s after the winding and in the last."""
    scene = rope_120().scene
    rope = balance_rope(scene.with_(shaft=replace(scene.shaft, air=air)))
    status = rope.initialize(0.0, *ends(0.0))
    read, places = rope.reader(("loop.x",)), []
    for k in range(1, round(END / H) + 1):
        status = rope.advance_to(k * H, *ends(k * H))
        if not status.valid:
            raise RuntimeError(status.message)
        if k * H > DURATION:
            places.append(read()[0])
    some = round(30.0 / H)
    first, last = places[:some], places[-some:]
    return max(first) - min(first), max(last) - min(last)


still, dragged = swings(Air()), swings(Air(density=1.25))
for name, (first, last) in (("without air", still), ("in air", dragged)):
    print(f"{name:12} the loop swings by {first:.3f} m after the winding, {END - DURATION:.0f} s later by {last:.3f} m")
print("part of the swing that the air has taken by then:")
print(1 - dragged[1] / still[1])
