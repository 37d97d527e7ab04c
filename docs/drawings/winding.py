"""The animated winding of the README: the published 240 m rope, wound by 200 m, its swivels released at 20 s."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from rope_model import EndMotion, balance_rope, rope_240

from .pen import Drawing, Point, number, path_of

TRAVEL, DURATION, END = 200.0, 35.0, 50.0  # m, s, s
RELEASE = 20.0  # s, of the case
STEP, FRAME = 0.02, 0.5  # s, of communication and between two frames
SECONDS = 20.0  # that the animation takes


class Frame(NamedTuple):
    """The rope at one instant: its points (m), end forces (N, downwards), yaw (rad), heights of the ends (m)."""

    t: float
    points: list[tuple[float, float, float]]
    pull: tuple[float, float]
    yaw: float
    heights: tuple[float, float]


def ends(t: float) -> tuple[EndMotion, EndMotion]:
    """Return the motion of both ends: the left conveyance rises smoothly, the right one falls."""
    s = min(t / DURATION, 1.0)
    y = TRAVEL * (10 * s**3 - 15 * s**4 + 6 * s**5)
    v = TRAVEL / DURATION * 30 * s**2 * (1 - s) ** 2
    a = TRAVEL / DURATION**2 * (60 * s - 180 * s**2 + 120 * s**3)
    return EndMotion(y=y, vy=v, ay=a), EndMotion(y=TRAVEL - y, vy=-v, ay=-a)


def run() -> list[Frame]:
    """Wind the rope and return the frames."""
    rope = balance_rope(rope_240().scene)
    status = rope.initialize(0.0, *ends(0.0))
    frames, every = [], round(FRAME / STEP)
    for k in range(round(END / STEP) + 1):
        if k:
            status = rope.advance_to(k * STEP, *ends(k * STEP))
        if not status.valid:
            raise RuntimeError(status.message)
        if k % every == 0:
            now = rope.signals()
            count = sum(name.startswith("shape.x[") for name in now)
            points = [
                (now[f"shape.x[{i}]"], now[f"shape.y[{i}]"], now[f"shape.z[{i}]"])
                for i in range(1, count + 1)
            ]
            left, right = ends(k * STEP)
            pull = -now["left.fy"], -now["right.fy"]
            frames.append(Frame(k * STEP, points, pull, now["loop.yaw"], (left.y, right.y)))
    return frames


@dataclass(frozen=True)
class Animation:
    """A drawing with parts that move, one value a frame."""

    d: Drawing

    def path(self, frames: list[list[Point]], kind: str, width: float) -> None:
        """Draw a polyline that changes its shape."""
        data = [path_of(points) for points in frames]
        self.d.add(
            f'<path class="{kind}" d="{data[0]}" style="stroke-width:{number(width)}">{_animate("d", data)}</path>'
        )

    def shift(self, part: str, places: list[Point], start: Point = (0.0, 0.0)) -> None:
        """Draw a part that moves."""
        data = [f"{number(x)} {number(y)}" for x, y in places]
        moves = _timing(data).replace(
            "<animate ", '<animateTransform attributeName="transform" type="translate" '
        )
        self.d.add(f'<g transform="translate({data[0]})">{part}{moves}</g>')

    def turn(self, part: str, angles: list[float], at: Point) -> None:
        """Draw a part that turns, degrees clockwise."""
        data = [f"{number(a)} {number(at[0])} {number(at[1])}" for a in angles]
        moves = _timing(data).replace(
            "<animate ", '<animateTransform attributeName="transform" type="rotate" '
        )
        self.d.add(f"<g>{part}{moves}</g>")


def _timing(data: list[str]) -> str:
    return f'<animate values="{";".join(data)}" dur="{number(SECONDS)}s" repeatCount="indefinite"/>'


def _animate(attribute: str, data: list[str]) -> str:
    return _timing(data).replace("<animate ", f'<animate attributeName="{attribute}" ')


def _shaft(a: Animation, frames: list[Frame]) -> None:
    """Draw the whole hoist, wider than it is."""
    d, x0, top, scale, wide = a.d, 112.0, 54.0, 1.3, 24.0

    def at(x: float, y: float) -> Point:
        return x0 + wide * x, 388.0 - scale * (y + 24.0)

    d.text(x0, 20, f"the hoist, {wide / scale:.0f} times as wide", "soft", "middle", 13)
    for side in (-1, 1):
        d.line([(x0 + side * 76, 46), (x0 + side * 76, 394)], "faint", 5)
    d.line([(x0 - 76, 394), (x0 + 76, 394)], "faint", 5)
    d.dot(x0, top, wide, "ink", "")
    spokes = f'<path class="ink" d="M{x0 - wide:g} {top:g}H{x0 + wide:g}M{x0:g} {top - wide:g}V{top + wide:g}"/>'
    # the sheave's rim moves as the drawn ropes do
    a.turn(spokes, [math.degrees(f.heights[0] * scale / wide) for f in frames], (x0, top))
    for side in (0, 1):
        x = x0 + (2 * side - 1) * wide
        places = [(0.0, at(0, f.heights[side])[1]) for f in frames]
        a.path([[(x, top), (x, y - 28)] for _, y in places], "soft", 1.8)
        colour = ("left", "right")[side]
        place = f'x="{x - 14:g}" y="-28" width="28" height="28" rx="2"'
        box = f'<rect class="{colour} fill-faint" {place}/>'
        a.shift(box, places)
    a.path([[at(p[0], p[1]) for p in f.points[::2]] for f in frames], "rope", 2.4)


def _loop(a: Animation, frames: list[Frame]) -> None:
    """Draw the loop in its true shape, seen from the side above, and from above."""
    d, scale, turn, tilt = a.d, 44.0, math.radians(28), math.radians(14)
    lowest = min(p[1] for f in frames for p in f.points)
    d.text(350, 20, "its loop, from the side, to scale", "soft", "middle", 13)

    def seen(p: tuple[float, float, float]) -> Point:
        x, y, z = p[0], p[1] - lowest, p[2]
        right, depth = (
            x * math.cos(turn) - z * math.sin(turn),
            x * math.sin(turn) + z * math.cos(turn),
        )
        return 350 + scale * right, 286 - scale * (y * math.cos(tilt) - depth * math.sin(tilt))

    d.add(
        '<clipPath id="c"><rect x="204" y="30" width="292" height="284"/></clipPath><g clip-path="url(#c)">'
    )
    halves = [_halves(f.points) for f in frames]
    for side, kind in enumerate(("left", "right")):
        a.path([[seen(p) for p in half[side]] for half in halves], kind, 4)
    d.add("</g>")
    d.text(350, 326, "and from above", "soft", "middle", 13)
    a.d.line([(262, 366), (438, 366)], "faint", 1.4)
    for x in (350 - scale, 350 + scale):
        d.dot(x, 366, 3, "soft", "soft")
    for side, kind in enumerate(("left", "right")):
        a.path(
            [[(350 + scale * p[0], 366 + scale * p[2]) for p in half[side]] for half in halves],
            kind,
            3,
        )


def _halves(
    points: list[tuple[float, float, float]], around: int = 28
) -> tuple[list[tuple[float, float, float]], ...]:
    """Return the points left and right of the lowest one, so many of each."""
    low = min(range(len(points)), key=lambda i: points[i][1])
    low = min(max(low, around), len(points) - 1 - around)
    return points[low - around : low + 1], points[low : low + around + 1]


def _plots(a: Animation, frames: list[Frame]) -> None:
    """Draw what the rope answers, and where the animation is."""
    d, x0, width = a.d, 540.0, 300.0

    def across(t: float) -> float:
        return x0 + width * t / END

    panels = (
        (60.0, 190.0, "pull on the conveyances, kN", 0.0, 20.0, (0, 10, 20)),
        (240.0, 370.0, "yaw of the loop, degrees", -15.0, 15.0, (-15, 0, 15)),
    )
    for top, bottom, name, low, high, marks in panels:
        d.text(x0, top - 14, name, "ink", "start", 14)
        for mark in marks:
            y = bottom - (bottom - top) * (mark - low) / (high - low)
            d.line([(x0, y), (x0 + width, y)], "faint", 1)
            d.text(x0 - 8, y + 4, f"{mark}".replace("-", "−"), "soft", "end", 12)
        d.line([(across(RELEASE), top), (across(RELEASE), bottom)], "soft", 1, "4 4")
        if low < 0:
            kinds = [("mark", [math.degrees(f.yaw) for f in frames])]
        else:
            kinds = [
                ("left", [f.pull[0] / 1e3 for f in frames]),
                ("right", [f.pull[1] / 1e3 for f in frames]),
            ]
        for kind, values in kinds:
            rows = [bottom - (bottom - top) * (v - low) / (high - low) for v in values]
            d.line([(across(f.t), y) for f, y in zip(frames, rows, strict=True)], kind, 1.8)
            spot = f'<circle class="{kind} fill-{kind}" r="4"/>'
            a.shift(spot, [(across(f.t), y) for f, y in zip(frames, rows, strict=True)])
    d.text(across(RELEASE) - 6, 364, "swivels released", "soft", "end", 12)
    for t in (0, 10, 20, 30, 40, 50):
        d.text(across(t), 388, f"{t} s" if t == 50 else f"{t}", "soft", "middle", 12)


def winding() -> Drawing:
    """Run the winding and draw it."""
    d = Drawing(
        860,
        404,
        "A winding of the 240 m rope: the hoist, the loop, the end forces and the loop's yaw",
    )
    a, frames = Animation(d), run()
    _shaft(a, frames)
    _loop(a, frames)
    _plots(a, frames)
    return d
