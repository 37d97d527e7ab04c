"""Motion that somebody has measured: paths of a rope's ends and of markers, in a CSV file (docs/reference/files.md).

The file's axes are turned and moved to those of the rope: Y up, X from the left to the right end at the start.
Ends follow smoothing splines (generalised cross-validation), at rest before the file begins.  A marker that leaps away
from its running median is masked, as one that was lost.

A residual r is the place of a marker on the rope, moved by an offset of its own and at a time that the camera's delay
shifts, less the measured one.  Offsets and delay have standard errors and are found anew for each rope (variable
projection; G. Golub and V. Pereyra, SIAM J. Numer. Anal. 10, 1973, 413-432).  The loss is soft_l1, with c = ROBUST.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from pydantic import Field, PrivateAttr, ValidationInfo, model_validator
from scipy.interpolate import BSpline, CubicHermiteSpline, make_interp_spline, make_smoothing_spline, make_splrep

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
    _t: Array = PrivateAttr()  # (n,), s; the file begins at REST
    _spacing: float = PrivateAttr()  # m, of the ends at the start
    _path: BSpline = PrivateAttr()  # x, y, z, lean, lean_z of both ends by time, (2, 5)
    _places: Array = PrivateAttr()  # (n - REST, markers, 3), m; NaN where lost or not compared

    @model_validator(mode="after")
    def _is_there(self, info: ValidationInfo) -> Self:
        self._t, self._spacing, self._path, self._places = _read(beside(info, self.file), self)
        return self

    @property
    def values(self) -> Array:
        """Zeros, as the predictions are residuals, of what was seen and then of offsets and delay."""
        return np.zeros(np.isfinite(self._places).sum() + 3 * len(self.places) + 1)

    def motion(self, t: float) -> tuple[EndMotion, EndMotion]:
        """Return the motions of the ends; at the first time they rest."""
        moving, path = float(t > self._t[0]), self._path
        place, speed, acceleration = path(t), moving * path(t, 1)[:, :3], moving * path(t, 2)[:, :3]
        left, right = np.hstack((place[:, :3], speed, acceleration, np.zeros((2, 2)), place[:, 3:])).tolist()
        return EndMotion(*left), EndMotion(*right)

    def wind(self, scene: Scene) -> CubicHermiteSpline:
        """Places of the markers by time (markers, 3), on the rope of ``scene`` between these ends."""
        left, right = (replace(swivel, attachment=self.ends) for swivel in (scene.left, scene.right))
        layout = replace(scene.layout, spacing=self._spacing)
        rope, found = balance_rope(scene.with_(left=left, right=right, layout=layout)), []
        for k, t in enumerate(self._t.tolist()):
            ends = self.motion(t)
            status = rope.initialize(t, *ends) if k == 0 else rope.advance_to(t, *ends)
            if not status.valid:
                raise RuntimeError(f"{self.file} at t = {t:g} s: {status.message}")
            if k >= REST:
                rows = rope.rows()
                at = elements_at(np.array([*self.places.values()]), np.diff(rows[:, 0]))
                found.append([at_places(rows[:, 1:7], *at), at_places(rows[:, 7:], *at)])
        return CubicHermiteSpline(self._t[REST:], *np.swapaxes(found, 0, 1))

    def predict(self, trial: Any) -> Array:
        """Residuals (m) on the scene of a measurements.Trial; their squares are the loss."""
        motion, t, seen = self.wind(trial.scene), self._t[REST:], np.isfinite(self._places)
        count = seen[0].size
        each = np.broadcast_to(np.eye(count).reshape(*seen[0].shape, count), (*seen.shape, count))
        b: Array = np.zeros(count + 1)
        for _ in range(ROUNDS):
            then = np.clip(t + self.delay * b[-1], t[0], t[-1])
            B = np.column_stack((self.offset * each[seen], self.delay * motion(then, 1)[seen])) / self.sigma
            r = (motion(then) - self._places)[seen] / self.sigma + B[:, :-1] @ b[:-1]
            weight = 1.0 / np.sqrt(1.0 + np.square(r / ROBUST))
            b -= np.linalg.solve((B.T * weight) @ B + np.eye(b.size), (B.T * weight) @ r + b)
        lost = np.sign(r) * ROBUST * np.sqrt(2.0 * (np.hypot(1.0, r / ROBUST) - 1.0))
        return np.asarray(self.sigma * np.concatenate((lost, b)))


def _read(path: Path, asked: Markers) -> tuple[Array, float, BSpline, Array]:
    """Contents of the file; ValueError names what is wrong."""
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
    leaning, unit = "left.dx" in names, {"m": 1.0, "cm": 0.01, "mm": 1e-3}[asked.unit]
    if leaning and asked.ends != "clamped":
        raise ValueError(f'{asked.file} has directions, and ends = "{asked.ends}" must be "clamped" to take them')
    axes, origin, spacing = _axes(unit * vectors("left"), unit * vectors("right"), asked)
    before, ends = t[0] + np.arange(-REST, 0) * (t[1] - t[0]), []
    for name, nominal in (("left", -0.5 * spacing), ("right", 0.5 * spacing)):
        place = (unit * vectors(name) - origin) @ axes.T - [nominal, 0.0, 0.0]
        lean = _leans(vectors(name, ("dx", "dy", "dz")) @ axes.T) if leaning else np.zeros((t.size, 2))
        ends.append(np.hstack((place, lean)))
    paths = np.stack(ends, axis=1)
    whole = np.isfinite(paths).all(axis=(1, 2))
    if whole.sum() < 2 * FIRST:
        raise ValueError(f"{asked.file} has both ends at {whole.sum()} times, needed are {2 * FIRST}: give more")
    rest = np.broadcast_to(paths[whole][:FIRST].mean(axis=0), (REST, 2, 5))
    smooth = _smooth(np.concatenate((before, t[whole])), np.concatenate((rest, paths[whole])))
    markers = np.stack([(unit * vectors(name) - origin) @ axes.T for name in asked.places], axis=1)
    markers = _masked(markers, asked.sigma)
    markers[t < t[0] + asked.skip] = np.nan
    if not np.isfinite(markers).any():
        raise ValueError(f"{asked.file} has no place of a marker behind skip = {asked.skip:g} s: lower skip")
    return np.concatenate((before, t)), spacing, smooth, markers


def _smooth(t: Array, x: Array) -> BSpline:
    """Spline of fifth degree by ``x`` (n, ...), as far from it as a cubic one by generalised cross-validation."""
    smooth, noise = np.empty_like(x), np.square(x - make_smoothing_spline(t, x)(t)).sum(axis=0)
    noise[noise < t.size * LEAST_NOISE**2] = 0.0
    for place, s in np.ndenumerate(noise):
        smooth[:, *place] = make_splrep(t, x[:, *place], k=5, s=s)(t)
    return make_interp_spline(t, smooth, k=5)


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
    around = np.pad(markers, ((MEDIAN // 2, MEDIAN // 2), (0, 0), (0, 0)), mode="edge")
    with warnings.catch_warnings(category=RuntimeWarning, action="ignore"):  # of a marker that was long lost
        away = np.abs(markers - np.nanmedian(sliding_window_view(around, MEDIAN, axis=0), axis=-1))
        usual = np.maximum(1.4826 * np.nanmedian(away, axis=0), sigma)  # a normal error's, from its median
    return np.where((away > LEAP * usual).any(axis=2, keepdims=True), np.nan, markers)


def _leans(direction: Array) -> Array:
    """Leans (n, 2), rad, of clamps that the rope leaves in these directions (n, 3)."""
    across = direction[:, [0, 2]]
    size = np.linalg.norm(across, axis=1, keepdims=True)
    return np.asarray(across / np.maximum(size, 1e-300) * np.arctan2(size, -direction[:, 1:2]))
