"""A conveyance of any mass on one end of a 20 m rope: which exchange is stable at which step.

The conveyance hangs on a spring of 1 Hz and is pushed by a force of half a metre per second squared; the rope's other
end is held. Beyond 20 m/s^2, or when the rope refuses the motion, a run is unstable. What is predicted comes from the
same functions that warn the user of the hoist.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from benchmarks.kinematic import fixed_steps
from hoist_demo.cosimulation.schemes.catalogue import SCHEMES
from hoist_demo.cosimulation.schemes.interface import Motion, Pair, Scheme, Vector
from hoist_demo.cosimulation.schemes.stability import growth, measure_response
from rope_model.parameters import Mesh, Rope, Scene
from rope_model.simulation.paths import EndMotion
from rope_model.simulation.simulator import RopeSimulator
from rope_model.simulation.state import RopeState

from .oscillator import Data, Drive

Array = NDArray[np.float64]

LENGTH, FREQUENCY, PUSH, RUNAWAY = 20.0, 1.0, 0.5, 20.0  # m, Hz, m/s^2, m/s^2
LEG = 0.5 * LENGTH * Rope.mass_per_length  # kg
IMPEDANCE = math.sqrt(Rope.Qa * Rope.mass_per_length)  # N s/m
MASSES = LEG * 2.0 ** np.arange(-3, 3)  # kg
STEPS = np.array([0.005, 0.01, 0.02, 0.04])  # s
NAMES = (
    *(f"gauss-seidel-{order}" for order in range(3)),
    "impulse-preserving",
    "semi-implicit-0",
    "semi-implicit-1",
    "iterative-secant",
    "implicit-impulse",
)


class OneEnd:
    """The rope's left end as a coupling's rope, forces counted from those at rest."""

    def __init__(self) -> None:
        solver = fixed_steps(0.01)
        self.rope = RopeSimulator(Scene(rope=Rope(length=LENGTH), mesh=Mesh(kind="eem", elements=20), solver=solver))
        status = self.rope.initialize(0.0, EndMotion(), EndMotion())
        if not status.valid:
            raise RuntimeError(status.message)
        self.at_rest = 0.0
        self.at_rest = float(self.forces()[0][0])

    def step(self, t: float, h: float, motion: Motion) -> str:
        y, v, a = (float(x[0]) for x in (motion.place, motion.speed, motion.acceleration))
        status = self.rope.advance_to(t + h, EndMotion(y=y, vy=v, ay=a), EndMotion())
        return "" if status.valid else status.message

    def forces(self) -> tuple[Vector, Vector]:
        now, mean = -float(self.rope.state.motion.reaction[0, 1]), self.rope.state.force_mean[0]
        return np.array([now - self.at_rest]), np.array([mean - self.at_rest])

    def added_mass(self) -> Vector:
        return np.array([self.rope.added_mass()[0]])

    def save(self) -> RopeState:
        return self.rope.state

    def restore(self, snapshot: RopeState) -> None:
        self.rope.restore(snapshot)

    def free(self, snapshot: RopeState) -> None:
        """Nothing is held."""


@dataclass(frozen=True)
class Point:
    """A scheme at a mass and a step."""

    scheme: str
    mass: float  # kg
    H: float  # s
    stable: bool
    growth: float  # predicted, per step
    added_mass: float  # kg


def runs_stably(end: OneEnd, scheme: Scheme, mass: float, H: float) -> bool:
    """Over 0.3 s and 40 steps at least; the rope is left as it was."""
    data = Data(m=mass, k=mass * (2 * math.pi * FREQUENCY) ** 2, f=mass * PUSH)
    pair, start = Pair(Drive(data, np.zeros(2)), end), end.save()
    memory = pair.start(0.0)
    try:
        for k in range(max(round(0.3 / H), 40)):
            advance = scheme.advance(pair, memory, k * H, H)
            memory = advance.memory
            if advance.cause or not abs(float(memory.last.acceleration[0])) < RUNAWAY:
                return False
        return True
    finally:
        end.restore(start)


def points() -> list[Point]:
    """The whole map."""
    end, found = OneEnd(), []
    nowhere = Motion(np.zeros(1), np.zeros(1), np.zeros(1))
    for H in tqdm(STEPS, desc="stability", unit="step", leave=False):
        answer, cause = measure_response(Pair(Drive(Data(), np.zeros(2)), end), 0.0, float(H), nowhere)
        if cause:
            raise RuntimeError(cause)
        for name in NAMES:
            for mass in MASSES:
                stable = runs_stably(end, SCHEMES[name], float(mass), float(H))
                expected = growth(SCHEMES[name], answer[:, 0], float(mass))
                found.append(Point(name, float(mass), float(H), stable, expected, float(answer[0, 0])))
    return found
