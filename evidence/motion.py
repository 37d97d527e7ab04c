"""Motions of cables that somebody has measured, in the layout of DEFORM (arXiv 2406.05931): fitted, and judged.

``python -m evidence.motion FOLDER CABLE.toml``. The user has fetched FOLDER himself, of one cable
or of several in folders of their own. FOLDER/train and FOLDER/eval have pickled lists: frames at
100 Hz of three axes, the last up, of vertices (m). Grippers hold the outermost two on either side.
The one [[measured]] of CABLE.toml is as that of examples/measurements/motion.toml. Length and
places (of v2, v3 and so on) that it lacks are those of smooth curves through the vertices of the
runs that are fitted.

The cable moves when a run begins. Before that the grippers run up for LEAD to their first speed, and springs draw the
markers along, to the place and speed that they have in the first START frames. Then it is free.
"""

import math
import pickle
import re
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy.interpolate import CubicSpline, make_smoothing_spline
from scipy.optimize import brentq

from hoist_demo.calibration.definition import MeasurementFile
from hoist_demo.calibration.fit import fit
from hoist_demo.calibration.identify import residuals_of, stacked
from hoist_demo.calibration.tracks import Markers
from hoist_demo.files.reading import read
from rope_model import EndMotion, PointForces, Scene, balance_rope
from rope_model.boundary.point_forces import NO_FORCES, at_places, elements_at

Array = NDArray[np.float64]
RATE = 100.0  #: Hz
FITTED = 5  #: runs
JUDGED = 10  #: runs
LEAD = 30  #: frames
START = 10  #: frames
#: part of the squares that a further step must save: many curvatures lie in a long valley
FOUND = 1e-4
HARDEST = 50.0  #: m/s^2, beyond the grippers
SPRING = 20.0  #: 1/s, of a marker's share of the mass on its spring, critically damped: slow against a frame


class _Lists(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        raise pickle.UnpicklingError(
            f"asks for {module}.{name}: give pickled lists of numbers alone"
        )


def vertices(path: Path) -> Array:
    """Return the vertices (n, frames, 3) of a run."""
    with path.open("rb") as file:
        frames = np.array(_Lists(file).load(), dtype=float)
    if frames.ndim != 3 or frames.shape[1] != 3 or frames.shape[2] < 5:
        raise ValueError(
            f"{path} has the shape {frames.shape}: it must be frames x 3 axes x 5 or more vertices"
        )
    return frames.transpose(2, 0, 1)


def run_up(last: Array, speed: Array, k: Array) -> tuple[Array, Array]:
    """Return places and speeds ``k`` frames after a start at rest, on the way to ``last`` and ``speed`` (per frame)."""
    u = (k / LEAD).reshape(-1, *(1,) * np.ndim(last))
    return last - speed * LEAD * (0.5 - u**4 * (2.5 - 3 * u + u * u)), speed * u**3 * (
        10 - 15 * u + 6 * u * u
    )


def started(places: Array) -> tuple[Array, Array]:
    """Return place and speed (per frame) in the first of START frames, those of a parabola."""
    parabola = np.polyfit(np.arange(START), places[:START].reshape(START, -1), 2)
    place, speed = parabola[::-1][:2].reshape(2, *places.shape[1:])
    return place, speed


def smooth(end: Array) -> Array:
    """Return a path (frames, 3), the smoother the harder it leaps: leaps are a marker's, and the rope refuses them."""
    frames = np.arange(float(len(end)))
    path = end
    lam = 0.1
    while np.abs(np.diff(path, 2, axis=0)).max() * RATE**2 > HARDEST:
        path = np.column_stack([make_smoothing_spline(frames, x, lam=lam)(frames) for x in end.T])
        lam *= 3.0
    return path


def track(path: Path) -> tuple[str, Array]:
    """Return the header and columns of a run as a track; the rope leaves its grippers at the last vertex but one."""
    v = vertices(path)
    ends = {"left.": v[1], "left.d": v[1] - v[0], "right.": v[-2], "right.d": v[-2] - v[-1]}
    ends = {name: smooth(end) for name, end in ends.items()}
    columns = [
        np.vstack((run_up(*started(end), np.arange(float(LEAD)))[0], end)) for end in ends.values()
    ]
    columns += [np.vstack((np.full((LEAD, 3), np.nan), marker)) for marker in v[2:-2]]
    names = [
        "t",
        *(
            f"{name}{axis}"
            for name in (*ends, *(f"v{k}." for k in range(2, len(v) - 2)))
            for axis in "xyz"
        ),
    ]
    return ",".join(names), np.column_stack((np.arange(LEAD + v.shape[1]) / RATE, *columns))


def arc_lengths(paths: Sequence[Path]) -> Array:
    """Return the medians over the frames of the arc lengths (m) from the left gripper to each vertex on the rope."""
    found = []
    xi = np.linspace(0.0, 1.0, 20)
    for v in map(vertices, paths):
        for frame in v[:, ::10].swapaxes(0, 1):
            chords = np.linalg.norm(np.diff(frame, axis=0), axis=1)
            ways = [(1, (frame[k + 1] - frame[k]) / chords[k]) for k in (0, -2)]
            at = np.concatenate(([0.0], np.cumsum(chords[1:-1])))
            curve = CubicSpline(at, frame[1:-1], bc_type=tuple(ways))(
                at[:-1, None] + xi * chords[1:-1, None]
            )
            found.append(np.linalg.norm(np.diff(curve, axis=1), axis=2).sum(axis=1))
    return np.concatenate(([0.0], np.cumsum(np.median(found, axis=0))))


class Started(Markers):
    """Markers on a rope that moves when its run begins, LEAD frames after the file; all frames count alike."""

    @property
    def moved(self) -> list[tuple[EndMotion, EndMotion]]:
        """Motions of the ends in the frames of the run."""
        return self.motions(np.zeros((2, 2, 3)))[-len(self.seen) :]

    @property
    def seen(self) -> Array:
        """Places of the markers in the frames of the run (frames, markers, 3)."""
        return self._places[LEAD:]

    def wound(self, scene: Scene) -> Array:
        """Return the places of the markers on the rope in the frames of the run; springs draw them there before it."""
        left, right = (
            replace(swivel, attachment="clamped") for swivel in (scene.left, scene.right)
        )
        layout = replace(scene.layout, spacing=self._spacing)
        rope = balance_rope(scene.with_(left=left, right=right, layout=layout))
        found = []
        s = np.array([*self.places.values()])
        share = scene.rope.mass_per_length * scene.rope.length / (s.size + 1)
        targets = run_up(*started(self.seen), np.arange(LEAD + 1.0))
        before = len(self._places) - len(self._t)
        for k, (t, ends) in enumerate(
            zip(self._t.tolist(), self.motions(np.zeros((2, 2, 3))), strict=True), before
        ):
            if 0 < k <= LEAD:
                rows = rope.rows()
                h = t - rope.time
                at = elements_at(s, np.diff(rows[:, 0]))
                r = at_places(rows[:, 1:7], *at)
                v = at_places(rows[:, 7:], *at)
                missing = SPRING * (targets[0][k] - r - v * h) + 2.0 * (targets[1][k] / h - v)
                pull = share * SPRING * missing
                rope.apply(PointForces(s, pull, pull, rope.time, t))
            elif k == LEAD + 1:
                rope.apply(NO_FORCES)
            if k == before:
                status = rope.initialize(t, *ends)
            else:
                status = rope.advance_to(t, *ends)
            if not status.valid:
                raise RuntimeError(f"{self.file}, {t:g} s from its first time: {status.message}")
            if k >= LEAD:
                rows = rope.rows()
                found.append(at_places(rows[:, 1:7], *elements_at(s, np.diff(rows[:, 0]))))
        return np.array(found)

    def predict(self, predictor: Any, *_: float) -> Array:
        """Residuals (m) on the scene of a prediction.RopePredictor, without offsets and delay."""
        off = (self.wound(predictor.scene) - self.seen)[np.isfinite(self.seen)]
        return np.concatenate((off, np.zeros(self.nuisance)))

    def misses(self, places: Array) -> Array:
        """Return (frames, markers, 3): ways (m) from the markers to ``places``."""
        return np.asarray(places - self.seen)

    @property
    def scatter(self) -> float:
        """Noise of a marker (m, RMS): third differences of the frames have 20 times its variance, and little motion."""
        return rms(np.diff(self.seen, 3, axis=0)) / math.sqrt(20.0)

    def hung(self, length: float) -> Array:
        """Return the places of the markers on a chain, without stiffness and inertia, between the same ends."""
        s = np.array([*self.places.values()])
        across = np.array([0.5 * self._spacing, 0.0, 0.0])
        found = []
        for left, right in self.moved:
            start = np.array(left.position) - across
            end = np.array(right.position) + across
            found.append(start + chain(end - start, s, length))
        return np.array(found)


class Motions(MeasurementFile):
    """A file of such markers."""

    measurements: list[Started] = Field(alias="measured", min_length=1)  # type: ignore[assignment]


def chain(span: Array, s: Array, length: float) -> Array:
    """Return the places (n, 3) at arc lengths ``s`` of a hanging chain from the origin to ``span``, Y up."""
    across = math.hypot(span[0], span[2])
    rise = float(span[1])
    if length <= math.dist(span, (0.0, 0.0, 0.0)):
        return np.outer(s / length, span)
    slack = math.sqrt(length**2 - rise**2) / across  # sinh u / u
    a = 0.5 * across / brentq(lambda u: math.sinh(u) / u - slack, 1e-6, 20.0)
    lowest = 0.5 * across - a * math.atanh(rise / length)
    x = lowest + a * np.arcsinh(s / a - math.sinh(lowest / a))
    y = a * (np.cosh((x - lowest) / a) - math.cosh(lowest / a))
    return np.column_stack((x * span[0] / across, y, x * span[2] / across))


def motions(folder: Path, cable: Path, out: Path, most: int, lengths: Array) -> Motions:
    """Write ``most`` runs of a folder as tracks with a file that names them, and read that."""
    text, _, asked = cable.read_text(encoding="utf-8").partition("[[measured]]")
    if "places" not in asked:
        text = text.replace("[rope]", f"[rope]\nlength = {lengths[-1]:.4f}")
        asked += f"places = {{ {', '.join(f'v{k} = {s:.4f}' for k, s in enumerate(lengths[1:-1], 2))} }}\n"
    asked += f"skip = {(LEAD - 0.5) / RATE}\n"
    for path in runs(folder, most):
        header, columns = track(path)
        name = f"{folder.name}-{path.stem}.csv"
        np.savetxt(out / name, columns, "%.6g", ",", header=header, comments="")
        text += "[[measured]]" + re.sub('file = ".*"', f'file = "{name}"', asked) + "\n"
    file = out / f"{folder.name}.toml"
    file.write_text(text, encoding="utf-8")
    return read(file, Motions)


def runs(folder: Path, most: int) -> list[Path]:
    """Return the first runs of a folder."""
    return sorted(folder.glob("*.pkl"))[:most]


@dataclass(frozen=True)
class Judged:
    """Misses of each run that judges, by the rope and by a chain, its markers' scatter (m), and processor time (s)."""

    misses: list[Array]
    chain: list[Array]
    scatter: list[float]
    seconds: float

    def row(self, cable: str) -> str:
        """Return the cable's row of the table."""
        each, chain = ([1e3 * rms(m) for m in of] for of in (self.misses, self.chain))
        largest = 1e3 * max(np.linalg.norm(m, axis=2).max() for m in self.misses)
        # the data set's own metric: of all coordinates, and those of the vertices in the grippers are right
        absolute = 1e3 * np.mean(
            [np.abs(m).mean() * m.shape[1] / (m.shape[1] + 4) for m in self.misses]
        )
        numbers = (
            np.median(each),
            np.mean(each),
            largest,
            absolute,
            np.median(chain),
            1e3 * np.mean(self.scatter),
            self.seconds,
        )
        return (
            f"| {cable} | "
            + " | ".join(f"{x:.0f}" if x >= 100 else f"{x:.1f}" for x in numbers)
            + " |"
        )


def rms(misses: Array) -> float:
    """Return the root of the mean square distance."""
    return float(np.sqrt(np.mean(np.sum(np.square(misses), axis=2))))


def judged(folder: Path, cable: Path, out: Path) -> Judged:
    """Fit, and print what is found and the RMS distance of the markers in each run that judges."""
    began = time.process_time()
    out.mkdir(parents=True, exist_ok=True)
    lengths = arc_lengths(runs(folder / "train", FITTED))
    judges = motions(folder / "eval", cable, out, JUDGED, lengths)
    fitted = motions(folder / "train", cable, out, FITTED, lengths)
    problem = fitted.problem
    measured = fitted.measurements
    found = fit(residuals_of(problem, measured, *stacked(measured)), len(problem.names), FOUND)
    for name, share, reach in zip(problem.names, found.norm_params, found.reaches, strict=True):
        low, value, high = (
            problem.data[name].at(float(np.clip(share + k * reach, 0.0, 1.0))) for k in (-1, 0, 1)
        )
        print(f"{name} = {value:.4g} ({low:.4g} to {high:.4g})")
    scene = problem.predictor(found.norm_params).scene
    misses = list[Array]()
    chains = list[Array]()
    for one in judges.measurements:
        misses.append(one.misses(one.wound(scene)))
        chains.append(one.misses(one.hung(scene.rope.length)))
        print(f"{one.file}: {1e3 * rms(misses[-1]):.1f} mm")
    return Judged(
        misses, chains, [one.scatter for one in judges.measurements], time.process_time() - began
    )


def main(folder: str, cable: str, out: str = "out/motion") -> None:
    """Judge the cable of a folder, or of each folder in it, and print a table of several."""
    if (Path(folder) / "train").is_dir():
        judged(Path(folder), Path(cable), Path(out))
        return
    rows = []
    for one in sorted(path.parent for path in Path(folder).glob("*/train")):
        print(one.name)
        rows.append(judged(one, Path(cable), Path(out, one.name)).row(one.name))
    head = "| cable, mm | median RMS | mean | largest | absolute | chain, median | scatter | processor, s |"
    print("", head, "|---" * 8 + "|", *rows, sep="\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
