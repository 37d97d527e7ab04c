"""What a scene can have: each feature draws its parameters by the names of the interface, from numbers of its own.

A feature that is left out leaves the others as they are, so that a finding can be made smaller.
Ranges are those of mine hoists, and a little more. ``tests/project/test_invariants.py`` fails while
a parameter of the tables is not drawn.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from signal_names import SIDES

from rope_model import CONSTRUCTIONS, Rope, rope
from rope_model.catalogue import BEARINGS, rope_of
from rope_model.parameters import AT_START
from rope_model.scene_names import choices_of

T = TypeVar("T")
Values = dict[str, Any]

LENGTH = (20.0, 1500.0)  # m
DIAMETER = (0.02, 0.06)  # m
SPACING = (1.2, 4.0)  # m
DURATION = (0.4, 2.0)  # s, of a run
#: parameters that no feature draws, and why
NOT_DRAWN = {
    "layout.gravity": "symmetries.other_units draws units in which it is another number",
}


class Draws:
    """Numbers of one feature of one case; the same seed gives the same."""

    def __init__(self, seed: int, number: int, feature: str) -> None:
        self._rng = np.random.default_rng([seed, number, zlib.crc32(feature.encode())])

    def evenly(self, low: float, high: float) -> float:
        return float(self._rng.uniform(low, high))

    def in_logarithms(self, low: float, high: float) -> float:
        return float(np.exp(self._rng.uniform(math.log(low), math.log(high))))

    def one_of(self, *choices: T) -> T:
        return choices[int(self._rng.integers(len(choices)))]

    def chance(self, share: float) -> bool:
        return bool(self._rng.uniform() < share)

    def sometimes_evenly(self, share: float, low: float, high: float) -> float:
        """Between these bounds in this share of cases, 0 in the others."""
        if self.chance(share):
            return self.evenly(low, high)
        return 0.0

    def sign(self) -> float:
        return self.one_of(-1.0, 1.0)

    def word(self, name: str) -> int:
        """The code of one of the words of a choice."""
        return int(self._rng.integers(len(choices_of(name))))


@dataclass
class Drawn:
    """What has been drawn so far; a feature adds to ``values``."""

    draws: Draws
    duration: float  # s
    values: Values = field(default_factory=dict)

    @property
    def length(self) -> float:
        return float(self.values["rope.length"])

    @property
    def spacing(self) -> float:
        return float(self.values["layout.spacing"])

    def code(self, name: str, word: str) -> int:
        return choices_of(name).index(word)


def catalogue_rope(drawn: Drawn) -> None:
    """Any rope of the catalogue, at any place in the ranges of its data."""
    draws = drawn.draws
    construction = draws.one_of(*CONSTRUCTIONS)
    diameter = draws.evenly(*DIAMETER)
    length = draws.in_logarithms(*LENGTH)
    lay = draws.one_of("right-hand", "left-hand")
    known = rope(construction, diameter, length, lay)
    made = rope_of(
        diameter,
        length,
        lay,
        **{name: draws.evenly(x.low, x.high) for name, x in known.data.items()},
    )
    names = ("length", "mass_per_length", "Qa", "Qb", "Qc", "Qd", "EI", "rhoJ", "diameter")
    drawn.values |= {f"rope.{name}": getattr(made, name) for name in names}
    drawn.values["rope.beta_K"] = draws.in_logarithms(3e-4, 5e-3)
    drawn.values["layout.spacing"] = draws.evenly(*SPACING)


def damping(drawn: Drawn) -> None:
    for name in ("torsion_damping", "bending_damping"):
        drawn.values[f"rope.{name}"] = drawn.draws.in_logarithms(0.2, 5.0)


def unequal_coupling(drawn: Drawn) -> None:
    """Qb and Qc unequal, as published pairs are, and more; their mean stays."""
    part = drawn.draws.evenly(-0.3, 0.3)
    mean = drawn.values["rope.Qb"]
    drawn.values |= {"rope.Qb": (1 + part) * mean, "rope.Qc": (1 - part) * mean}


def no_coupling(drawn: Drawn) -> None:
    drawn.values |= {"rope.Qb": 0.0, "rope.Qc": 0.0}


def stiffening(drawn: Drawn) -> None:
    drawn.values["rope.c2"] = drawn.draws.evenly(0.05, 0.5)


def installed_twist(drawn: Drawn) -> None:
    drawn.values["rope.installed_twist"] = drawn.draws.evenly(-0.01, 0.01) * drawn.length


def permanent_curvature(drawn: Drawn) -> None:
    """Of a reel, as the loop bends or about, and uneven along the rope."""
    draws = drawn.draws
    # of ropes that do not roll over: below 4 Qd / L, see docs/theory/rope.md
    most = min(0.05, 0.4 * drawn.values["rope.Qd"] / (drawn.length * drawn.values["rope.EI"]))
    drawn.values["rope.initial_curvature"] = draws.evenly(0.2, 1.0) * most
    drawn.values["rope.initial_curvature_angle"] = draws.sometimes_evenly(0.5, -0.5, 0.5)
    if draws.chance(0.5):
        for place in ("left", "1", "2", "middle", "4", "5", "right"):
            for across in ("", "_across"):
                drawn.values[f"rope.curvature_{place}{across}"] = draws.evenly(-0.3, 0.3) * most


def wire_friction(drawn: Drawn) -> None:
    draws = drawn.draws
    drawn.values |= {
        "rope.EI_stick": drawn.values["rope.EI"] * draws.in_logarithms(1.2, 15.0),
        "rope.slip_moment": draws.in_logarithms(0.1, 20.0),
        "rope.slip_factor": draws.evenly(0.0, 0.05),
    }


def swivels(drawn: Drawn) -> None:
    """Each held, free or with the friction of one of the catalogue's bearings; some are released on the way."""
    draws = drawn.draws
    for side in SIDES:
        name = f"{side}.swivel"
        bearing = BEARINGS[draws.one_of(*BEARINGS)]
        running, starting = (draws.in_logarithms(x.low, x.high) for x in bearing.values())
        drawn.values |= {
            f"{name}.mode": draws.word(f"{name}.mode"),
            f"{name}.mean_diameter": draws.evenly(0.06, 0.2),
            f"{name}.mu_kinetic": running,
            f"{name}.mu_static": running * starting,
            f"{name}.seal_moment": draws.sometimes_evenly(0.3, 0.0, 3.0),
            f"{name}.inertia": draws.in_logarithms(0.01, 0.3),
            f"{name}.release_time": _release_time(draws, drawn.duration),
            f"{name}.start": draws.word(f"{name}.start"),
        }


def _release_time(draws: Draws, duration: float) -> float:
    """From the start of any run, from the start of this one, or on the way."""
    if draws.chance(0.3):
        return draws.evenly(0.1, 0.9) * duration
    return draws.one_of(AT_START, 0.0)


def attachments(drawn: Drawn) -> None:
    for side in SIDES:
        drawn.values[f"{side}.swivel.attachment"] = drawn.draws.word(f"{side}.swivel.attachment")


def mesh(drawn: Drawn) -> None:
    """Kinds other than the fitted one, with elements that resolve the loop's bend."""
    draws = drawn.draws
    kind = drawn.draws.one_of("eem", "tmn", "auto")
    drawn.values["mesh.kind"] = drawn.code("mesh.kind", kind)
    if kind == "eem":
        drawn.values["mesh.elements"] = int(
            min(max(drawn.length / draws.evenly(0.5, 1.0), 20), 600)
        )
    elif kind == "tmn":
        # the fine segments take counts . coarse / (2, 4, 8, 4, 2), 12 coarse lengths and more
        coarse = draws.evenly(0.6, 1.0) * min(2.0, drawn.length / 40)
        loop = 8 * draws.one_of(4, 5, 6)
        counts = draws.one_of(
            (2, 4, loop, 4, 2), (4, 8, loop, 8, 4), (2, 0, loop, 0, 2), (0, 0, loop, 0, 0)
        )
        drawn.values |= {f"mesh.counts[{i + 1}]": count for i, count in enumerate(counts)}
        drawn.values |= {
            "mesh.coarse_length": coarse,
            "mesh.end_levels": draws.one_of(0, 1, 2, 3),
            "mesh.grading_length": 1.0,
        }
        if drawn.length < 400:
            drawn.values["mesh.grading_length"] = draws.one_of(0.0, 0.5, 1.0)
    else:
        drawn.values["mesh.loop_error"] = draws.in_logarithms(1e-3, 0.05)
        if drawn.length < 200:
            drawn.values["mesh.lateral_frequency"] = draws.one_of(0.0, 0.0, 1.0, 2.0)


def accuracy(drawn: Drawn) -> None:
    drawn.values["accuracy.end_force"] = drawn.draws.in_logarithms(1e-4, 1e-2)
    drawn.values["accuracy.loop"] = drawn.draws.in_logarithms(2e-3, 0.1)


def solver(drawn: Drawn) -> None:
    draws = drawn.draws
    drawn.values |= {
        "solver.step_max": draws.one_of(0.005, 0.01, 0.02, 0.04),
        "solver.step_min": draws.one_of(1e-6, 1e-5),
        "solver.tolerance": draws.one_of(0.3, 1.0, 3.0, 1e6),
        "solver.newton_tolerance": draws.in_logarithms(1e-7, 1e-5),
        "solver.rho_inf": draws.evenly(0.3, 0.9),
        "solver.work_max": draws.one_of(0, 0, 60),
    }


def fidelity(drawn: Drawn) -> None:
    drawn.values["model.fidelity"] = drawn.draws.word("model.fidelity")
    drawn.values["model.force_tolerance"] = drawn.draws.one_of(0.0, 0.0, 2e-3, 1e-2)


def inputs(drawn: Drawn) -> None:
    draws = drawn.draws
    drawn.values |= {
        "inputs.given": draws.word("inputs.given"),
        "inputs.bandwidth": draws.one_of(0.0, draws.in_logarithms(0.3, 5.0)),
        "inputs.estimate_bandwidth": draws.one_of(0.0, draws.in_logarithms(5.0, 30.0)),
        "inputs.misfit_max": draws.one_of(0.5, 2.0),
        "inputs.acceleration_max": draws.one_of(50.0, 100.0),
        "inputs.hold_max": draws.one_of(0.5, 1.0, 3.0),
    }


def stations(drawn: Drawn) -> None:
    first = drawn.draws.evenly(0.0, 0.9)
    drawn.values |= {"station.first": first, "station.last": drawn.draws.evenly(first, 1.0)}


def lining(drawn: Drawn) -> None:
    """The shaft's wall: a rectangle or a circle, with the ends inside."""
    draws = drawn.draws
    width = drawn.spacing + drawn.draws.evenly(1.0, 4.0)
    drawn.values["lining.width"] = width
    if draws.chance(0.5):
        drawn.values |= {"lining.depth": width, "lining.rounding": 1.0}
    else:
        drawn.values["lining.depth"] = draws.evenly(1.0, 5.0)
        drawn.values["lining.rounding"] = draws.evenly(0.0, 0.5)
    drawn.values["lining.x"] = draws.evenly(-0.2, 0.2)
    drawn.values["lining.z"] = draws.evenly(-0.2, 0.2)


def conveyances(drawn: Drawn) -> None:
    draws = drawn.draws
    drawn.values |= {
        "conveyance.width": drawn.spacing * draws.evenly(0.2, 0.8),
        "conveyance.depth": draws.evenly(0.5, 2.0),
        "conveyance.height": draws.evenly(2.0, 8.0),
        "conveyance.above": draws.evenly(0.0, 1.0),
        "head_ropes.diameter": draws.evenly(0.02, 0.04),
        "head_ropes.row": draws.evenly(0.1, 1.0),
    }


def dividers(drawn: Drawn) -> None:
    """Beams between the legs and beside them; one is below the lower end, where a loop may meet it."""
    draws = drawn.draws
    for k in range(draws.one_of(1, 1, 2, 4)):
        drawn.values |= {
            f"divider_{k + 1}.size": draws.evenly(0.05, 0.4),
            f"divider_{k + 1}.y": -draws.evenly(0.02, 0.6) * drawn.length,
            f"divider_{k + 1}.offset": drawn.spacing
            * draws.one_of(0.0, draws.evenly(-0.2, 0.2), draws.evenly(0.6, 2)),
            f"divider_{k + 1}.direction": draws.one_of(0.0, 0.0, draws.evenly(-0.2, 0.2)),
            f"divider_{k + 1}.rounding": draws.one_of(0.0, 1.0),
        }


def sump(drawn: Drawn) -> None:
    """A floor below, or at the height of, the loop at rest (ends are drawn at heights from 0 up)."""
    drawn.values["sump.level"] = -drawn.length * drawn.draws.evenly(0.3, 0.8)


def contact(drawn: Drawn) -> None:
    draws = drawn.draws
    drawn.values |= {
        "contact.stiffness": draws.one_of(0.0, draws.in_logarithms(1e5, 3e6)),
        "contact.damping": draws.evenly(0.0, 1.0),
        "contact.friction": draws.evenly(0.0, 0.4),
        "contact.slip_speed": draws.in_logarithms(3e-3, 0.1),
    }


def self_contact(drawn: Drawn) -> None:
    drawn.values["contact.rope_stiffness"] = drawn.draws.in_logarithms(1e5, 1e7)


def guards(drawn: Drawn) -> None:
    draws = drawn.draws
    low = -0.45 * drawn.length
    thresholds = {
        "rise": (0.05, 2.0),
        "window": (0.05, 2.0),
        "clearance": (0.02, 0.5),
        "turns": (0.1, 0.5),
    }
    thresholds["torque"] = (1.0, 200.0)
    for name, bounds in thresholds.items():
        if draws.chance(0.6):
            drawn.values[f"guard.{name}"] = draws.in_logarithms(*bounds)
            drawn.values[f"guard.{name}_delay"] = draws.one_of(0.0, draws.evenly(0.0, 0.5))
    for name in ("rise_y", "window_y"):
        if draws.chance(0.3):
            drawn.values[f"guard.{name}"] = low * draws.evenly(0.5, 1.0)


def air(drawn: Drawn) -> None:
    draws = drawn.draws
    drawn.values |= {"air.density": draws.evenly(0.9, 1.5), "air.drag": draws.evenly(0.8, 1.4)}
    if draws.chance(0.7):
        drawn.values |= {f"air.v{axis}": draws.evenly(-8.0, 8.0) for axis in "xyz"}
    if draws.chance(0.4):
        drawn.values |= {
            "air.cross_y": -draws.evenly(0.0, 0.4) * drawn.length,
            "air.cross_height": draws.evenly(2.0, 10.0),
        }
    if draws.chance(0.4):
        drawn.values |= {
            "air.buffet": draws.evenly(0.02, 0.5),
            "air.buffet_length": draws.evenly(2.0, 8.0),
        }


#: features of a scene, and the share of cases that have each
FEATURES: dict[Callable[[Drawn], None], float] = {
    damping: 0.3,
    unequal_coupling: 0.3,
    no_coupling: 0.15,
    stiffening: 0.15,
    installed_twist: 0.3,
    permanent_curvature: 0.2,
    wire_friction: 0.2,
    swivels: 0.5,
    attachments: 0.3,
    mesh: 0.35,
    accuracy: 0.3,
    solver: 0.3,
    fidelity: 0.35,
    inputs: 0.25,
    stations: 0.3,
    lining: 0.2,
    conveyances: 0.2,
    dividers: 0.2,
    sump: 0.15,
    contact: 0.3,
    self_contact: 0.2,
    guards: 0.3,
    air: 0.25,
}
DEFAULT = Rope()
