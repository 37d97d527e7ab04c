"""Measured motion: paths of a rope's ends and of markers, in a CSV file.

docs/reference/files.md describes the file.

The file's axes are turned and moved to those of the rope: Y up, X from the left to the right end at
the start. Ends follow smoothing splines (generalised cross-validation), at rest before the file
begins, or led into its motion over ``settle``.  A marker that leaps away from its running median is
masked, as one that was lost.

The swing in which a file begins is a nuisance: both ends come to the file's first places in STEPS
quintic steps from poses at rest that the fit finds, within four standard errors.

A residual r is the place of a marker on the rope, moved by an offset of its own and at a time that
the camera's delay shifts, less the measured one; of an unlabelled point the part across the rope at
the place nearest to it, which is seen late by its speed.  Offsets and delay have standard errors
and are found anew for each rope (variable projection; G. Golub and V. Pereyra, SIAM J. Numer. Anal.
10, 1973, 413-432).  The loss is soft_l1, with c = ROBUST.
"""

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PrivateAttr, ValidationInfo, model_validator
from scipy.interpolate import CubicHermiteSpline, make_smoothing_spline
from scipy.ndimage import generic_filter
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from hoist_demo.calibration.fit import NotComputed
from hoist_demo.calibration.prediction import RopePredictor
from hoist_demo.files.reading import TomlTable, path_from_file
from hoist_demo.files.values import Text
from rope_model import EndMotion, Scene, balance_rope
from rope_model.arrays import Array
from rope_model.boundary import quintic
from rope_model.boundary.point_forces import at_places, elements_at
from rope_model.parameters import Attachment
from rope_model.physics.node import SIDES

REST = 25  #: Samples at rest that are put before the file.
FIRST = 5  #: First samples of the file, in the mean of which the ends rest.
ROBUST = 3.0  #: Standard errors from which on a residual counts for less.
#: Most frames from one with both ends to the next: over longer gaps splines mistake the ends'
#: paths.
GAP = 6
MEDIAN = 5  #: Samples of the running median.
LEAP = 8.0  #: Standard errors from the running median that are a leap.
STEPS = 2  #: Steps of the ends' path to where a file begins.
SLACK = 0.2  #: Standard error of such a step, in parts of the rope's slack.
ERRORS = 8.0  #: Width of a step's range, in its standard errors.


@dataclass(frozen=True)
class _Frames:
    """Frames of a file; NaN where something is lost."""

    t: Array  # (n,), s
    ends: Array  # (n, 2, 3), m
    directions: Array  # (n, 2, 3), directions of the ends; (n, 0, 3) where they are plumb
    markers: Array  # (n, markers, 3), m

    @cached_property
    def whole(self) -> NDArray[np.bool_]:
        """Mask (n,) of the frames in which both ends are seen."""
        return np.asarray(np.isfinite(np.hstack((self.ends, self.directions))).all(axis=(1, 2)))

    @cached_property
    def period(self) -> float:
        """Median time from frame to frame [s]."""
        return float(np.median(np.diff(self.t)))


class Markers(TomlTable):
    """Markers along a rope between two ends that move."""

    what: Literal["markers"]
    name: Text = ""
    file: Text
    sigma: float = Field(gt=0.0, allow_inf_nan=False)  # m, standard error of a coordinate
    places: dict[str, float] = Field({})  # m along the rope from its left end, by marker
    unlabelled: tuple[Text, ...] = ()  # points anywhere on the rope
    ends: Attachment = "plumb"
    unit: Literal["m", "cm", "mm"] = "m"  # unit of length in the file
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)  # upward direction in the axes of the file
    # s from the start of which nothing is compared
    skip: float = Field(0.0, ge=0.0, allow_inf_nan=False)
    # s from rest into the motion in which the file begins
    settle: float = Field(0.0, ge=0.0, allow_inf_nan=False)
    # m, standard error of where a marker sits
    offset: float = Field(0.0, ge=0.0, allow_inf_nan=False)
    delay: float = Field(0.0, ge=0.0, allow_inf_nan=False)  # s, standard error of the camera's time
    _t: Array = PrivateAttr()  # (n,), s from the first of the file, whose frames are the last ones
    _spacing: float = PrivateAttr()  # m, of the ends at the start
    # (3, n, 2, 5), values, rates and accelerations of the ends' places and leans
    _end_paths: Array = PrivateAttr()
    _places: Array = PrivateAttr()  # (frames, markers, 3), m; NaN where lost or not compared

    @model_validator(mode="after")
    def _is_there(self, info: ValidationInfo) -> Self:
        frames = _checked(_read(path_from_file(info, self.file), self), self)
        self._spacing, end_paths, markers = _turned(frames, self)
        self._t, self._end_paths = _smoothed(frames, end_paths, self.settle)
        markers[~frames.whole | (frames.t < self.skip)] = np.nan
        labelled, free = np.split(markers, [len(self.places)], axis=1)
        self._places = np.hstack((_masked(labelled, self.sigma), free))
        if not np.isfinite(self._places).any():
            raise ValueError(
                f"{self.file} has no marker behind skip = {self.skip:g} s with both ends: lower "
                "skip or name one"
            )
        return self

    @property
    def starts(self) -> int:
        """Number of fitted shares that describe the ends' path to where the file begins."""
        if self.settle:
            return 6 * STEPS
        return 0

    @property
    def nuisance(self) -> int:
        """Number of starts, offsets and delays, each of which is a residual and is found."""
        return self.starts + 3 * len(self.places) + 1

    @property
    def unknowns(self) -> int:
        """Number of nuisance parameters and arc lengths of unlabelled points, which are fitted."""
        return self.nuisance + int(
            np.isfinite(self._places[:, len(self.places) :]).all(axis=2).sum()
        )

    @property
    def values(self) -> Array:
        """Zeros, as the predictions are residuals, of what was seen and then of the nuisance."""
        return np.zeros(np.isfinite(self._places).sum() + self.nuisance)

    @property
    def largest_end_distance(self) -> float:
        """Largest distance of the ends [m]."""
        x = self._end_paths[0, ..., :3]
        return float(np.linalg.norm(x[:, 1] - x[:, 0] + [self._spacing, 0.0, 0.0], axis=1).max())

    @property
    def lengths(self) -> dict[str, float]:
        """Lengths (m) that are at most the rope's, by what they are."""
        lengths = {f"places.{k}": s for k, s in self.places.items()}
        return lengths | {f"{self.file}: largest distance of the ends": self.largest_end_distance}

    def motions(self, start: Array) -> list[tuple[EndMotion, EndMotion]]:
        """Return the motions of the ends at each time.

        ``start`` (steps, 2, 3) are poses from the first places of the file [m].
        """
        paths = self._end_paths.copy()
        t = self._t[: -len(self._places)]
        h = (self._t[t.size] - t[0]) / STEPS
        for k, offset in enumerate(start):
            s = np.clip(t - t[0] - k * h, 0.0, h)[:, None, None]
            paths[:, : t.size, :, :3] += quintic.rates(
                quintic.coefficients(h, (offset, 0.0, 0.0), (0.0, 0.0, 0.0)), s
            )
        motions = np.concatenate(
            (*paths[..., :3], np.zeros((*paths.shape[1:3], 2)), paths[0, ..., 3:]), axis=2
        )
        return [(EndMotion(*left), EndMotion(*right)) for left, right in motions.tolist()]

    def wind(self, scene: Scene, start: Array) -> Array:
        """Places, speeds and, of the unlabelled, tangents (3, n, markers, 3).

        ``start`` is in standard errors.
        """
        slack = SLACK * (scene.rope.length - self.largest_end_distance)
        displacements = slack * start.reshape(-1, 2, 3)
        left = replace(scene.left, attachment=self.ends)
        right = replace(scene.right, attachment=self.ends)
        layout = replace(scene.layout, spacing=self._spacing)
        before = len(self._t) - len(self._places)
        rope = balance_rope(scene.with_(left=left, right=right, layout=layout))
        samples = []
        labelled = np.array([*self.places.values()])
        motions = zip(self._t.tolist(), self.motions(displacements), strict=True)
        for k, (t, ends) in enumerate(motions):
            step = rope.advance_to if k else rope.initialize
            status = step(t, *ends)
            if not status.valid:
                raise NotComputed(f"{self.file}, {t:g} s from its first time: {status.message}")
            if k < before:
                continue
            rows = rope.rows()
            s = labelled
            tangents = np.zeros((labelled.size, 3))
            if self.unlabelled:
                curve = CubicHermiteSpline(rows[:, 0], rows[:, 1:4], rows[:, 4:7])
                free = _nearest(curve, self._places[k - before, labelled.size :])
                s = np.append(labelled, free)
                tangents = np.vstack((tangents, curve(free, 1)))
            elements = elements_at(s, np.diff(rows[:, 0]))
            places = at_places(rows[:, 1:7], *elements)
            speeds = at_places(rows[:, 7:], *elements)
            samples.append([places, speeds, tangents])
        return np.array(samples).swapaxes(0, 1)

    def predict(self, predictor: RopePredictor, *start: float) -> Array:
        """Residuals (m) on the scene of a RopePredictor, and shares that tell its start.

        Squares are the loss.
        """
        start_errors = ERRORS * np.subtract(start or [0.5] * self.starts, 0.5)
        labelled = len(self.places)
        t = self._t[-len(self._places) :]
        seen = np.isfinite(self._places)
        x, v, along = self.wind(predictor.scene, start_errors)
        motion = CubicHermiteSpline(t, x[:, :labelled], v[:, :labelled])

        def residuals(b: Array) -> Array:
            late = self.delay * b[-1]
            places = motion(np.clip(t + late, t[0], t[-1])) + self.offset * b[:-1].reshape(-1, 3)
            off = np.hstack((places, x[:, labelled:] + late * v[:, labelled:])) - self._places
            r = (off - (off * along).sum(axis=2, keepdims=True) * along)[seen] / self.sigma
            return np.concatenate((r * np.sqrt(2.0 / (1.0 + np.hypot(1.0, r / ROBUST))), b))

        best_residuals = least_squares(residuals, np.zeros(3 * labelled + 1), method="lm").fun
        return np.asarray(self.sigma * np.concatenate((best_residuals, start_errors)))


TINY = 1e-300  #: Least divisor.
ERROR_OVER_MEDIAN = 1.4826  #: Standard deviation of a normal error over its median magnitude.


def _nearest(curve: CubicHermiteSpline, points: Array) -> Array:
    """Arc lengths (m) of the places on the rope that are nearest to ``points`` (n, 3)."""
    s = np.linspace(curve.x[0], curve.x[-1], 4 * curve.x.size)
    s = s[np.linalg.norm(points[:, None] - curve(s), axis=2).argmin(axis=1)]
    for _ in range(3):  # each leaves of the error as much as curvature times distance
        tangent = curve(s, 1)
        along = ((points - curve(s)) * tangent).sum(axis=1) / (tangent**2).sum(axis=1)
        s = np.clip(s + along, curve.x[0], curve.x[-1])
    return np.asarray(s)


#: Metres of a file's unit of length.
_METRES = {"m": 1.0, "cm": 0.01, "mm": 1e-3}


class _Columns:
    """Columns of a track's CSV file by name; ValueError names what is wrong with the file."""

    def __init__(self, path: Path, file: str) -> None:
        _require_commas(path, file)
        try:
            self._data = np.genfromtxt(
                path, delimiter=",", names=True, deletechars="", loose=False, encoding="utf-8-sig"
            )
        except (OSError, ValueError) as error:
            raise ValueError(
                f"{file} is no table of numbers ({error}): give a CSV file, names in line 1"
            ) from error
        self._file = file
        self.names: tuple[str, ...] = self._data.dtype.names or ()

    def times(self) -> Array:
        """Return the times [s] of the frames."""
        t = np.array([])
        if "t" in self.names:
            t = self._data["t"]
        if t.size < 2 * FIRST or not (np.diff(t) > 0).all():
            raise ValueError(
                f"{self._file} needs a column t with {2 * FIRST} times or more, in s, in "
                "ascending order"
            )
        return t

    def vectors(self, points: Sequence[str], prefix: str = "") -> Array:
        """Return the columns POINT.x to POINT.z, with a prefix of the axis, as (frames, points, 3)."""
        wanted: list[str] = []
        for point in points:
            wanted += [f"{point}.{prefix}{axis}" for axis in "xyz"]
        for column in wanted:
            if column not in self.names:
                raise ValueError(
                    f"{self._file} has no column {column}: its columns are {', '.join(self.names)}"
                )
        table = np.array([self._data[column] for column in wanted]).T
        return table.reshape(-1, len(points), 3)


def _read(path: Path, track: Markers) -> _Frames:
    """Return the frames of a track's file; a ValueError names a column that is missing."""
    for side in SIDES:
        if side in track.places:
            raise ValueError(
                f"places.{side} has the name of an end of the rope: give the marker another name"
            )
    columns = _Columns(path, track.file)
    t = columns.times()
    leaning = any(name in columns.names for name in _DIRECTION_COLUMNS)
    if leaning and track.ends != "clamped":
        raise ValueError(
            f'{track.file} has directions, and ends = "{track.ends}" must be "clamped" to take them'
        )
    directions = np.zeros((t.size, 0, 3))
    if leaning:
        directions = columns.vectors(SIDES, "d")
    unit = _METRES[track.unit]
    return _Frames(
        t,
        unit * columns.vectors(SIDES),
        directions,
        unit * columns.vectors([*track.places, *track.unlabelled]),
    )


_DIRECTION_COLUMNS = ("left.dx", "left.dy", "left.dz", "right.dx", "right.dy", "right.dz")


def _require_commas(path: Path, name: str) -> None:
    """Refuse a table with semicolons or tabs between its columns: it may have decimal commas."""
    try:
        with path.open(encoding="utf-8-sig") as file:
            head = file.readline().strip()
            row = file.readline().strip()
    except (OSError, ValueError):
        return  # the reader says it
    for separator, word in ((";", "semicolons"), ("\t", "tabs")):
        if separator in head:
            if "," in row:
                comma = f", and {row!r} may have decimal commas"
            else:
                comma = ""
            raise ValueError(
                f"{name} has {word} between its columns{comma}: give a CSV file with commas "
                "between columns and decimal points"
            )
    if row.count(",") == 2 * head.count(",") + 1 and head.count(","):
        raise ValueError(
            f"{name} has {row.count(',') + 1} fields in line 2 and {head.count(',') + 1} names in "
            "line 1, as with decimal commas: give decimal points"
        )


def _checked(frames: _Frames, track: Markers) -> _Frames:
    """Return the frames from the first with both ends to the last.

    ValueError names where too much is lost.
    """
    t = frames.t
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(frames.directions, axis=2)
    for k, side in np.argwhere((lengths == 0.0) | np.isinf(lengths)):
        where = ", ".join(f"{SIDES[side]}.d{axis}" for axis in "xyz")
        is_none = f"{', '.join(f'{x:g}' for x in frames.directions[k, side])} is no direction"
        cure = "give a vector of finite length, or empty fields for a lost one"
        raise ValueError(
            f"{track.file}, row {k + 2}, t = {t[k]:.10g} s: {where} = {is_none}: {cure}"
        )
    both = np.flatnonzero(frames.whole)
    if both.size < 2 * FIRST:
        raise ValueError(
            f"{track.file} has both ends at {both.size} times, needed are {2 * FIRST}: give more"
        )
    gaps = np.diff(t[both])
    if gaps.max() > (GAP + 0.5) * frames.period:
        lost = (
            f"lacks an end or its direction for {gaps.max():g} s after t = "
            f"{t[both[gaps.argmax()]]:.10g} s"
        )
        raise ValueError(
            f"{track.file} {lost}, over {GAP} frames = {GAP * frames.period:g} s: fill the gap or "
            "end there"
        )
    between = slice(both[0], both[-1] + 1)
    return _Frames(
        t[between] - t[0], frames.ends[between], frames.directions[between], frames.markers[between]
    )


def _turned(frames: _Frames, track: Markers) -> tuple[float, Array, Array]:
    """Return spacing (m), places and leans of the ends (n, 2, 5), and markers in the rope's axes.

    The spacing is that at the start.
    """
    start, end = frames.ends[frames.whole][:FIRST].mean(axis=0)
    if not np.linalg.norm(np.cross(track.up, end - start)) > 0.0:
        raise ValueError(
            f"{track.file}: the ends hang above each other with up = {track.up}: give the "
            "direction of up"
        )
    axes, _ = Rotation.align_vectors(
        [[0, 1, 0], [1, 0, 0]], [track.up, end - start], weights=[np.inf, 1.0]
    )
    matrix = axes.as_matrix().T
    middle = 0.5 * (start + end)
    spacing = float(axes.apply(end - start)[0])
    nominal = 0.5 * spacing * np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    ends = (frames.ends - middle) @ matrix - nominal
    directions = np.broadcast_to([0.0, -1.0, 0.0], ends.shape)  # straight down
    if frames.directions.size:
        directions = frames.directions @ matrix
    across = np.linalg.norm(directions[..., ::2], axis=2, keepdims=True)
    angles = np.arctan2(across, -directions[..., 1:2])
    leans = directions[..., ::2] / np.maximum(across, TINY) * angles
    return spacing, np.concatenate((ends, leans), axis=2), (frames.markers - middle) @ matrix


def _smoothed(frames: _Frames, end_paths: Array, settle: float) -> tuple[Array, Array]:
    """Return times (s) and values, rates and accelerations (3, n, 2, 5) of the ends.

    They include times before the file begins.
    """
    frame = frames.period
    count = math.ceil(settle / frame) if settle else REST
    before = frames.t[0] + np.arange(-count, 0) * frame
    t = np.concatenate((before, frames.t))
    times = frames.t[frames.whole]
    seen = end_paths[frames.whole].reshape(-1, 10)
    if not settle:
        times = np.concatenate((before, times))
        seen = np.vstack((np.tile(seen[:FIRST].mean(axis=0), (REST, 1)), seen))
    smooth = np.zeros((3, t.size, 2, 5))
    # unit of time: a frame, as cross-validation seeks its parameter to 1e-5
    for k, x in enumerate(seen.T):
        spline = make_smoothing_spline(times / frame, x)
        smooth[..., k // 5, k % 5] = [spline(t / frame, order) / frame**order for order in range(3)]
    if settle:
        x, v, a = smooth[:, before.size]
        path = quintic.coefficients(t[before.size] - t[0], (x, 0.0, 0.0), (x, v, a))
        smooth[:, : before.size] = quintic.rates(path, (before - t[0])[:, None, None])
    smooth[1:, 0] = 0.0  # the ends rest at first
    return t, smooth


def _masked(markers: Array, sigma: float) -> Array:
    """``markers`` (n, markers, 3) without those that leap away from their running median."""
    # markers that were long lost warn
    with warnings.catch_warnings(category=RuntimeWarning, action="ignore"):
        median = generic_filter(markers, np.nanmedian, size=(MEDIAN, 1, 1), mode="mirror")
        away = np.abs(markers - median)
        usual = np.maximum(ERROR_OVER_MEDIAN * np.nanmedian(away, axis=0), sigma)
    return np.where((away > LEAP * usual).any(axis=2, keepdims=True), np.nan, markers)
