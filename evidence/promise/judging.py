"""Shares and distributions of a table of scenes, and the targets that they are held against."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from evidence.claims import Measurement
from evidence.tables import Table
from rope_model import Accuracy

from .wind import ASKED

#: factor within which an estimate is to be of the error
NEAR = 2.0


def completed(t: Table) -> Table:
    """The scenes whose runs went through."""
    kept = np.array([not failure or failure == "nan" for failure in t["failure"].astype(str)])
    return {name: column[kept] for name, column in t.items()}


def over_asked(t: Table, asked: Accuracy = ASKED) -> NDArray[np.float64]:
    """Error over what was asked, the worse one of end force and loop."""
    return np.maximum(t["end force"] / asked.end_force, t["loop [m]"] / asked.loop)


def near(estimated: NDArray[np.float64], error: NDArray[np.float64]) -> float:
    """Share of estimates within a factor of NEAR of the error."""
    ratio = estimated / error
    return float(np.mean((ratio > 1 / NEAR) & (ratio < NEAR)))


class Targets(NamedTuple):
    """Shares of scenes within what was asked, and of estimates within a factor of NEAR, that a draw is to reach."""

    within: float
    near: float


#: by the name of the draw
TARGETS = {"first": Targets(0.95, 0.8), "wide": Targets(0.97, 0.85)}


def claims(all_scenes: Table, targets: Targets = TARGETS["first"], asked: Accuracy = ASKED) -> list[Measurement]:
    """What was found, and the targets."""
    t = completed(all_scenes)
    over = over_asked(t, asked)
    return [
        Measurement(
            "share of the scenes within what was asked", float(np.mean(over <= 1)), "1", ">", targets.within - 1e-9
        ),
        Measurement("largest error over what was asked", float(over.max()), "1", "<", 2.0),
        Measurement(
            "share of the estimates of the end force within a factor of 2",
            near(t["end force, estimated"], t["end force"]),
            *("1", ">", targets.near - 1e-9),
        ),
        Measurement(
            "share of the estimates of the loop's place within a factor of 2",
            near(t["loop, estimated [m]"], t["loop [m]"]),
            *("1", ">", targets.near - 1e-9),
        ),
        Measurement(
            "median work over that of steps by places alone",
            float(np.median(t["work"] / t["work, before"])),
            *("1", "<", 1.0),
        ),
        Measurement("scenes that did not complete", float(len(all_scenes["kind"]) - len(t["kind"])), "1", "<", 0.5),
    ]
