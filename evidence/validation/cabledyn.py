"""A U of rope, clamped at both ends and twisted: CableDyn's cubic elements against ours.

CableDyn 0.3.0 (SMI-Lab-Inha, Apache-2.0) has quasi-static torsion without coupling to tension.  Its rope hangs in water
of hardly any density.  ``cabledyn_motion`` has its frequencies and its winding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from evidence.stability.chain import StaticBoundary
from evidence.tables import Table, table
from rope_model.parameters import Layout, Rope
from rope_model.simulation.rope_kernels import RopeKernels
from rope_model.simulation.rope_system import ANGLE, POSITION, SLOPE, RopeSystem, parameter_vector
from rope_model.simulation.statics import find_equilibrium, hanging_guess

from .statics import Array, clamped, turned

ROPE, GRAVITY = Rope(Qb=0.0, Qc=0.0), Layout().gravity
SPACING, ELEMENTS = 0.5, 480  # m
TWISTS = (0, 45, 90, 135, 180)  # deg
STEP = 15  # deg that ours is turned at once

DECK = """\
--- LINE TYPES ---
Name Diam MassDenInAir EA BA EI GAs GJ Irt Irn Cd_n Cd_t Ca_n Ca_t
rope {d} {rho} {EA} 0.0 {EI} {GAs} {GJ} 1e-3 2e-3 0.0 0.0 0.0 0.0
--- POINTS ---
ID Type X Y Z
1 Coupled 0.0 0.0 {height}
2 Fixed {spacing} 0.0 0.0
--- LINES ---
ID NodeA NodeB Outputs
1 1 2 {files}
--- SECTIONS ---
LineID LineType Length NumSegs
1 rope {length} {elements}
--- END CONNECTIONS ---
{ends}
--- OPTIONS ---
{g} g
1e-6 rhoW
{options}
--- OUTPUTS ---
{outputs}
--- END ---
"""
#: ends that no torque reaches, and ends one of which is turned
PLAIN = """\
LineID End Stiffness EzX EzY EzZ
1 A Rigid 0.0 0.0 -1.0
1 B Rigid 0.0 0.0 1.0"""
TWISTED = """\
LineID End Stiffness EzX EzY EzZ TorsStiffness NxX NxY NxZ Pretwist
1 A Rigid 0.0 0.0 -1.0 Rigid 0.0 1.0 0.0 0.0
1 B Rigid 0.0 0.0 1.0 Rigid 0.0 1.0 0.0 {twist}"""
#: finite EI asks for a dynamic deck, which begins with the shape at rest
AT_REST = ("0.01 dtM", "0.01 TMax")


@dataclass(frozen=True)
class Deck:
    """What differs from deck to deck: the first end's ``height`` (m), the ends' connections, options and outputs.

    ``files`` asks for more of them, ``motion`` is that of the first end.
    """

    ends: str
    options: tuple[str, ...] = AT_REST
    outputs: tuple[str, ...] = ("FairTen1",)
    height: float = 0.0
    files: str = "-"
    motion: str = ""

    def run_in(self, folder: Path) -> Any:
        """By CableDyn's driver, which the package ``cabledyn`` carries."""
        import cabledyn

        numbers = {"d": ROPE.diameter, "rho": ROPE.mass_per_length, "EA": ROPE.Qa, "EI": ROPE.EI, "GJ": ROPE.Qd}
        layout = {"length": ROPE.length, "elements": ELEMENTS, "spacing": SPACING, "height": self.height, "g": GRAVITY}
        lines = {"options": "\n".join(self.options), "outputs": "\n".join(f'"{name}"' for name in self.outputs)}
        text = DECK.format(**numbers, **layout, **lines, GAs=0.4 * ROPE.Qa, ends=self.ends, files=self.files)
        deck = Path(folder, "u.dat")
        deck.write_text(text, encoding="utf-8")
        Path(folder, "motion.txt").write_text(self.motion, encoding="utf-8")
        return cabledyn.CableDynDriver().run(deck, Path(folder, "u"))


@dataclass(frozen=True)
class Shape:
    """Pull of an end and torque (N, N m), the lowest place (m), and how far the rope leaves its plane (m)."""

    pull: float
    torque: float
    lowest: float
    aside: float


def theirs(twist: float) -> Shape:
    """By CableDyn."""
    with TemporaryDirectory() as folder:
        run = Deck(TWISTED.format(twist=twist), outputs=("FairTen1", "Torq1N1")).run_in(Path(folder))
        history, profile = run.read_main(), run.read_static()
        return Shape(
            float(history.column("FairTen1")[0]),
            abs(float(history.column("Torq1N1")[0])),
            float(np.min(profile.column("Z"))),
            float(np.max(np.abs(profile.column("Y")))),
        )


def hung(height: float) -> Array:
    """A guess of our shape, one end at ``height`` (m)."""
    s = np.linspace(0.0, ROPE.length, ELEMENTS + 1)
    guess = hanging_guess(s, np.array([0.0, height, 0.0]), np.array([SPACING, 0.0, 0.0]))
    guess[[0, -1], SLOPE] = [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]
    return guess


def system_of(rope: Rope, guess: Array, boundary: StaticBoundary) -> RopeSystem:
    """``rope`` in equal elements."""
    lengths = np.full(ELEMENTS, rope.length / ELEMENTS)
    return RopeSystem(RopeKernels(ELEMENTS), lengths, parameter_vector(rope, GRAVITY), boundary, guess)


def ours() -> dict[int, Shape]:
    """By twist."""
    guess = hung(0.0)
    system = system_of(ROPE, guess, clamped(guess))
    at_rest, shapes = find_equilibrium(system, guess), {}
    for twist in range(0, max(TWISTS) + 1, STEP):
        at_rest = turned(system, at_rest.q, math.radians(STEP if twist else 0))
        q, reaction = at_rest.q, at_rest.reaction[0]
        if twist in TWISTS:
            pull = float(np.linalg.norm(reaction[POSITION]))
            lowest, aside = float(np.min(q[:, 1])), float(np.max(np.abs(q[:, 2])))
            shapes[twist] = Shape(pull, abs(float(reaction[ANGLE])), lowest, aside)
    return shapes


def measure() -> Table:
    """Both, by twist."""
    names = ("twist", "code", "pull", "torque", "lowest", "aside")
    found = []
    for twist, mine in ours().items():
        for code, x in (("ours", mine), ("CableDyn", theirs(twist))):
            found.append((twist, code, x.pull, x.torque, x.lowest, x.aside))
    return table(names, found)
