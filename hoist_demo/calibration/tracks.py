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

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Literal, Protocol, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PrivateAttr, ValidationInfo, model_validator
from scipy.interpolate import BSpline, CubicHermiteSpline, make_interp_spline, make_smoothing_spline, make_splrep
from scipy.ndimage import median_filter

from hoist_demo.files.reading import Table, beside
from hoist_demo.files.values import Text
from rope_model import EndMotion, Scene, balance_rope
from rope_model.parameters import Attachment
from rope_model.simulation.contact.point_forces import at_places, elements_at

Array = NDArray[np.float64]
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
METRES = {"m": 1.0, "cm": 0.01, "mm": 1e-3}


@dataclass(frozen=True)
class Track:
    """A measured motion in the rope's axes."""

    t: Array  # (n,), s; the file begins at REST
    spacing: float  # m, of the ends at the start
    ends: tuple[BSpline, ...]  # x, y, z, lean, lean_z of each by time
    markers: Array  # (n - REST, markers, 3), m; NaN where lost or not compared

    @cached_property
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


class _Hung(Protocol):
    scene: Scene


class Markers(Table):
    """Markers along a rope between two ends that move."""

    what: Literal["markers"]
    name: Text = ""
    file: Text
    sigma: float = Field(gt=0.0, allow_inf_nan=False)  # m, standard error of a coordinate
    places: dict[str, float] = Field(min_length=1)  # m along the rope from its left end, by marker
    ends: Attachment = "plumb"
    unit: Literal["m", "cm", "mm"] = "m"  # of the file
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)  # in the axes of the file
    skip: float = Field(0.0, ge=0.0, allow_inf_nan=False)  # s from the start of which nothing is compared
    offset: float = Field(0.0, ge=0.0, allow_inf_nan=False)  # m, standard error of where a marker sits
    delay: float = Field(0.0, ge=0.0, allow_inf_nan=False)  # s, standard error of the camera's time
    _track: Track = PrivateAttr()

    @model_validator(mode="after")
    def _is_there(self, info: ValidationInfo) -> Self:
        self._track = read_track(beside(info, self.file), self)
        return self

    @property
    def title(self) -> str:
        """Name in the results."""
        return self.name or self.file

    @property
    def track(self) -> Track:
        """The contents of the file."""
        return self._track

    @property
    def values(self) -> Array:
        """Zeros, as the predictions are residuals, of what was seen and then of offsets and delay."""
        return np.zeros(np.count_nonzero(self.track.seen) + 3 * len(self.places) + 1)

    def predict(self, trial: _Hung) -> list[float]:
        """Residuals (m), whose squares are the loss."""
        residuals: list[float] = (self.sigma * self.residuals(trial.scene)).tolist()
        return residuals

    def wind(self, scene: Scene) -> tuple[Array, Array]:
        """Places and speeds (n - REST, markers, 3) of the markers on the rope of ``scene`` between these ends."""
        left, right = (replace(swivel, attachment=self.ends) for swivel in (scene.left, scene.right))
        layout = replace(scene.layout, spacing=self.track.spacing)
        rope, found = balance_rope(scene.with_(left=left, right=right, layout=layout)), []
        for k, t in enumerate(self.track.t.tolist()):
            ends = self.track.motion(t)
            status = rope.initialize(t, *ends) if k == 0 else rope.advance_to(t, *ends)
            if not status.valid:
                raise RuntimeError(f"{self.file} at t = {t:g} s: {status.message}")
            if k >= REST:
                rows = rope.rows()
                at = elements_at(np.array([*self.places.values()]), np.diff(rows[:, 0]))
                found.append([at_places(rows[:, 1:7], *at), at_places(rows[:, 7:], *at)])
        places, speeds = np.swapaxes(np.array(found), 0, 1)
        return places, speeds

    def residuals(self, scene: Scene) -> Array:
        """Residuals in standard errors, of what was seen and then of offsets and delay; their squares are the loss."""
        seen, t = self.track.seen, self.track.t[REST:]
        motion, count = CubicHermiteSpline(t, *self.wind(scene)), seen[0].size
        each = np.broadcast_to(np.eye(count).reshape(*seen[0].shape, count), (*seen.shape, count))
        b: Array = np.zeros(count + 1)
        for _ in range(ROUNDS):
            then = np.clip(t + self.delay * b[-1], t[0], t[-1])
            B = np.column_stack((self.offset * each[seen], self.delay * motion(then, 1)[seen])) / self.sigma
            r = (motion(then) - self.track.markers)[seen] / self.sigma + B[:, :-1] @ b[:-1]
            weight = 1.0 / np.sqrt(1.0 + np.square(r / ROBUST))
            b -= np.linalg.solve((B.T * weight) @ B + np.eye(b.size), (B.T * weight) @ r + b)
        lost = np.sign(r) * ROBUST * np.sqrt(2.0 * (np.hypot(1.0, r / ROBUST) - 1.0))
        return np.asarray(np.concatenate((lost, b)))


def read_track(path: Path, asked: Markers) -> Track:
    """Read a track; ValueError names what is wrong."""
    try:
        columns = np.genfromtxt(path, delimiter=",", names=True, deletechars="", loose=False, encoding="utf-8-sig")
    except (OSError, ValueError) as error:
        raise ValueError(f"{asked.file} is no table of numbers ({error}): give a CSV file, names in line 1") from error
    names = columns.dtype.names or ()

    def vectors(name: str, axes: tuple[str, ...] = ("x", "y", "z")) -> Array:
        for axis in axes:
            if f"{name}.{axis}" not in names:
                raise ValueError(f"{asked.file} has no column {name}.{axis}: its columns are {', '.join(names)}")
        return np.column_stack([columns[f"{name}.{axis}"] for axis in axes])

    t = columns["t"] if "t" in names else np.array([])
    if t.size < 2 * FIRST or not (np.diff(t) > 0).all():
        raise ValueError(f"{asked.file} needs a column t with {2 * FIRST} times or more, in s, in ascending order")
    leaning, unit = "left.dx" in names, METRES[asked.unit]
    if leaning and asked.ends != "clamped":
        raise ValueError(f'{asked.file} has directions, and ends = "{asked.ends}" must be "clamped" to take them')
    axes, origin, spacing = _axes(unit * vectors("left"), unit * vectors("right"), asked)
    before, ends = t[0] + np.arange(-REST, 0) * (t[1] - t[0]), []
    for name, nominal in (("left", -0.5 * spacing), ("right", 0.5 * spacing)):
        place = (unit * vectors(name) - origin) @ axes.T - [nominal, 0.0, 0.0]
        lean = _leans(vectors(name, ("dx", "dy", "dz")) @ axes.T) if leaning else np.zeros((t.size, 2))
        whole = np.isfinite(path_of_end := np.hstack((place, lean))).all(axis=1)
        if whole.sum() < 2 * FIRST:
            raise ValueError(f"{asked.file} has {whole.sum()} places of {name}, needed are {2 * FIRST}: give more")
        known = path_of_end[whole]
        rest = np.broadcast_to(known[:FIRST].mean(axis=0), (REST, 5))
        ends.append(_smooth(np.concatenate((before, t[whole])), np.vstack((rest, known))))
    markers = np.stack([(unit * vectors(name) - origin) @ axes.T for name in asked.places], axis=1)
    markers = _masked(markers, asked.sigma)
    markers[t < t[0] + asked.skip] = np.nan
    if not np.isfinite(markers).any():
        raise ValueError(f"{asked.file} has no place of a marker behind skip = {asked.skip:g} s: lower skip")
    return Track(np.concatenate((before, t)), spacing, tuple(ends), markers)


def _smooth(t: Array, x: Array) -> BSpline:
    """Spline of fifth degree through ``x`` (n, m), as far from it as a cubic one by generalised cross-validation."""
    noise = np.square(x - make_smoothing_spline(t, x)(t)).sum(axis=0)
    noise[noise < t.size * LEAST_NOISE**2] = 0.0
    found = [make_splrep(t, one, k=5, s=s) for one, s in zip(x.T, noise, strict=True)]
    return make_interp_spline(t, np.column_stack([spline(t) for spline in found]), k=5)


def _axes(left: Array, right: Array, asked: Markers) -> tuple[Array, Array, float]:
    """Axes of the rope (3, 3) in those of the file, origin between the ends at the start, and their spacing (m)."""
    start, end = (np.nanmean(places[:FIRST], axis=0) for places in (left, right))
    y = np.array(asked.up) / max(float(np.linalg.norm(asked.up)), 1e-300)
    along = end - start - (end - start) @ y * y
    if not (spacing := float(np.linalg.norm(along))) > 0.0:
        raise ValueError(f"{asked.file}: the ends hang above each other with up = {asked.up}: give the direction of up")
    x = along / spacing
    return np.array([x, y, np.cross(x, y)]), 0.5 * (start + end), spacing


def _masked(markers: Array, sigma: float) -> Array:
    """``markers`` (n, markers, 3) without those that leap away from their running median."""
    frames, filled = np.arange(len(markers)), np.zeros_like(markers)
    for place in np.ndindex(markers.shape[1:]):
        x = markers[:, *place]
        if (known := np.isfinite(x)).any():
            filled[:, *place] = np.interp(frames, frames[known], x[known])
    away = np.abs(filled - median_filter(filled, size=(MEDIAN, 1, 1), mode="nearest"))
    usual = np.maximum(1.4826 * np.median(away, axis=0), sigma)  # a normal error's, from its median
    return np.where((away > LEAP * usual).any(axis=2, keepdims=True), np.nan, markers)


def _leans(direction: Array) -> Array:
    """Leans (n, 2), rad, of clamps that the rope leaves in these directions (n, 3)."""
    across = direction[:, [0, 2]]
    size = np.linalg.norm(across, axis=1, keepdims=True)
    return np.asarray(across / np.maximum(size, 1e-300) * np.arctan2(size, -direction[:, 1:2]))
