"""Table of several ropes in one hoist: shares of the load, sums, and smallest distances."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cosimulation.participants.rope_group import SUMS
from hoist_demo.parameters.place import Place
from hoist_demo.recording.fidelity import mask_neglected, remark
from hoist_demo.recording.passages import PASSAGE_SIGNALS, outcome_of, passages
from hoist_demo.recording.time_series import TIME, Array, Recording
from rope_model import SIGNALS, Account


@dataclass(frozen=True)
class Nearest:
    """The smallest distance of two ropes in a run."""

    clearance: float  # m, between their surfaces
    t: float  # s
    place: tuple[float, float, float]  # m, half-way between both


NEVER = Nearest(np.nan, np.nan, (np.nan, np.nan, np.nan))  #: Of ropes that have no shapes to compare.


def nearest(times: Array, one: Array, other: Array, radii: float) -> Nearest:
    """Return the nearest approach of two ropes: points (instants, points, 3) [m], and the sum of their radii [m]."""
    found = Nearest(np.inf, float(times[0]), (np.nan, np.nan, np.nan))
    for k, t in enumerate(times):
        distance, place = polygon_distance(one[k], other[k])
        if distance - radii < found.clearance:
            x, y, z = place.tolist()
            found = Nearest(distance - radii, float(t), (x, y, z))
    return found


def polygon_distance(one: Array, other: Array) -> tuple[float, Array]:
    """Smallest distance of two chains of straight sides through points (n, 3), and the place half-way [m].

    Two sides p + a d, q + b e, a and b within 0 and 1, are nearest where both derivatives vanish, or at a bound
    (C. Ericson, Real-Time Collision Detection, 2005, section 5.1.9). An arc of the radius r cut short by a side of the
    length l is missed by l^2 / (8 r) at most.
    """
    p, d = one[:-1, None], np.diff(one, axis=0)[:, None]
    q, e = other[None, :-1], np.diff(other, axis=0)[None]
    r = p - q
    dd, ee, de = (d * d).sum(-1), (e * e).sum(-1), (d * e).sum(-1)
    dr, er = (d * r).sum(-1), (e * r).sum(-1)
    across = dd * ee - de * de
    # parallel sides are nearest at an end, too
    a = np.where(across > 1e-12 * dd * ee, (de * er - dr * ee) / np.where(across > 0.0, across, 1.0), 0.0)
    b = np.clip((de * np.clip(a, 0.0, 1.0) + er) / ee, 0.0, 1.0)
    a = np.clip((de * b - dr) / dd, 0.0, 1.0)
    gap = r + a[..., None] * d - b[..., None] * e
    distance = np.linalg.norm(gap, axis=-1)
    k = np.unravel_index(np.argmin(distance), distance.shape)
    at = (p + a[..., None] * d)[k] - 0.5 * gap[k]
    return float(distance[k]), at


#: Outputs of each rope that the tables are made of.
READ = PASSAGE_SIGNALS.union(
    name
    for name in SIGNALS
    if name.startswith(("shape.x[", "shape.y[", "shape.z[", "loop."))
    or name in (*SUMS, "left.swivel.torque", "right.swivel.torque")
)

POINTS = sum(name.startswith("shape.x[") for name in SIGNALS)
LOOKED_AT = 0.1  #: Time between two shapes that are compared [s].
#: Columns of the ropes' table, each with unit and meaning; NaN for what a rope's model does not compute.
COLUMNS = {
    "share_at_rest": ("1", "of the pull of all ropes on both conveyances, before the trip"),
    "share_least": ("1", "smallest of the trip"),
    "share_most": ("1", "largest of the trip"),
    "pull_peak": ("N", "largest pull on a conveyance"),
    "yaw_peak": ("rad", "largest magnitude of the loop's yaw"),
    "torque_peak": ("N.m", "largest magnitude of a swivel's torque"),
    "lowest": ("m", "height of the loop's lowest point, the smallest"),
}


@dataclass(frozen=True)
class Neighbours:
    """Two ropes, where they came nearest to each other, and what they did to each other if they may."""

    one: str
    other: str
    nearest: Nearest
    account: Account | None


def without_neglected(recording: Recording, torque_free: Mapping[str, bool]) -> Recording:
    """The recording with NaN for what the fidelity of each rope leaves out, and for sums of which that is a part.

    `torque_free` is by the ropes' names whether one carries no torque.
    """
    signals = dict(recording.signals)
    for name, free in torque_free.items():
        before = _own(recording, name)
        for key, values in mask_neglected(before, free).signals.items():
            if key != TIME:
                signals[f"{name}.{key}"] = values
            if key in SUMS and key in signals:
                signals[key] = np.where(np.isnan(values) & np.isfinite(before[key]), np.nan, signals[key])
    return Recording(signals, recording.units)


def remarks(recording: Recording, names: Sequence[str]) -> list[str]:
    """List what `without_neglected` left out of each rope's recording."""
    told = ((name, remark(_whole(recording, name))) for name in names)
    return [text.replace("the rope", f"rope {name}", 1) for name, text in told if text]


def row(recording: Recording, name: str) -> dict[str, float]:
    """The row of a rope; without numbers from a break on."""
    pulls = np.array([recording[f"{name}.{end}.fy"] for end in ("left", "right")])
    share = pulls.sum(axis=0) / (recording["left.fy"] + recording["right.fy"])
    torques = np.array([recording[f"{name}.{end}.swivel.torque"] for end in ("left", "right")])
    return {
        "share_at_rest": float(share[0]),
        "share_least": float(share.min()),
        "share_most": float(share.max()),
        "pull_peak": float(-pulls.min()),
        "yaw_peak": _largest(recording[f"{name}.loop.yaw"]),
        "torque_peak": _largest(torques),
        "lowest": float(np.nanmin(recording[f"{name}.loop.y"])),
    }


def _largest(values: Array) -> float:
    """The largest magnitude; NaN where nothing was computed."""
    known = values[np.isfinite(values)]
    return float(np.max(np.abs(known))) if known.size else math.nan


def outcome(completed: bool, recording: Recording, names: Sequence[str]) -> str:
    """Return the outcome: how the trip ended, contacts and passages of each rope, and breaks, in words."""
    told = (passages(_whole(recording, name), f"rope {name}") for name in names)
    return outcome_of(completed, ", and ".join(filter(None, told))) + "".join(_broken(recording, n) for n in names)


def unbroken(recording: Recording, breaks: Mapping[str, float]) -> list[str]:
    """Return the warning on ropes that were to break at these times [s] by name, and did not."""
    end = float(recording.time[-1])
    return [
        f"rope {name} was to break at breaks_at = {t:g} s, and did not: the run ended at {end:.4g} s; break it earlier"
        for name, t in breaks.items()
        if math.isfinite(recording[f"{name}.loop.y"][-1])
    ]


def _broken(recording: Recording, name: str) -> str:
    """The break of a rope as the end of a sentence; "" for none."""
    gone = ~np.isfinite(recording[f"{name}.loop.y"])
    if not bool(gone.any()):
        return ""
    return (
        f"; rope {name} broke by t = {recording.time[np.argmax(gone)]:.4g} s; of its loop, torques and clearances what "
        "was before is told"
    )


def _whole(recording: Recording, name: str) -> Recording:
    """The signals of a rope under their own names, until it breaks."""
    own = _own(recording, name)
    unbroken = np.isfinite(own["loop.y"])
    return Recording({key: values[unbroken] for key, values in own.signals.items()}, {})


def _own(recording: Recording, name: str) -> Recording:
    """The signals of a rope under their own names."""
    own = {key.removeprefix(f"{name}."): x for key, x in recording.signals.items() if key.startswith(f"{name}.")}
    return Recording({TIME: recording.time, **own}, {})


def neighbours(
    recording: Recording, ropes: Sequence[tuple[str, Place, float]], accounts: Mapping[tuple[str, str], Account]
) -> list[Neighbours]:
    """All pairs of ropes with name, place and diameter [m], at the times at which both have a shape.

    A broken rope has none any more, and one whose model leaves out what leads it out of its plane has none either.
    """
    every = max(1, round(LOOKED_AT / (recording.time[1] - recording.time[0]))) if recording.time.size > 1 else 1
    times = recording.time[::every]
    shapes = {name: _shape(recording, name, place, every) for name, place, _ in ropes}
    found = []
    for (one, _, thick), (other, _, thin) in combinations(ropes, 2):
        shown = shapes[one].computed & shapes[other].computed
        points = shapes[one].points[shown], shapes[other].points[shown]
        near = nearest(times[shown], *points, 0.5 * (thick + thin)) if bool(shown.any()) else NEVER
        found.append(Neighbours(one, other, near, accounts.get((one, other))))
    return found


class _Shapes(NamedTuple):
    """A rope in the shaft, at some instants."""

    points: Array  # (instants, points, 3) [m]; x from half-way between the conveyances' centres
    computed: NDArray[np.bool_]  # (instants,)


def _shape(recording: Recording, name: str, place: Place, every: int) -> _Shapes:
    axes = [np.array([recording[f"{name}.shape.{axis}[{i + 1}]"] for i in range(POINTS)]).T for axis in "xyz"]
    points = np.stack(axes, axis=-1)[::every] + place.origin
    across = recording[f"{name}.loop.z"][::every]
    return _Shapes(points, np.isfinite(across) & np.isfinite(points).all(axis=(1, 2)))
