"""Linear models of hoist and ropes against the co-simulation: ``python -m evidence.linear``.

A small torque pulse is given to the co-simulation, at rest or in the midst of a trip at constant speed, and to the
linear model there. Ratios of Laplace transforms on Re s = SIGMA are compared up to 2 Hz, which is what shows within
some 1 / SIGMA. The response is half the difference of two runs with opposite pulses: the loop's height and yaw move by
the pulse's square, too.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from evidence.ropes import require, smooth_step
from evidence.tables import Array
from hoist_demo.cases.case import Case
from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.hoist_partner import DriveCommand, HoistPartner
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_scene
from hoist_demo.cosimulation.schemes.catalogue import find_scheme
from hoist_demo.cosimulation.schemes.interface import (
    ROPE_FORCES,
    CoupledSystem,
    SchemeState,
    Stopwatch,
)
from hoist_demo.design.linear_model import LinearModel
from hoist_demo.design.linearise import linearise
from hoist_demo.design.reduced_model import ALPHA
from hoist_demo.design.reduction import reduced
from hoist_demo.drive.coordinates import INPUT_NAMES
from hoist_demo.drive.outputs import OUTPUT_INDEX
from hoist_demo.drive.plant import HoistPlant
from rope_model import EndMotion

Complex = NDArray[np.complex128]

TORQUE = ("torque_command",)
DRIVE = ("rate", "pull_left", "pull_right", "tension_left")
SEEN = (*DRIVE, "left.fy", "right.fy", "loop.x", "loop.y", "loop.yaw")
SIGMA = 0.6  #: 1/s
GRID: Complex = np.asarray(SIGMA + 2j * np.pi * np.linspace(0.05, 2.0, 60), dtype=np.complex128)
LINE: Complex = np.asarray(
    ALPHA + 1j * GRID.imag, dtype=np.complex128
)  #: on which schedules are compared
STATES = (8, 12, 17, 24)
HEIGHTS = (0.1, 0.3, 0.5, 0.7, 0.9)
HOISTS = ("rope-120", "rope-240", "kiruna-355", "monopol-1000")
PULSE = 0.005  #: Of the torque limit.
_BEFORE = 1.2  #: Time to the pulse's middle [s].
_LASTS = 9.0  #: Length of a record times SIGMA.
_SETTLES = 3.0  #: Time at speed before the pulse [s].
_HARD = 1.0  #: m/s^2, mean acceleration to a speed.


def smooth(case: Case) -> Case:
    """Return the case without what has no derivative."""
    guides = None if case.hoist.guides is None else replace(case.hoist.guides, coulomb=0.0)
    return replace(
        case, hoist=replace(case.hoist, loss_coulomb=0.0, guides=guides, brake=None, play=None)
    )


def wavelet(t: float) -> float:
    """Ricker's, at 1 Hz: it leaves the hoist where and as fast as it was."""
    z = (np.pi * (t - _BEFORE)) ** 2
    return float((1 - 2 * z) * np.exp(-z))


@dataclass
class Shaken:
    """A co-simulation in open loop but for a speed loop that is recorded."""

    case: Case
    start: float  # m, height of the left conveyance
    H: float  # s, communication step

    def __post_init__(self) -> None:
        scene = rope_scene(self.case.rope)
        solver = replace(scene.solver, step_max=min(self.H / 2, scene.solver.step_max))
        self.rope = InProcessRope(
            scene.with_(solver=solver, model=replace(scene.model, fidelity="torsional"))
        )
        plant = HoistPlant(self.case.hoist)
        travel = self.case.hoist.shaft_travel
        heights = self.start, travel - self.start
        require(self.rope.initialize(0.0, *(EndMotion(y=y) for y in heights)))
        forces = self.rope.reader(ROPE_FORCES)()[:2]
        state = plant.equilibrium(*heights, *forces.tolist())
        u = np.zeros(len(INPUT_NAMES))
        u[0] = state.x[0]
        u[1:3] = forces
        self.held = float(u[0])
        self.drive = HoistPartner(plant, state, u, Stopwatch())
        self.pair = CoupledSystem(self.drive, self.rope)
        self.scheme = find_scheme("iterative-secant")
        self.read = self.rope.reader(SEEN[len(DRIVE) :])
        self.k = 0
        self.memory: SchemeState = self.pair.start(0.0)

    def step(self, torque: float) -> list[float]:
        """Advance by H under a torque command; return SEEN before."""
        seen = [*(float(self.drive.outputs[OUTPUT_INDEX[name]]) for name in DRIVE), *self.read()]
        self.drive.command(DriveCommand(torque, brake=0.0), np.zeros(6))
        advance = self.scheme.advance(self.pair, self.memory, self.k * self.H, self.H)
        if not advance.status.valid:
            raise RuntimeError(advance.status.message)
        self.memory = advance.scheme_state
        self.k += 1
        return seen

    def followed(self, speed: float, rise: float) -> float:
        """Torque that takes the hoist to the speed [m/s] within so many seconds and keeps it there."""
        hoist = self.case.hoist
        _, wanted, push, _ = smooth_step(self.k * self.H / rise)
        error = speed * wanted - hoist.sheave_radius * float(
            self.drive.outputs[OUTPUT_INDEX["rate"]]
        )
        return self.held + hoist.sheave_radius * hoist.moving_mass * (speed / rise * push + error)


def shaken(case: Case, at: float, s: Complex, H: float, speed: float = 0.0) -> Complex:
    """Transfer functions (s, SEEN) of the co-simulation from the torque's command."""
    rise = abs(speed) / _HARD
    travel = case.hoist.shaft_travel
    steps = round(_LASTS / s[0].real / H)
    before = speed * (rise / 2 + _SETTLES + _BEFORE) if speed else 0.0
    run = Shaken(case, at * travel - before, H)
    while speed and run.k * H < rise + _SETTLES:
        run.step(run.followed(speed, rise))
    begin = run.k
    saved = (run.drive.save(), run.rope.save(), run.memory)
    torques = np.full(steps, run.held)
    for k in range(steps if speed else 0):
        torques[k] = run.followed(speed, rise)
        run.step(float(torques[k]))
    given = (
        PULSE * case.hoist.torque_limit * np.array([wavelet((k + 0.5) * H) for k in range(steps)])
    )
    both = []
    for torque in (torques + given, torques - given):
        run.drive.restore(saved[0])
        run.rope.restore(saved[1])
        run.memory = saved[2]
        run.k = begin
        both.append([run.step(float(x)) for x in torque])
    moved = (np.array(both[0]) - both[1]) / 2
    decay = np.exp(-np.outer(s, np.arange(steps) * H))
    # the command is held over a step, outputs go straight from one to the next; the first is 0
    return np.asarray((decay @ moved) * H / ((decay @ given) * (1 - np.exp(-s * H)) / s)[:, None])


def errors(found: Complex, exact: Complex) -> tuple[Array, Array]:
    """Largest errors (outputs,) over the grid: dB and degrees."""
    ratio = found / exact
    return np.abs(20 * np.log10(np.abs(ratio))).max(axis=0), np.abs(np.angle(ratio, deg=True)).max(
        axis=0
    )


def dense(count: int) -> Array:
    """Heights over the travel, dense at both ends, where head ropes are short."""
    return np.asarray((1 - np.cos(np.pi * np.arange(count) / (count - 1))) / 2)


def between(models: Sequence[LinearModel], states: int) -> tuple[float, float]:
    """Largest errors, dB and degrees, of a schedule of every other model against those between."""
    plant = reduced(models[::2], states).scheduled()
    size = plant.size1_in(1)
    worst = np.zeros(2)
    for model in models[1::2]:
        columns = [plant(model.at, x, 0.0) for x in np.eye(size)]
        A, C = (np.hstack([np.array(column[k]) for column in columns]) for k in (0, 1))
        B, D = (np.array(part) for part in plant(model.at, np.zeros(size), 1.0))
        found = np.array([C @ np.linalg.solve(z * np.eye(size) - A, B) + D for z in LINE])
        worst = np.maximum(worst, [x.max() for x in errors(found, model.response(LINE))])
    return float(worst[0]), float(worst[1])


def print_between(hoists: Sequence[str]) -> None:
    """Print the errors of schedules of 17 dense heights between these."""
    for name in hoists:
        models = [
            m.selected(TORQUE, DRIVE[:3]) for m in linearise(smooth(find_case(name)), dense(33))
        ]
        for states in STATES:
            try:
                told = "{:.2f} dB, {:.1f} degrees".format(*between(models, states))
            except ValueError as error:
                told = str(error)
            print(f"{name:>14}, {states} states: {told}", flush=True)


def main() -> None:
    """Print the table of a few hoists."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("hoists", nargs="*", default=HOISTS)
    parser.add_argument("--at", type=float, nargs="+", default=HEIGHTS)
    parser.add_argument("--speed", type=float, default=0.0)
    parser.add_argument("--sigma", type=float, default=SIGMA)
    parser.add_argument(
        "--between", action="store_true", help="schedules between their heights instead"
    )
    options = parser.parse_args()
    if options.between:
        print_between(options.hoists)
        return
    grid: Complex = np.asarray(options.sigma + 1j * GRID.imag, dtype=np.complex128)
    print(
        f"{'hoist':>14}{'at':>5}{'s':>6}"
        + "".join(f"{name:>16}" for name in (*SEEN, "small, drive"))
        + "  dB/degrees"
    )
    for name in options.hoists:
        case = smooth(find_case(name))
        for at in options.at:
            begin = perf_counter()
            (model,) = linearise(case, [at], speed=options.speed)
            took = perf_counter() - begin
            truth = shaken(case, at, grid, 0.005, options.speed)
            exact = model.selected(TORQUE, SEEN).response(grid)[:, :, 0]
            small = reduced([model.selected(TORQUE, DRIVE[:3])], 17).response(0, grid)[:, :, 0]
            decibels, degrees = errors(small, truth[:, :3])
            found = [*zip(*errors(exact, truth), strict=True), (decibels.max(), degrees.max())]
            print(
                f"{name:>14}{at:5.2f}{took:6.2f}"
                + "".join(f"{f'{a:.3f}/{b:.2f}':>16}" for a, b in found),
                flush=True,
            )


if __name__ == "__main__":
    main()
