"""A pen for SVG: lines, arrows and labels that follow the reader's light or dark colours.

Coordinates are pixels, x to the right and y down.  Numbers are rounded, so that the same drawing gives the same bytes.
"""

import math
import re
from collections.abc import Iterable, Sequence
from html import escape

Point = tuple[float, float]

COLOURS = {
    # name: light, dark
    "paper": ("#ffffff", "#16181c"),
    "ink": ("#1f2933", "#dfe5ec"),
    "soft": ("#7b8794", "#8b97a5"),
    "faint": ("#dde2e8", "#343b45"),
    "rope": ("#0b66c3", "#5aa9ff"),
    "left": ("#0b66c3", "#5aa9ff"),
    "right": ("#c2410c", "#ff9a5c"),
    "mark": ("#b42318", "#ff8a80"),
}


def _style() -> str:
    def rules(shade: int) -> str:
        found = []
        for name, shades in COLOURS.items():
            found.append(f".{name}{{stroke:{shades[shade]}}}.fill-{name}{{fill:{shades[shade]}}}")
        return "".join(found)

    text = "text{font:15px 'Helvetica Neue',Arial,sans-serif;stroke:none!important}"
    text += ".m{font-family:Georgia,'Times New Roman',serif;font-style:italic}"
    lines = "path,line,circle,rect{stroke-width:1.6;fill:none;stroke-linejoin:round;stroke-linecap:round}"
    return f"{text}{lines}{rules(0)}@media(prefers-color-scheme:dark){{{rules(1)}}}"


def number(x: float, digits: int = 1) -> str:
    """Return the shortest text of ``x`` with this many decimals."""
    text = f"{x:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def path_of(points: Iterable[Point], digits: int = 1) -> str:
    """Return the path data of a polyline."""
    return "M" + "L".join(f"{number(x, digits)} {number(y, digits)}" for x, y in points)


class Drawing:
    """A drawing of a fixed size, with a title that screen readers say."""

    def __init__(self, width: int, height: int, title: str) -> None:
        self.width, self.height, self.title = width, height, title
        self.parts: list[str] = []

    def add(self, part: str) -> None:
        """Add a part as it stands."""
        self.parts.append(part)

    def line(
        self,
        points: Sequence[Point],
        kind: str = "ink",
        width: float = 1.6,
        dash: str = "",
        fill: str = "",
    ) -> None:
        """Draw a polyline; filled where ``fill`` names a colour."""
        more = f' stroke-dasharray="{dash}"' if dash else ""
        style = f' style="stroke-width:{number(width)}"' if width != 1.6 else ""
        filled = f" fill-{fill}" if fill else ""
        self.add(f'<path class="{kind}{filled}" d="{path_of(points)}"{more}{style}/>')

    def curve(self, data: str, kind: str = "ink", width: float = 1.6, dash: str = "") -> None:
        """Draw path data."""
        more = f' stroke-dasharray="{dash}"' if dash else ""
        self.add(f'<path class="{kind}" d="{data}" style="stroke-width:{number(width)}"{more}/>')

    def box(
        self,
        x: float,
        y: float,
        w: float,
        h: float,
        kind: str = "ink",
        fill: str = "",
        round_by: float = 0.0,
    ) -> None:
        """Draw a rectangle from its upper left corner."""
        filled = f" fill-{fill}" if fill else ""
        corner = f' rx="{number(round_by)}"' if round_by else ""
        place = f'x="{number(x)}" y="{number(y)}" width="{number(w)}" height="{number(h)}"'
        self.add(f'<rect class="{kind}{filled}" {place}{corner}/>')

    def dot(self, x: float, y: float, r: float = 4.0, kind: str = "ink", fill: str = "ink") -> None:
        """Draw a circle."""
        filled = f" fill-{fill}" if fill else ""
        self.add(
            f'<circle class="{kind}{filled}" cx="{number(x)}" cy="{number(y)}" r="{number(r)}"/>'
        )

    def arrow(
        self, a: Point, b: Point, kind: str = "ink", width: float = 1.6, both: bool = False
    ) -> None:
        """Draw an arrow from a to b, with a head at a as well where it measures."""
        length = math.dist(a, b)
        ux, uy = (b[0] - a[0]) / length, (b[1] - a[1]) / length
        self.line([a, b], kind, width)
        self._head(b, ux, uy, kind)
        if both:
            self._head(a, -ux, -uy, kind)

    def _head(self, tip: Point, ux: float, uy: float, kind: str, size: float = 8.0) -> None:
        x, y = tip[0] - size * ux, tip[1] - size * uy
        side = 0.42 * size
        corners = [tip, (x - side * uy, y + side * ux), (x + side * uy, y - side * ux), tip]
        self.line(corners, kind, fill=kind)

    def turn(
        self,
        x: float,
        y: float,
        r: float,
        start: float,
        end: float,
        kind: str = "ink",
        squeeze: float = 1.0,
        axis: float = 90,
    ) -> None:
        """Draw an arc with a head, angles in degrees; ``squeeze`` shortens it along an ``axis`` that it turns about."""
        steps = [math.radians(start + (end - start) * i / 40) for i in range(41)]
        ux, uy = math.cos(math.radians(axis)), math.sin(math.radians(axis))
        local = [(r * math.cos(a), squeeze * r * math.sin(a)) for a in steps]
        points = [
            (x + across * uy + along * ux, y - across * ux + along * uy) for across, along in local
        ]
        self.line(points, kind)
        (ax, ay), (bx, by) = points[-4], points[-1]
        length = math.dist((ax, ay), (bx, by))
        self._head(points[-1], (bx - ax) / length, (by - ay) / length, kind)

    def text(
        self,
        x: float,
        y: float,
        words: str,
        kind: str = "ink",
        anchor: str = "start",
        size: int = 0,
    ) -> None:
        """Write words; ``$r_1'$`` sets a symbol in italics, with ``_`` for one lowered word or sign."""
        out = []
        for i, part in enumerate(words.split("$")):
            out.append(_symbol(part) if i % 2 else escape(part))
        more = "" if anchor == "start" else f' text-anchor="{anchor}"'
        more += f' style="font-size:{size}px"' if size else ""
        self.add(
            f'<text class="fill-{kind}" x="{number(x)}" y="{number(y)}"{more}>{"".join(out)}</text>'
        )

    def svg(self) -> str:
        """Return the file's text."""
        size = (
            f'viewBox="0 0 {self.width} {self.height}" width="{self.width}" height="{self.height}"'
        )
        head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img">\n<title>{escape(self.title)}</title>\n'
        paper = f'<rect class="fill-paper" width="{self.width}" height="{self.height}" rx="6"/>'
        return f"{head}<style>{_style()}</style>\n{paper}\n" + "\n".join(self.parts) + "\n</svg>\n"


def _symbol(text: str) -> str:
    found = []
    for base, low in re.findall(r"([^_]+)(?:_(\{[^}]*\}|.))?", text):
        found.append(f'<tspan class="m">{escape(base)}</tspan>')
        if low:
            found.append(
                f'<tspan class="m" dy="4" font-size="75%">{escape(low.strip("{}"))}</tspan>'
            )
            found.append('<tspan dy="-4">&#8203;</tspan>')
    return "".join(found)
