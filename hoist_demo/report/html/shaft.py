"""Bodies of the shaft, guards and their trip, for the drawing of a run."""

from __future__ import annotations

from collections.abc import Mapping

from hoist_demo.recording.guards import guard_trip
from hoist_demo.recording.passages import FAR
from hoist_demo.recording.time_series import Recording

Drawn = Mapping[str, object]

_GROUPS = {
    "lining": ("width", "depth", "rounding", "x", "z"),
    "conveyance": ("width", "depth", "height", "above"),
    "head_ropes": ("diameter", "row"),
    "guard": ("rise", "rise_y", "window", "window_y"),
}
_DIVIDER = ("size", "y", "offset", "direction", "rounding")


def drawn_shaft(parameters: Mapping[str, object], recording: Recording) -> Drawn:
    """Sizes by part, from the rope's parameters by FMI name; what is not there has none, or the size 0."""
    values = {name: float(x) for name, x in parameters.items() if isinstance(x, int | float)}

    def part(group: str, names: tuple[str, ...]) -> dict[str, float]:
        return {name: values.get(f"{group}.{name}", 0.0) for name in names}

    level = values.get("sump.level", -FAR)
    dividers = [part(f"divider_{k}", _DIVIDER) for k in (1, 2, 3, 4)]
    trip = guard_trip(recording)
    return {
        **{group: part(group, names) for group, names in _GROUPS.items()},
        "dividers": [divider for divider in dividers if divider["size"] > 0.0],
        "floor": level if level > -FAR else None,
        "far": FAR,
        "trip": None if trip is None else {"t": trip.t, "cause": trip.cause},
    }
