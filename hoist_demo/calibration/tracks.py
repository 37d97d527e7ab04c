"""Motion that somebody has measured: the paths of a rope's ends and of markers along it, in a CSV file.

A column each:  t                                time, s
                left.x ... right.z               places of the ends
                left.dx ... right.dz, optional   direction in which the rope leaves each end, of any length
                NAME.x, NAME.y, NAME.z           place of a marker; empty where it was lost

The file's axes are turned and moved to those of the rope: Y up, X from the left to the right end at the start.
Ends follow smoothing splines (generalised cross-validation), at rest before the file begins.  A marker that leaps away
from its running median is masked, as one that was lost.

A residual is the place of a marker on the rope, moved by an offset of its own and at a time that the camera's delay
shifts, less the measured one.  Offsets and delay have standard errors, too, and are found anew for each rope (variable
projection; G. Golub and V. Pereyra, SIAM J. Numer. Anal. 10, 1973, 413-432).  With r in standard errors the loss is
2 c^2 (sqrt(1 + (r/c)^2) - 1), soft_l1: what is far off leads less.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy.interpolate import BSpline, CubicHermiteSpline, make_interp_spline, make_smoothing_spline, make_splrep
from scipy.ndimage import median_filter

from hoist_demo.files.reading import Table
from hoist_demo.files.values import Text
from rope_model import EndMotion, Scene, balance_rope
from rope_model.parameters import Attachment
from rope_model.simulation.contact.point_forces import at_places, elements_at

Array = NDArray[np.float64]
AXES, DIRECTION = ("x", "y", "z"), ("dx", "dy", "dz")
#: samples before the file begins, at rest in the mean of its first ones
REST, FIRST = 25, 5
#: standard errors from which on a residual counts for less
ROBUST = 3.0
#: samples of the running median, and standard errors from it that are a leap
MEDIAN, LEAP = 5, 8.0
#: m or rad: a path with less is gone through as it is
LEAST_NOISE = 1e-7
#: corrections of offsets and delay
ROUNDS = 5


class Markers(Table):
    """Markers along a rope between two ends that move."""

    what: Literal["markers"]
    name: Text = ""
    file: Text
    sigma: float = Field(gt=0.0, allow_inf_nan=False)  # m, standard error of a coordinate
    places: dict[str, float] = Field(min_length=1)  # m along the rope from its left end, by marker
    ends: Attachment = "plumb"
    unit: Literal["m", "cm", "mm"] = "m"
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)  # in the axes of the file
    skip: float = Field(default=0.0, ge=0.0, allow_inf_nan=False)  # s from the start of which nothing is compared
    offset: float = Field(default=0.0, ge=0.0, allow_inf_nan=False)  # m, standard error of where a marker sits
    delay: float = Field(default=0.0, ge=0.0, allow_inf_nan=False)  # s, standard error of the camera's time


@dataclass(frozen=True)
class Track:
    """A measured motion in the rope's axes."""

    asked: Markers
    t: Array  # (n,), s; the file begins at REST
    spacing: float  # m, of the ends at the start
    ends: tuple[BSpline, BSpline]  # x, y, z, lean, lean_z of each by time
    markers: Array  # (n - REST, markers, 3), m; NaN where lost or not compared

    @property
    def seen(self) -> NDArray[np.bool_]:
        """True where a coordinate was measured."""
        return np.isfinite(self.markers)

    def motion(self, t: float) -> tuple[EndMotion, EndMotion]:
        """Return the motions of the ends; at the first time they rest."""
        moving, ends = float(t > self.t[0]), []
        for spline in self.ends:
            place, speed, acceleration = (spline(t, k).tolist() for k in range(3))
            rates = (moving * x for x in (*speed[:3], *acceleration[:3]))
            ends.append(replace(EndMotion(*place[:3], *rates), lean=place[3], lean_z=place[4]))
        return ends[0], ends[1]

    def wind(self, scene: Scene) -> tuple[Array, Array]:
        """Places and speeds (n - REST, markers, 3) of the markers on the rope of ``scene`` between these ends."""
        held = (replace(swivel, attachment=self.asked.ends) for swivel in (scene.left, scene.right))
        left, right = held
        rope = balance_rope(scene.with_(left=left, right=right, layout=replace(scene.layout, spacing=self.spacing)))
        s, found = np.array([*self.asked.places.values()]), []
        for k, t in enumerate(self.t.tolist()):
            ends = self.motion(t)
            status = rope.initialize(t, *ends) if k == 0 else rope.advance_to(t, *ends)
            if not status.valid:
                raise RuntimeError(f"{self.asked.file} at t = {t:g} s: {status.message}")
            if k >= REST:
                rows = rope.rows()
                at = elements_at(s, np.diff(rows[:, 0]))
                found.append([at_places(rows[:, 1:7], *at), at_places(rows[:, 7:], *at)])
        places, speeds = np.swapaxes(np.array(found), 0, 1)
        return places, speeds

    def residuals(self, scene: Scene) -> Array:
        """Residuals in standard errors, of what was seen and then of offsets and delay; their squares are the loss."""
        asked, seen, sigma, t = self.asked, self.seen, self.asked.sigma, self.t[REST:]
        motion = CubicHermiteSpline(t, *self.wind(scene))
        offsets = np.eye(seen[0].size).reshape(*seen[0].shape, -1)
        offsets = asked.offset * np.broadcast_to(offsets, (*seen.shape, seen[0].size))[seen]
        b: Array = np.zeros(seen[0].size + 1)
        for _ in range(ROUNDS):
            then = np.clip(t + asked.delay * b[-1], t[0], t[-1])
            B = np.column_stack((offsets, asked.delay * motion(then, 1)[seen])) / sigma
            r = (motion(then) - self.markers)[seen] / sigma + B[:, :-1] @ b[:-1]
            weight = 1.0 / np.sqrt(1.0 + np.square(r / ROBUST))
            b -= np.linalg.solve((B.T * weight) @ B + np.eye(b.size), (B.T * weight) @ r + b)
        rest = r / ROBUST
        lost = np.sign(rest) * ROBUST * np.sqrt(2.0 * (np.sqrt(1.0 + rest * rest) - 1.0))
        return np.asarray(np.concatenate((lost, b)))


def read_track(folder: Path, asked: Markers, length: float) -> Track:
    """Read the track of a rope of ``length`` (m); ValueError names what is wrong."""
    columns = _columns(folder / asked.file)
    unit = {"m": 1.0, "cm": 0.01, "mm": 1e-3}[asked.unit]

    def vectors(name: str, axes: tuple[str, ...] = AXES) -> Array:
        names = [f"{name}.{axis}" for axis in axes]
        if missing := [one for one in names if one not in columns]:
            raise ValueError(f"{asked.file} has no column {missing[0]}: its columns are {', '.join(columns)}")
        return np.column_stack([columns[one] for one in names])

    for name, s in asked.places.items():
        if not 0.0 <= s <= length:
            raise ValueError(f"places.{name} = {s:g} m must be from 0 to {length:g} m: measure it from the left")
    t = _times(columns, asked.file)
    axes, origin, spacing = _axes(unit * vectors("left"), unit * vectors("right"), asked)
    ends, leaning = [], "left.dx" in columns
    if leaning and asked.ends != "clamped":
        raise ValueError(f'{asked.file} has directions, and ends = "{asked.ends}" must be "clamped" to take them')
    before = t[0] + np.arange(-REST, 0) * (t[1] - t[0])
    for name, sense in (("left", -1.0), ("right", 1.0)):
        place = (unit * vectors(name) - origin) @ axes.T - [0.5 * sense * spacing, 0.0, 0.0]
        lean = _leans(vectors(name, DIRECTION) @ axes.T) if leaning else np.zeros((t.size, 2))
        path = np.hstack((place, lean))
        whole = np.isfinite(path).all(axis=1)
        if whole.sum() < 2 * FIRST:
            raise ValueError(
                f"{asked.file} has {whole.sum()} places of the {name} end, needed are {2 * FIRST}: give more"
            )
        rest = np.broadcast_to(path[whole][:FIRST].mean(axis=0), (REST, 5))
        ends.append(_smooth(np.concatenate((before, t[whole])), np.vstack((rest, path[whole]))))
    markers = np.stack([(unit * vectors(name) - origin) @ axes.T for name in asked.places], axis=1)
    markers = _masked(markers, asked.sigma)
    markers[t < t[0] + asked.skip] = np.nan
    if not np.isfinite(markers).any():
        raise ValueError(f"{asked.file} has no place of a marker behind skip = {asked.skip:g} s: lower skip")
    return Track(asked, np.concatenate((before, t)), spacing, (ends[0], ends[1]), markers)


def _smooth(t: Array, x: Array) -> BSpline:
    """Spline of fifth degree through ``x`` (n, m), as far from it as a cubic one by generalised cross-validation."""
    noise = np.square(x - make_smoothing_spline(t, x)(t)).sum(axis=0)
    noise[noise < t.size * LEAST_NOISE**2] = 0.0
    found = [make_splrep(t, one, k=5, s=s) for one, s in zip(x.T, noise, strict=True)]
    return make_interp_spline(t, np.column_stack([spline(t) for spline in found]), k=5)


def _times(columns: dict[str, Array], file: str) -> Array:
    """Return the times (n,), s, in order."""
    t = columns.get("t", np.array([]))
    if t.size < 2 * FIRST or not (np.diff(t) > 0).all():
        raise ValueError(f"{file} needs a column t with {2 * FIRST} times or more, in s, in ascending order: give it")
    return t


def _axes(left: Array, right: Array, asked: Markers) -> tuple[Array, Array, float]:
    """Axes of the rope (3, 3) in those of the file, origin between the ends at the start, and their spacing (m)."""
    up = np.array(asked.up)
    first = [np.nanmean(end[:FIRST], axis=0) for end in (left, right)]
    y = up / max(float(np.linalg.norm(up)), 1e-300)
    along = first[1] - first[0]
    along = along - (along @ y) * y
    if not (spacing := float(np.linalg.norm(along))) > 0.0:
        raise ValueError(f"{asked.file}: the ends hang above each other with up = {asked.up}: give the direction of up")
    x = along / spacing
    return np.array([x, y, np.cross(x, y)]), 0.5 * (first[0] + first[1]), spacing


def _masked(markers: Array, sigma: float) -> Array:
    """``markers`` (n, markers, 3) without those that leap away from their running median."""
    n = len(markers)
    filled = np.empty_like(markers)
    for place in np.ndindex(markers.shape[1:]):
        x, known = markers[:, *place], np.isfinite(markers[:, *place])
        filled[:, *place] = np.interp(np.arange(n), np.flatnonzero(known), x[known]) if known.any() else 0.0
    away = np.abs(filled - median_filter(filled, size=(MEDIAN, 1, 1), mode="nearest"))
    usual = np.maximum(1.4826 * np.median(away, axis=0), sigma)  # a normal error's, from its median
    return np.where((away > LEAP * usual).any(axis=2, keepdims=True), np.nan, markers)


def _leans(direction: Array) -> Array:
    """Leans (n, 2), rad, of clamps that the rope leaves in these directions (n, 3)."""
    across = direction[:, [0, 2]]
    size = np.linalg.norm(across, axis=1, keepdims=True)
    return np.asarray(across / np.maximum(size, 1e-300) * np.arctan2(size, -direction[:, 1:2]))


def _columns(path: Path) -> dict[str, Array]:
    """Columns of a CSV file by name; NaN where a field is empty."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            names, *rows = csv.reader(file)
            table = np.array([[float(x) if x.strip() else math.nan for x in row] for row in rows])
    except (OSError, ValueError) as error:
        raise ValueError(
            f"{path.name} is no table of numbers ({error}): give a CSV file, names in its first line"
        ) from error
    if table.ndim != 2 or table.shape[1] != len(names):
        raise ValueError(f"{path.name} must have {len(names)} fields in each line, as its first has: mend it")
    return dict(zip(map(str.strip, names), table.T, strict=True))
