"""The hoist as the partner of a coupling that gives motions.

The coordinates of the exchange are the heights of the left and the right end; the rope's response to them are its
vertical forces. Everything else of the ends' motion follows the drive.
"""

from collections.abc import Callable, Sequence

import numpy as np

from hoist_demo.cosimulation.schemes.interface import ENDS, InterfaceMotion, Load, Stopwatch, Vector
from hoist_demo.drive.equations import FORCES, INPUT_NAMES, WORK_NAMES
from hoist_demo.drive.outputs import OUTPUT_INDEX
from hoist_demo.drive.plant import HoistPlant, PlantState, PlantStep
from rope_model import EndMotion

_POSITION, _SPEED, _ACCELERATION = (
    slice(OUTPUT_INDEX[f"{n}_left"], OUTPUT_INDEX[f"{n}_right"] + 1) for n in "yva"
)
#: Places of the forces in a path of the drive's input.
_START, _LINEAR, _QUADRATIC = (
    slice(k + FORCES[0], k + FORCES[1] + 1) for k in np.arange(3) * len(INPUT_NAMES)
)
#: The controller's k-th command within a step, torque [N m] and brake: of k, time [s] and what the hoist shows then.
NextCommand = Callable[[int, float, Vector], tuple[float, float]]


class HoistPartner:
    """Hoist as a coupling's drive; `command` is to be given between steps."""

    def __init__(
        self, plant: HoistPlant, state: PlantState, initial_input: Vector, clock: Stopwatch
    ) -> None:
        """`initial_input` is what acts at the start, in the order of INPUT_NAMES."""
        self.plant, self.state = plant, state
        self.per_step = 1  # samples of the controller in a step
        self.next_command: NextCommand | None = None  # None with one sample in a step
        self._first = (
            initial_input.item(_TORQUE),
            initial_input.item(_BRAKE),
        )  # command of a step, torque and brake
        self.input = initial_input  # that acts now, forces included
        self._path = np.concatenate(
            [initial_input, np.zeros(2 * initial_input.size)]
        )  # input over the next step
        self._clock = clock
        self._outputs: Vector | None = None  # OUTPUTS under the input
        self._done: tuple[Load, InterfaceMotion] | None = (
            None  # load of the last step, and the motion at its end
        )

    def command(self, torque: float, brake: float, sides: Vector) -> None:
        """Set what acts besides the vertical forces from now on: the command and the rope's side forces."""
        self._path[_TORQUE], self._path[_BRAKE], self._path[_SIDES] = torque, brake, sides
        self._first = torque, brake
        self._done = None

    def step(self, t: float, h: float, load: Load) -> str:
        """Advance the hoist by one step under the load; a constant load is held to the bit."""
        with self._clock:
            moved = self._moved(t, h, load)
            if not moved.valid:
                return f"t = {t:.6g} s: {moved.message}"
            self.state, self.input, self._outputs = moved.state, moved.applied_input, moved.outputs
            self._done = load, _motion(moved.outputs)
        return ""

    def _moved(self, t: float, h: float, load: Load) -> PlantStep:
        """Advance the plant under the step's commands, from the first again where the step is repeated."""
        number, path, added = self.per_step, self._under(load), load.added_mass
        path[_TORQUE], path[_BRAKE] = self._first
        moved = self.plant.advance(self.state, h, path, added, 0.0, 1.0 / number)
        for k in range(1, number):
            if not moved.valid or self.next_command is None:
                break
            path[_TORQUE], path[_BRAKE] = self.next_command(k, t + k * h / number, moved.outputs)
            moved = self.plant.advance(moved.state, h, path, added, k / number, (k + 1) / number)
        return moved

    @property
    def outputs(self) -> Vector:
        """Present OUTPUTS of the drive."""
        if self._outputs is None:
            path = np.concatenate([self.input, np.zeros(2 * self.input.size)])
            _, self._outputs = self.plant.loads_and_outputs(self.state, path, np.zeros(2), 0.0)
        return self._outputs

    def position(self) -> Vector:
        return self.outputs[_POSITION]

    def motion(self, load: Load, s: float) -> InterfaceMotion:
        if self._done is not None and self._done[0] is load and s == 1.0:
            return self._done[1]
        with self._clock:
            _, outputs = self.plant.loads_and_outputs(
                self.state, self._under(load), load.added_mass, s
            )
        return _motion(outputs)

    def accelerance(self) -> Vector:
        return self.plant.accelerance(self.state)

    def work(self) -> float:
        """Work of one balance rope's forces on the hoist [J]."""
        work_totals = self.state.work_totals
        return (
            work_totals.item(_LEFT_WORK) + work_totals.item(_RIGHT_WORK)
        ) / self.plant.hoist.tail_rope_number

    def ends(self, motion: InterfaceMotion) -> tuple[EndMotion, EndMotion]:
        """Motion of the rope's ends; conveyances without play rest to the sides."""
        (y_left, y_right), (v_left, v_right) = motion.position.tolist(), motion.speed.tolist()
        a_left, a_right = motion.acceleration.tolist()
        left, right = (
            self.outputs[_ASIDE].tolist() if self.plant.hoist.play is not None else _AT_REST
        )
        return _end(left, y_left, v_left, a_left), _end(right, y_right, v_right, a_right)

    def arrive(self, state: PlantState, applied_input: Vector, outputs: Vector) -> None:
        """Go on where C has brought the drive, under an input and with OUTPUTS."""
        self.state, self.input, self._outputs, self._done = state, applied_input, outputs, None

    def save(self) -> tuple[PlantState, Vector]:
        return self.state, self.input

    def restore(self, snapshot: tuple[PlantState, Vector]) -> None:
        self.state, self.input = snapshot
        self._outputs = self._done = None

    def _under(self, load: Load) -> Vector:
        self._path[_START], self._path[_LINEAR], self._path[_QUADRATIC] = (
            load.start,
            load.linear,
            load.quadratic,
        )
        return self._path


def _end(aside: Sequence[float], y: float, vy: float, ay: float) -> EndMotion:
    x, z, vx, vz, ax, az, yaw, yaw_rate = aside
    return EndMotion(x, y, z, vx, vy, vz, ax, ay, az, yaw, yaw_rate)


def _motion(outputs: Vector) -> InterfaceMotion:
    return InterfaceMotion(outputs[_POSITION], outputs[_SPEED], outputs[_ACCELERATION])


_ASIDE = np.array(
    [
        [
            OUTPUT_INDEX[f"{name}_{end}"]
            for name in ("x", "z", "vx", "vz", "ax", "az", "yaw", "yaw_rate")
        ]
        for end in ENDS
    ]
)
_AT_REST = ((0.0,) * 8,) * 2
_LEFT_WORK, _RIGHT_WORK = (WORK_NAMES.index(end) for end in ENDS)
_TORQUE, _BRAKE, _SIDES = (
    INPUT_NAMES.index("torque_command"),
    INPUT_NAMES.index("brake"),
    slice(4, 10),
)
