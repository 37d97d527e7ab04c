"""A cable between two grippers as cameras see it: a synthetic measurement for `balance-rope identify`."""

import csv
import math
import re
import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline, make_interp_spline

from rope_model import EndMotion, Layout, Mesh, Model, Rope, Scene, Solver, Swivel, balance_rope

FRAME, SECONDS = 0.02, 2.0  # s
PLACES = {"a": 0.2, "b": 0.4, "c": 0.6, "d": 0.8}  # m along the rope
SIGMA, OFFSET, DELAY, GRIPPER = (
    1e-3,
    2e-3,
    4e-3,
    1e-4,
)  # standard errors: m, m, s, and m of the grippers' places
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
aside = np.column_stack(
    (0.15 * part, 0.1 * np.sin(2 * math.pi * part), 0.12 * part)
)  # m, of the left gripper
lean = 0.5 * math.pi - 0.5 * part  # rad, from plumb
grippers = np.stack((np.add(aside, [-0.2, 0.0, 0.0]), np.add(0.0 * aside, [0.2, 0.0, 0.0])), axis=1)
ways = np.stack(([np.sin(lean), -np.cos(lean), 0 * t], [0 * t - 1.0, 0 * t, 0 * t]))  # out of them


def seen() -> np.ndarray:
    """Return (n, markers, 3): places of the markers, m."""
    rope, path, found = balance_rope(SCENE), make_interp_spline(t, aside, k=5), []
    for k, now in enumerate(t.tolist()):
        speed, acceleration = (path(now, 1), path(now, 2)) if now > 0.0 else np.zeros((2, 3))
        moves = [*aside[k], *speed, *acceleration, 0.0, 0.0, lean[k]]
        left, right = EndMotion(*moves), EndMotion(lean=-0.5 * math.pi)
        status = rope.advance_to(now, left, right) if k else rope.initialize(now, left, right)
        if not status.valid:
            raise RuntimeError(status.message)
        rows = rope.rows()  # arc length, r, r': a cubic between two nodes
        found.append(CubicHermiteSpline(rows[:, 0], rows[:, 1:4], rows[:, 4:7])([*PLACES.values()]))
    return np.array(found)


def write(folder: Path, markers: np.ndarray, seed: int, begin: float = 0.0, **keys: str) -> Path:
    """Write both files: with noise, markers off their places, a late camera, lost and swapped markers, its own axes.

    From the time ``begin`` of the file on; ``keys`` are those of [[measured]].
    """
    rng = np.random.default_rng(seed)
    turn, shift = np.linalg.qr(rng.normal(size=(3, 3)))[0], rng.normal(size=3)
    turn *= np.linalg.det(turn)
    noisy = CubicSpline(t, markers)(
        np.maximum(t - DELAY * rng.normal(), t[0])
    ) + OFFSET * rng.normal(size=(4, 3))
    swapped = rng.random(t.size) < 0.02
    noisy[swapped] = noisy[swapped][:, [1, 0, 2, 3]]
    noisy += SIGMA * rng.normal(size=noisy.shape)
    noisy[rng.random(noisy.shape[:2]) < 0.05] = np.nan
    rough = grippers + GRIPPER * rng.normal(size=grippers.shape)
    columns, names = {"t": t - t[0]}, ["left", "right", *PLACES]
    for name, of in zip(names, np.concatenate((rough, noisy), axis=1).swapaxes(0, 1), strict=True):
        columns |= {
            f"{name}.{axis}": 1e3 * (of @ turn.T + shift)[:, i] for i, axis in enumerate("xyz")
        }  # mm
    for name, way in zip(names, ways, strict=False):
        columns |= {f"{name}.d{axis}": (turn @ way)[i] for i, axis in enumerate("xyz")}
    with (folder / "swing.csv").open("w", newline="", encoding="utf-8") as file:
        rows = [
            ["" if math.isnan(x) else f"{x:.6g}" for x in row]
            for row in zip(*columns.values(), strict=True)
        ]
        rows = [row for row in rows if float(row[0]) >= begin]
        csv.writer(file).writerows([[*columns], *rows])
    path = folder / "swing.toml"
    text = (Path(__file__).parent / "measurements" / "swing.toml").read_text(encoding="utf-8")
    for key, value in ({"up": str(turn[:, 1].tolist())} | keys).items():
        text, known = re.subn(f"(?m)^{key} = .*", f"{key} = {value}", text)
        text += "" if known else f"{key} = {value}\n"
    path.write_text(text, encoding="utf-8")
    return path


if __name__ == "__main__":
    print(write(Path(sys.argv[1] if len(sys.argv) > 1 else "."), seen(), seed=1))
