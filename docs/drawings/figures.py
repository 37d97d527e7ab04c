"""The drawn figures of the README and the theory manual; run by ``python -m docs.drawings``."""

import itertools
import math

from .pen import Drawing, Point


def _loop(left: Point, right: Point, bottom: float) -> str:
    """Return the path data of a rope that hangs between two ends in a U."""
    radius = (right[0] - left[0]) / 2
    arc = f"A{radius:g} {radius:g} 0 0 0 {right[0]:g} {bottom - radius:g}"
    return f"M{left[0]:g} {left[1]:g}V{bottom - radius:g}{arc}V{right[1]:g}"


def _hoist(
    d: Drawing, x: float, top: float, left: float, right: float, bottom: float
) -> tuple[Point, Point]:
    """Draw sheave, hoisting ropes, conveyances and balance rope about the middle ``x``; return the rope's ends."""
    half, size, radius = 62.0, (52.0, 74.0), 62.0
    for side in (-1, 1):
        d.line([(x + side * 118, top - 10), (x + side * 118, bottom + 34)], "faint", 6)
    d.line([(x - 118, bottom + 34), (x + 118, bottom + 34)], "faint", 6)
    d.dot(x, top, radius, "ink", "")
    d.dot(x, top, 5)
    for side, y in ((-1, left), (1, right)):
        d.line([(x + side * half, top), (x + side * half, y)], "soft", 2.4)
        d.box(x + side * half - size[0] / 2, y, *size, "ink", "faint", 3)
        d.line([(x + side * half, y + size[1]), (x + side * half, y + size[1] + 14)], "ink", 6)
    ends = (x - half, left + size[1] + 14), (x + half, right + size[1] + 14)
    d.curve(_loop(*ends, bottom), "rope", 3.4)
    return ends


def balance_rope() -> Drawing:
    """Draw what a balance rope is, for a reader who has never seen one."""
    d = Drawing(
        860,
        436,
        "A friction hoist: two conveyances hang over a sheave, and a balance rope hangs below them in a U",
    )
    x, top, bottom = 300.0, 74.0, 372.0
    _left, _right = _hoist(d, x, top, 140.0, 224.0, bottom)
    d.turn(x, top, 42, -140, -40)
    d.arrow((x - 62, 196), (x - 62, 158), "ink", 2.4)
    d.arrow((x + 62, 242), (x + 62, 280), "ink", 2.4)
    notes = [
        (86, 66, (238, 66), "friction sheave,", "driven by the motor", "end"),
        (150, 124, (236, 124), "hoisting ropes", "", "end"),
        (150, 172, (210, 172), "conveyance,", "rising", "end"),
        (150, 222, (234, 222), "swivel", "", "end"),
        (150, 290, (236, 290), "left leg", "", "end"),
    ]
    for _, y, tip, first, second, anchor in notes:
        d.text(172, y + 5, first, "ink", anchor)
        if second:
            d.text(172, y + 23, second, "ink", anchor)
        d.line([(178, y), tip], "soft", 1)
    d.text(430, 266, "conveyance,")
    d.text(430, 284, "sinking")
    d.line([(424, 261), (390, 261)], "soft", 1)
    d.text(430, 334, "balance rope:", "rope")
    d.text(430, 352, "as heavy per metre as the hoisting", "rope")
    d.text(430, 370, "ropes, so the motor lifts no rope", "rope")
    d.line([(424, 330), (366, 326)], "soft", 1)
    d.text(300, 428, "shaft sump", "soft", "middle")

    # what goes wrong: a view from above, and the end
    d.line([(704, 20), (704, 250)], "faint")
    d.text(520, 36, "Seen from above", "soft")
    d.line([(500, 130), (670, 130)], "soft", 1, "5 5")
    d.dot(520, 130, 5, "ink", "ink")
    d.dot(650, 130, 5, "ink", "ink")
    angle = math.radians(24)
    dx, dy = 65 * math.cos(angle), 65 * math.sin(angle)
    d.line([(520, 130), (585 - dx, 130 + dy)], "rope", 1.4, "3 4")
    d.line([(650, 130), (585 + dx, 130 - dy)], "rope", 1.4, "3 4")
    d.line([(585 - dx, 130 + dy), (585 + dx, 130 - dy)], "rope", 3.4)
    d.turn(585, 130, 84, 0, -22, "mark")
    d.text(676, 122, "yaw", "mark", "start", 13)
    d.text(500, 196, "Its weight twists the rope:", "ink")
    d.text(500, 214, "the loop yaws, the legs", "ink")
    d.text(500, 232, "swing out and may tangle.", "ink")
    d.text(722, 36, "The swivel", "soft")
    d.line([(740, 60), (830, 60)], "ink", 5)
    d.box(767, 62, 36, 44, "ink", "faint", 3)
    d.line([(760, 90), (767, 90)], "ink", 3)
    d.line([(803, 90), (810, 90)], "ink", 3)
    d.line([(785, 106), (785, 166)], "rope", 5)
    d.turn(785, 140, 24, 150, -160, "mark", 0.4)
    d.text(722, 196, "Dry friction holds", "ink")
    d.text(722, 214, "the rope's torque", "ink")
    d.text(722, 232, "or lets it turn.", "ink")
    return d


def hoist() -> Drawing:
    """Draw the hoist with the rope's coordinates."""
    d = Drawing(760, 500, "Coordinates of the balance rope in the hoist")
    x, top, bottom = 330.0, 84.0, 436.0
    left, right = _hoist(d, x, top, 150.0, 262.0, bottom)
    # axes at the lower landing
    zero = 388.0
    d.arrow((70, zero), (130, zero))
    d.arrow((70, zero), (70, zero - 60))
    d.dot(70, zero, 6, "ink", "paper")
    d.dot(70, zero, 1.5)
    d.text(124, zero - 8, "$X$")
    d.text(64, zero - 68, "$Y$")
    d.text(48, zero + 20, "$Z$")
    d.line([(136, zero), (600, zero)], "soft", 1, "5 5")
    d.text(606, zero + 5, "$Y$ = 0", "soft")
    # places of the ends
    d.line([left, (196, left[1])], "soft", 1, "4 4")
    d.arrow((200, zero), (200, left[1]), "soft", 1.2, both=True)
    d.text(192, 320, "$y_L$", "soft", "end")
    d.line([right, (520, right[1])], "soft", 1, "4 4")
    d.arrow((516, zero), (516, right[1]), "soft", 1.2, both=True)
    d.text(524, 374, "$y_R$", "soft")
    d.line([left, (572, left[1])], "soft", 1, "4 4")
    d.line([right, (572, right[1])], "soft", 1, "4 4")
    d.arrow((566, left[1]), (566, right[1]), "soft", 1.2, both=True)
    d.text(574, 300, "$H = y_L − y_R$", "soft")
    d.arrow((268, 462), (392, 462), "soft", 1.2, both=True)
    d.text(330, 482, "$D$, the spacing", "soft", "middle")
    # arc length, tangent, section
    d.text(left[0] + 10, left[1] + 6, "$s$ = 0", "rope")
    d.text(right[0] - 10, right[1] + 4, "$s$ = $L$", "rope", "end")
    d.arrow((268, 300), (268, 352), "mark", 2.4)
    d.text(278, 346, "$t$", "mark")
    d.turn(268, 322, 17, 200, 520, "mark", 0.4)
    d.text(290, 322, "$θ$, $M$", "mark")
    d.dot(330, bottom, 4.5, "rope", "rope")
    d.text(330, bottom - 12, "lowest point", "rope", "middle", 13)
    d.text(600, 60, "twist and torque are", "ink")
    d.text(600, 78, "positive about $t$", "ink")
    return d


def element() -> Drawing:
    """Draw the element, its degrees of freedom and the frame of a section."""
    d = Drawing(760, 330, "The beam element: position, slope and angle at two nodes")
    a, b = (150.0, 210.0), (560.0, 120.0)
    da, db = (300.0, -190.0), (330.0, 200.0)
    points = []
    for i in range(61):
        u = i / 60
        h = (2 * u**3 - 3 * u**2 + 1, u**3 - 2 * u**2 + u, 3 * u**2 - 2 * u**3, u**3 - u**2)
        points.append(
            tuple(h[0] * a[k] + h[1] * da[k] + h[2] * b[k] + h[3] * db[k] for k in (0, 1))
        )
    d.line([(p[0], p[1]) for p in points], "rope", 4)
    origin = (70.0, 292.0)
    d.dot(*origin, 3)
    d.text(52, 316, "origin", "soft", "start", 13)
    for node, slope, i in ((a, da, 1), (b, db, 2)):
        d.arrow(origin, node, "soft", 1.2)
        length = math.hypot(*slope)
        tip = (node[0] + 100 * slope[0] / length, node[1] + 100 * slope[1] / length)
        d.arrow(node, tip, "ink", 2.2)
        d.dot(*node, 6, "ink", "ink")
        d.text(tip[0] + 4, tip[1] + 20, f"$r′_{i}$")
        mid = (node[0] + 48 * slope[0] / length, node[1] + 48 * slope[1] / length)
        d.turn(*mid, 19, 120, 420, "mark", 0.36, math.degrees(math.atan2(slope[1], slope[0])))
        d.text(mid[0] + (-34 if i == 1 else 12), mid[1] - 20, f"$θ_{i}$", "mark")
    d.text(84, 226, "$r_1$", "soft")
    d.text(330, 234, "$r_2$", "soft")
    # a section
    k = 30
    (px, py), (nx, ny) = points[k], points[k + 1]
    length = math.hypot(nx - px, ny - py)
    t = ((nx - px) / length, (ny - py) / length)
    d.arrow((px, py), (px + 62 * t[0], py + 62 * t[1]), "ink", 1.8)
    d.text(px + 66 * t[0] - 2, py + 66 * t[1] - 10, "$t$ = $r′$/|$r′$|")
    d.arrow((px, py), (px - 46 * t[1] * -1, py - 46 * t[0]), "ink", 1.8)
    d.arrow((px, py), (px - 26, py + 30), "ink", 1.8)
    d.text(px - 4, py - 56, "$e_1$")
    d.text(px - 46, py + 46, "$e_2$")
    d.dot(px, py, 3.5)
    d.text(600, 232, "$x$ = $l$", "soft")
    d.text(130, 240, "$x$ = 0", "soft")
    d.text(420, 292, "each node: $r$ (3), $r′$ (3), $θ$ (1);", "ink")
    d.text(420, 312, "two nodes, 14 degrees of freedom", "ink")
    return d


def swivel() -> Drawing:
    """Draw the swivel and its set-valued law."""
    d = Drawing(760, 320, "The swivel and its friction law")
    d.line([(70, 40), (250, 40)], "ink", 6)
    d.text(160, 26, "conveyance", "ink", "middle")
    d.box(130, 43, 60, 80, "ink", "faint", 4)
    d.box(122, 96, 76, 18, "ink", "paper", 3)
    for i in range(4):
        d.dot(134 + 17.4 * i, 105, 6, "soft", "")
    d.line([(160, 123), (160, 262)], "rope", 6)
    d.turn(160, 168, 30, 160, -150, "mark", 0.36)
    d.text(200, 174, "$b$, $M$", "mark")
    d.arrow((160, 232), (160, 290), "ink", 2)
    d.text(170, 290, "$T$")
    d.text(208, 110, "bearing, mean diameter $d_m$", "soft", "start", 13)
    x, y, ms, mk = 560.0, 165.0, 96.0, 66.0
    d.arrow((400, y), (730, y))
    d.arrow((x, 300), (x, 26))
    d.text(722, y + 22, "$ḃ$")
    d.text(x + 10, 34, "$M$ on the rope")
    d.line([(410, y - mk), (x, y - mk)], "rope", 4)
    d.line([(x, y + mk), (715, y + mk)], "rope", 4)
    d.line([(x, y - ms), (x, y + ms)], "rope", 4)
    for sign, word, where in ((-1, "", "start"), (1, "−", "end")):
        d.text(x + (10 if sign < 0 else -10), y + sign * ms + 5, f"{word}$M_s$", "ink", where)
    d.text(x + 10, y - mk + 5, "$M_k$")
    d.text(x - 10, y + mk + 5, "−$M_k$", "ink", "end")
    d.text(418, y - mk - 12, "slip", "rope")
    d.text(684, y + mk - 12, "slip", "rope")
    d.text(x + 12, y - 10, "stick", "rope")
    return d


COUNTS = (4, 2, 2, 6, 2, 2, 4)
NAMES = ("I", "II", "III", "IV", "V", "VI", "VII")


def _segments(d: Drawing, x: float, y: float, counts: tuple[int, ...], l: float) -> list[float]:
    """Draw a rope stretched out, its segments and elements; return the segments' borders."""
    ratios = (1, 2, 4, 8, 4, 2, 1)
    borders = [x]
    for i, (count, ratio) in enumerate(zip(counts, ratios, strict=True)):
        start = borders[-1]
        end = start + count * l / ratio
        d.box(start, y - 11, end - start, 22, "faint", "faint" if i % 2 == 0 else "")
        for k in range(count + 1):
            place = start + k * l / ratio
            d.line([(place, y - 11), (place, y + 11)], "ink", 1.2)
        borders.append(end)
    d.line([(borders[0], y), (borders[-1], y)], "rope", 3)
    return borders


def mesh() -> Drawing:
    """Draw the seven segments and one transformation."""
    l, x, first, second = 66.0, 42.0, 112.0, 232.0
    d = Drawing(860, 322, "The seven segments of TMN-ETM before and after a transformation")
    before = _segments(d, x, first, COUNTS, l)
    counts = (COUNTS[0] + 1, *COUNTS[1:6], COUNTS[6] - 1)
    after = _segments(d, x, second, counts, l)
    sizes = ("$l$", "$l$/2", "$l$/4", "$l$/8", "$l$/4", "$l$/2", "$l$")
    heights = (66, 66, 66, 54, 66, 66, 66)
    for i, name in enumerate(NAMES):
        middle = 0.5 * (before[i] + before[i + 1])
        d.text(middle, heights[i], name, "ink", "middle")
        d.text(middle, heights[i] + 18, sizes[i], "soft", "middle", 13)
    bottom = 0.5 * (before[3] + before[4]) + 0.6 * l
    for y in (first, second):
        d.line([(bottom, y - 24 if y == second else y - 18), (bottom, y + 34)], "mark", 1.6, "4 3")
    d.dot(bottom, first, 5, "mark", "mark")
    d.dot(bottom, second, 5, "mark", "mark")
    d.dot(500, 19, 5, "mark", "mark")
    d.text(512, 24, "lowest point of the loop, 0.6 $l$ from the middle of IV", "mark", "start", 13)
    for i in range(1, 7):
        d.line([(before[i], first + 13), (after[i], second - 13)], "soft", 1, "2 4")
    d.text(x, 24, "before", "soft")
    d.text(x, second - 22, "after", "soft")
    d.text(0.5 * (after[0] + after[1]), second + 34, "I has gained an element", "ink", "middle")
    d.text(0.5 * (after[6] + after[7]), second + 34, "VII has lost one", "ink", "middle")
    d.text(
        0.5 * (after[1] + after[3]) - 20,
        second + 62,
        "left of the loop elements join",
        "soft",
        "middle",
        13,
    )
    d.text(
        0.5 * (after[4] + after[6]) + 20,
        second + 62,
        "right of it elements split",
        "soft",
        "middle",
        13,
    )
    d.arrow((x, 310), (x + 60, 310), "ink", 1.4)
    d.text(x + 66, 315, "$s$")
    return d


def coupling() -> Drawing:
    """Draw who tells whom what, and when, in the default scheme."""
    d = Drawing(860, 350, "Time line of the coupling between drive and rope")
    drive, rope, xs = 100.0, 240.0, (150.0, 430.0, 710.0)
    for y, name, more in ((drive, "drive", "(host)"), (rope, "rope", "(FMU)")):
        d.text(30, y, name, "ink")
        d.text(30, y + 18, more, "soft", "start", 13)
        d.arrow((110, y), (820, y), "ink", 1.4)
    d.text(824, rope + 5, "$t$")
    for x, name in zip(xs, ("$t_n$", "$t_{n+1}$", "$t_{n+2}$"), strict=True):
        d.line([(x, drive - 36), (x, rope + 26)], "faint", 1.4)
        d.text(x, rope + 46, name, "ink", "middle")
    d.arrow((xs[0], rope + 66), (xs[1], rope + 66), "soft", 1.2, both=True)
    d.text(290, rope + 86, "communication step $H$", "soft", "middle")
    for a, b in itertools.pairwise(xs):
        d.curve(
            f"M{a + 6:g} {drive - 8:g}Q{(a + b) / 2:g} {drive - 62:g} {b - 8:g} {drive - 10:g}",
            "left",
            2.2,
        )
        d.arrow((b - 14, drive - 14), (b - 6, drive - 8), "left", 2.2)
    d.text(290, 48, "1  load from the forces of the past", "left", "middle")
    d.arrow((xs[1] - 2, drive + 8), (xs[1] - 2, rope - 10), "left", 2.2)
    d.text(xs[1] - 12, 152, "2  positions, speeds,", "left", "end")
    d.text(xs[1] - 12, 170, "accelerations at $t_{n+1}$", "left", "end")
    inner = [xs[0], 220.0, 290.0, 325.0, 360.0, 395.0, xs[1]]
    for a, b in itertools.pairwise(inner):
        d.curve(f"M{a:g} {rope:g}Q{(a + b) / 2:g} {rope - 34:g} {b:g} {rope:g}", "right", 2)
    for place in inner:
        d.dot(place, rope, 3.4, "right", "right")
    d.line([(360, rope - 7), (360, rope + 14)], "mark", 2)
    d.text(360, rope + 28, "stick-slip", "mark", "middle", 13)
    d.text(222, rope - 36, "3  the rope's own steps $h$", "right", "middle")
    d.arrow((xs[1] + 8, rope - 8), (xs[1] + 8, drive + 10), "right", 2.2)
    d.text(xs[1] + 20, 152, "4  end forces and torques at $t_{n+1}$,", "right")
    d.text(xs[1] + 20, 170, "the past of the next step", "right")
    d.curve(
        f"M{xs[1] + 30:g} {rope + 20:g}Q{xs[1] + 150:g} {rope + 72:g} {xs[1] + 250:g} {rope + 22:g}",
        "soft",
        1.4,
        "5 5",
    )
    d.text(
        xs[1] + 140, rope + 68, "iterative schemes restore $t_n$ and repeat", "soft", "middle", 13
    )
    return d


FIGURES = {
    "balance_rope.svg": balance_rope,
    "theory/hoist.svg": hoist,
    "theory/element.svg": element,
    "theory/swivel.svg": swivel,
    "theory/mesh.svg": mesh,
    "theory/coupling.svg": coupling,
}
