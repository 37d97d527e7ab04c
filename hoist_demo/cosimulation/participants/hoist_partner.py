"""The hoist as the partner of a coupling that gives motions.

The coordinates of the exchange are the heights of the left and the right end; the rope's response
to them are its vertical forces. Everything else of the ends' motion follows the drive.
"""

from collections.abc import Callable, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from hoist_demo.cosimulation.schemes.interface import (
    SUCCESS,
    DriveLoad,
    InterfaceMotion,
    Stopwatch,
    Vector,
)
from hoist_demo.drive.coordinates import FORCES, INPUT_NAMES, WORK_NAMES
from hoist_demo.drive.outputs import OUTPUT_INDEX
from hoist_demo.drive.plant import HoistPlant, PlantState, PlantStep
from rope_model import SIDES, EndMotion, Status

_POSITION, _SPEED, _ACCELERATION = (
    slice(OUTPUT_INDEX[f"{name}_left"], OUTPUT_INDEX[f"{name}_right"] + 1) for name in "yva"
)
#: Places of the forces in a path of the drive's input.
_START, _LINEAR, _QUADRATIC = (
    slice(k + FORCES[0], k + FORCES[1] + 1) for k in np.arange(3) * len(INPUT_NAMES)
)
_TORQUE = INPUT_NAMES.index("torque_command")
_BRAKE = INPUT_NAMES.index("brake")
_SIDES = slice(INPUT_NAMES.index("fx_left"), len(INPUT_NAMES))
_LEFT_WORK, _RIGHT_WORK = (WORK_NAMES.index(end) for end in SIDES)
_LATERAL = ("x", "z", "vx", "vz", "ax", "az", "yaw", "yaw_rate")
#: Places in OUTPUTS of the lateral motion of each end, (2, 8).
_LATERAL_OUTPUTS = np.reshape(
    [OUTPUT_INDEX[f"{name}_{end}"] for end, name in product(SIDES, _LATERAL)],
    (len(SIDES), len(_LATERAL)),
)
_AT_REST = (0.0,) * len(_LATERAL)


class DriveCommand(NamedTuple):
    """Command of the controller to motor and brake."""

    torque: float  # N m
    brake: float  # -, fraction of the brake's full torque


#: The controller's k-th command within a step, by k, time [s] and OUTPUTS of the hoist.
NextCommand = Callable[[int, float, Vector], DriveCommand]


class HoistPartner:
    """Hoist as a coupling's drive; ``command`` is to be called between steps."""

    def __init__(
        self,
        plant: HoistPlant,
        state: PlantState,
        initial_input: Vector,
        clock: Stopwatch,
        per_step: int = 1,
    ) -> None:
        """``initial_input`` acts at the start, in the order of INPUT_NAMES.

        ``per_step`` is the number of the controller's samples in a step.
        """
        self.plant = plant
        self.state = state
        self.input = initial_input  # that acts now, forces included
        self._per_step = per_step
        self._next_command: NextCommand | None = None  # None: the first command is held
        self._first = DriveCommand(initial_input.item(_TORQUE), initial_input.item(_BRAKE))
        #: Polynomial of the input over the next step.
        self._path = np.concatenate([initial_input, np.zeros(2 * initial_input.size)])
        self._clock = clock
        self._outputs: Vector | None = None  # OUTPUTS under the input, None where not computed
        self._last_load: DriveLoad | None = (
            None  # load of the last step, None where another acts now
        )
        self._end_motion: InterfaceMotion | None = None  # motion at the end of the last step

    def command(self, command: DriveCommand, side_forces: Vector) -> None:
        """Set what acts besides the vertical forces from now on."""
        self._first = command
        self._set_command(command)
        self._path[_SIDES] = side_forces
        self._last_load = None

    def sample_within_steps(self, next_command: NextCommand) -> None:
        """Take the controller's later commands of each step from this function."""
        self._next_command = next_command

    def step(self, t: float, h: float, load: DriveLoad) -> Status:
        """Advance the hoist by one step under the load; a constant load is held to the bit."""
        with self._clock:
            reached = self._advance(t, h, load)
            if not reached.valid:
                return Status(False, f"t = {t:.6g} s: {reached.message}")
            self.state = reached.state
            self.input = reached.applied_input
            self._outputs = reached.outputs
            self._last_load = load
            self._end_motion = _motion(reached.outputs)
        return SUCCESS

    def _advance(self, t: float, h: float, load: DriveLoad) -> PlantStep:
        """Advance the plant under the step's commands; a repeated step begins with the first one."""
        number = self._per_step
        path = self._path_under(load)
        added_mass = load.added_mass
        self._set_command(self._first)
        reached = self.plant.advance(self.state, h, path, added_mass, begin=0.0, end=1.0 / number)
        for k in range(1, number):
            if not reached.valid or self._next_command is None:
                break
            self._set_command(self._next_command(k, t + k * h / number, reached.outputs))
            reached = self.plant.advance(
                reached.state, h, path, added_mass, begin=k / number, end=(k + 1) / number
            )
        return reached

    def _set_command(self, command: DriveCommand) -> None:
        """Put a command into the path of the input."""
        self._path[_TORQUE] = command.torque
        self._path[_BRAKE] = command.brake

    @property
    def outputs(self) -> Vector:
        """Present OUTPUTS of the drive."""
        if self._outputs is None:
            path = np.concatenate([self.input, np.zeros(2 * self.input.size)])
            _, self._outputs = self.plant.loads_and_outputs(
                self.state, path, added_mass=np.zeros(2), s=0.0
            )
        return self._outputs

    def position(self) -> Vector:
        return self.outputs[_POSITION]

    def motion(self, load: DriveLoad, s: float) -> InterfaceMotion:
        if self._end_motion is not None and self._last_load is load and s == 1.0:
            return self._end_motion
        with self._clock:
            _, outputs = self.plant.loads_and_outputs(
                self.state, self._path_under(load), load.added_mass, s
            )
        return _motion(outputs)

    def accelerance(self) -> Vector:
        return self.plant.accelerance(self.state)

    def work(self) -> float:
        """Work of one balance rope's forces on the hoist [J]."""
        work_totals = self.state.work_totals
        both = work_totals.item(_LEFT_WORK) + work_totals.item(_RIGHT_WORK)
        return both / self.plant.hoist.tail_rope_number

    def ends(self, motion: InterfaceMotion) -> tuple[EndMotion, EndMotion]:
        """Motion of the rope's ends; conveyances without play rest to the sides."""
        y_left, y_right = motion.position.tolist()
        v_left, v_right = motion.speed.tolist()
        a_left, a_right = motion.acceleration.tolist()
        left = right = _AT_REST
        if self.plant.hoist.play is not None:
            left, right = self.outputs[_LATERAL_OUTPUTS].tolist()
        return _end(left, y_left, v_left, a_left), _end(right, y_right, v_right, a_right)

    def set_state(self, state: PlantState, applied_input: Vector, outputs: Vector) -> None:
        """Go on where C has brought the drive, under an input and with OUTPUTS."""
        self.state = state
        self.input = applied_input
        self._outputs = outputs
        self._last_load = None

    def save(self) -> tuple[PlantState, Vector]:
        return self.state, self.input

    def restore(self, snapshot: tuple[PlantState, Vector]) -> None:
        self.state, self.input = snapshot
        self._outputs = None
        self._last_load = None

    def _path_under(self, load: DriveLoad) -> Vector:
        """Return the polynomial of the input over a step under this load."""
        self._path[_START] = load.start
        self._path[_LINEAR] = load.linear
        self._path[_QUADRATIC] = load.quadratic
        return self._path


def _end(lateral: Sequence[float], y: float, vy: float, ay: float) -> EndMotion:
    """Return the motion of an end, from its values of _LATERAL and its vertical motion."""
    x, z, vx, vz, ax, az, yaw, yaw_rate = lateral
    return EndMotion(x, y, z, vx, vy, vz, ax, ay, az, yaw, yaw_rate)


def _motion(outputs: Vector) -> InterfaceMotion:
    return InterfaceMotion(outputs[_POSITION], outputs[_SPEED], outputs[_ACCELERATION])
