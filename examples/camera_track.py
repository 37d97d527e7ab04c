"""A cable between two grippers, seen by cameras: a synthetic file for ``balance-rope identify``."""

import csv
import math
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline, make_interp_spline

from rope_model import EndMotion, Layout, Mesh, Model, Rope, Scene, Solver, Swivel, balance_rope

FRAME = 0.02  # s, between two pictures
SECONDS = 2.0  # s, of the file
PLACES = {"a": 0.2, "b": 0.4, "c": 0.6, "d": 0.8}  # m along the rope
# standard errors
SIGMA = 1e-3  # m, of a marker in a picture
OFFSET = 2e-3  # m, of a marker's place on the rope
DELAY = 4e-3  # s, of the camera
GRIPPER = 1e-4  # m, of the grippers' places
SWAPPED = 0.02  # share of pictures with two markers swapped
LOST = 0.05  # share of markers that are lost
TRUTH = {"torsional_stiffness": 8e-3, "bending_stiffness": 1e-2, "rope.beta_K": 0.05}
CABLE = Rope(
    length=1.0,
    mass_per_length=0.12,
    Qa=2e3,
    Qb=0.0,
    Qc=0.0,
    Qd=8e-3,
    EI=1e-2,
    beta_K=0.05,
    diameter=0.008,
    rhoJ=0.12 * 0.008**2 / 8,
)
SCENE = Scene(
    rope=CABLE,
    layout=Layout(spacing=0.4),
    left=Swivel(attachment="clamped"),
    right=Swivel(attachment="clamped"),
    mesh=Mesh(kind="eem", elements=16),
    solver=Solver(step_max=FRAME, tolerance=1e6),
    model=Model("torsional"),
)

t = np.arange(-0.5, SECONDS + 0.5 * FRAME, FRAME)  # at rest at first
part = np.clip((t - 0.2) / 0.8, 0.0, 1.0)
part = part**3 * (10 - 15 * part + 6 * part**2)
# m, of the left gripper
aside = np.column_stack((0.15 * part, 0.1 * np.sin(2 * math.pi * part), 0.12 * part))
lean = 0.5 * math.pi - 0.5 * part  # rad, from plumb
grippers = np.stack((np.add(aside, [-0.2, 0.0, 0.0]), np.add(0.0 * aside, [0.2, 0.0, 0.0])), axis=1)
ways = np.stack(([np.sin(lean), -np.cos(lean), 0 * t], [0 * t - 1.0, 0 * t, 0 * t]))  # out of them


def marker_places() -> np.ndarray:
    """Return (n, markers, 3): places of the markers, m."""
    rope = balance_rope(SCENE)
    path = make_interp_spline(t, aside, k=5)
    right = EndMotion(lean=-0.5 * math.pi)
    markers = []
    for k, now in enumerate(t.tolist()):
        speed = acceleration = np.zeros(3)
        if now > 0.0:
            speed = path(now, 1)
            acceleration = path(now, 2)
        moves = [*aside[k], *speed, *acceleration]
        left = replace(EndMotion(*moves), lean=lean[k])
        advance = rope.advance_to if k else rope.initialize
        status = advance(now, left, right)
        if not status.valid:
            raise RuntimeError(status.message)
        rows = rope.rows()  # arc length, r, r': a cubic between two nodes
        curve = CubicHermiteSpline(rows[:, 0], rows[:, 1:4], rows[:, 4:7])
        markers.append(curve([*PLACES.values()]))
    return np.array(markers)


def write(folder: Path, markers: np.ndarray, seed: int, begin: float = 0.0, **keys: str) -> Path:
    """Write both files, with the errors of cameras and axes of their own.

    The errors are noise, markers off their places, a late camera, lost and swapped markers. The
    file begins at the time ``begin`` of the motion; ``keys`` are those of [[measured]].
    """
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    shift = rng.normal(size=3)
    turn *= np.linalg.det(turn)
    late = np.maximum(t - DELAY * rng.normal(), t[0])
    noisy = CubicSpline(t, markers)(late) + OFFSET * rng.normal(size=(4, 3))
    swapped = rng.random(t.size) < SWAPPED
    noisy[swapped] = noisy[swapped][:, [1, 0, 2, 3]]
    noisy += SIGMA * rng.normal(size=noisy.shape)
    noisy[rng.random(noisy.shape[:2]) < LOST] = np.nan
    rough = grippers + GRIPPER * rng.normal(size=grippers.shape)
    columns = {"t": t - t[0]}
    names = ["left", "right", *PLACES]
    points = np.concatenate((rough, noisy), axis=1).swapaxes(0, 1)
    for name, point in zip(names, points, strict=True):
        in_mm = 1e3 * (point @ turn.T + shift)
        columns |= {f"{name}.{axis}": in_mm[:, i] for i, axis in enumerate("xyz")}
    for name, way in zip(names, ways, strict=False):
        columns |= {f"{name}.d{axis}": (turn @ way)[i] for i, axis in enumerate("xyz")}
    rows = [[*map(_text, row)] for row in zip(*columns.values(), strict=True)]
    rows = [row for row in rows if float(row[0]) >= begin]
    with (folder / "swing.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([[*columns], *rows])
    path = folder / "swing.toml"
    text = (Path(__file__).parent / "measurements" / "swing.toml").read_text(encoding="utf-8")
    for key, value in ({"up": str(turn[:, 1].tolist())} | keys).items():
        text, known = re.subn(f"(?m)^{key} = .*", f"{key} = {value}", text)
        if not known:
            text += f"{key} = {value}\n"
    path.write_text(text, encoding="utf-8")
    return path


def _text(x: float) -> str:
    """Return a number of the file, "" for a lost marker."""
    return "" if math.isnan(x) else f"{x:.6g}"


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path()
    print(write(target, marker_places(), seed=1))
