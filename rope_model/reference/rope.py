"""ReferenceRope: the published system as a BalanceRope.

Between two instants of the host the ends follow quintics, and the rope takes its own steps.  A
start or an advance that fails leaves the state as it was and returns the cause.
"""

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rope_model.boundary.end_paths import RESTS_BELOW, EndMotion
from rope_model.boundary.point_forces import PointForces
from rope_model.fidelity.choice import Fidelity
from rope_model.interface import BalanceRope, Snapshot, Status
from rope_model.messages import messages
from rope_model.method.stepping import MAX_START_TIME, MAX_STEPS, MIN_INTERVAL
from rope_model.parameters import Scene
from rope_model.physics.node import ANGLE, SIDES
from rope_model.reference.ends import onwards, refusal, resting, too_rough
from rope_model.reference.equations import HEIGHT
from rope_model.reference.hanging import hang
from rope_model.reference.mesh import mesh_of, require_mesh_of
from rope_model.reference.newton import Cause, Failure
from rope_model.reference.outputs import COMPUTED_NAMES, values_function
from rope_model.reference.result_warnings import warnings_of
from rope_model.reference.scope import require_published
from rope_model.reference.state import State, require_finite
from rope_model.reference.statics import StaticsError
from rope_model.reference.stepping import step_towards
from rope_model.saved_state import require_form, require_same_rope, state_behind_label
from rope_model.signals.signal_table import checked_names
from rope_model.state import RopeState


class ReferenceRope(BalanceRope):
    """Published system in plain Python; ``state`` is a reference.state.State.

    Raises
    ------
    ValueError
        If the scene holds more than the published system, or the mesh does not fit the rope.
    """

    def __init__(self, scene: Scene) -> None:
        require_published(scene)
        self._elements = mesh_of(scene, 0.5 * scene.rope.length).lengths.size
        self._scene = scene
        self._state: State | None = None

    @property
    def scene(self) -> Scene:
        return self._scene

    @property
    def form(self) -> str:
        return "reference"

    @property
    def elements(self) -> int:
        """Number of elements while no end of the rope cuts off the pattern."""
        if self._state is None:
            return self._elements
        return self._state.mesh.lengths.size

    @property
    def time(self) -> float:
        return self.state.motion.t

    @property
    def fidelity(self) -> Fidelity:
        return "torsional"

    @property
    def fidelity_reason(self) -> str:
        return "the reference rope knows the complete model only"

    @property
    def state(self) -> State:  # type: ignore[override]  # the published system alone
        if self._state is None:
            raise RuntimeError(messages.no_state())
        return self._state

    def initialize(self, t: float, left: EndMotion, right: EndMotion) -> Status:
        if not abs(t) <= MAX_START_TIME:
            return Status(False, messages.start_time_out_of_range(t, MAX_START_TIME))
        for side, motion in zip(SIDES, (left, right), strict=True):
            message = refusal(motion, side)
            if message is not None:
                return Status(False, message)
            speed = max(map(abs, (*motion.velocity, motion.yaw_rate)))
            if speed > RESTS_BELOW:
                return Status(False, messages.moves_at_start(side))
        try:
            self._state = hang(self._scene, t, (resting(t, left), resting(t, right)))
        except (StaticsError, ValueError) as error:
            return Status(False, str(error))
        return Status(True)

    def advance_to(
        self, t: float, left: EndMotion, right: EndMotion, given_at: float | None = None
    ) -> Status:
        before = self.state
        if abs(t - before.motion.t) < MIN_INTERVAL:
            return Status(True)
        if given_at is None:
            given_at = t
        message = self._time_refused(t, given_at)
        if message is not None:
            return Status(False, message)
        paths = []
        for side, path, motion in zip(SIDES, before.paths, (left, right), strict=True):
            message = refusal(motion, side)
            if message is not None:
                return Status(False, message)
            following_path = onwards(path, t, motion, age=t - given_at)
            message = too_rough(following_path, side, self._scene.inputs.acceleration_max)
            if message is not None:
                return Status(False, message)
            paths.append(following_path)
        after = self._advanced(replace(before, paths=(paths[0], paths[1]), events=()), t)
        if isinstance(after, Failure):
            return Status(False, failure_message(after))
        self._state = after
        return Status(True)

    def _advanced(self, state: State, t: float) -> State | Failure:
        """Return the state after the steps to ``t`` (s), with the mean forces on the way."""
        start = state.motion.t
        impulse = np.zeros(2)
        for _ in range(MAX_STEPS):
            after = step_towards(self._scene, state, t)
            if isinstance(after, Failure):
                return after
            h = after.motion.t - state.motion.t
            impulse -= 0.5 * h * (_pulls(state) + _pulls(after))
            state = after
            if state.motion.t >= t:
                left, right = (impulse / (t - start)).tolist()
                return replace(state, force_mean=(left, right))
        what = f"the advance from {start:.6g} s to {t:.6g} s"
        return Failure(Cause.STEPS, state.motion.t, what)

    def _time_refused(self, t: float, given_at: float) -> str | None:
        """Return None if the rope can advance to ``t`` with motions of ``given_at`` (s); else the message."""
        start = self.state.motion.t
        if not (math.isfinite(t) and t > start):
            return messages.time_goes_back(start, t)
        step_max = self._scene.solver.step_max
        if t - start > MAX_STEPS * step_max:
            return messages.too_far_at_once(start, t, MAX_STEPS, step_max, MAX_STEPS * step_max)
        earliest = start - self._scene.inputs.hold_max
        if not earliest <= given_at <= t + MIN_INTERVAL:
            return messages.motions_of_another_time(given_at, earliest, t)
        return None

    def signals(self, names: Iterable[str] | None = None) -> dict[str, float]:
        wanted = COMPUTED_NAMES if names is None else checked_names(names)
        values: dict[str, float] = {}
        for name in wanted:
            group = values_function(name)
            if group is None:
                raise ValueError(
                    messages.engine_alone(f"the reference rope does not compute {name}")
                )
            if name not in values:
                values |= group(self._scene, self.state)
        return {name: values[name] for name in wanted}

    def apply(self, forces: PointForces) -> None:
        if forces.s.size:
            raise ValueError(_no_point_forces())

    def rows(self) -> NDArray[np.float64]:
        m = self.state.motion
        return np.column_stack((self.state.mesh.nodes_s, m.q[:, :ANGLE], m.v[:, :ANGLE]))

    def displacement(self, forces: PointForces) -> NDArray[np.float64]:
        raise ValueError(_no_point_forces())

    def warnings(self) -> dict[str, str]:
        return warnings_of(self._scene, self.state)

    def snapshot(self) -> Snapshot:
        return Snapshot(self.form, self._scene, self.state, _no_engine_state, State.to_bytes)

    def restore(self, data: bytes | RopeState | State | Snapshot) -> None:
        if isinstance(data, bytes):
            self._state = self._fitting(
                State.from_bytes(state_behind_label(data, self.form, self._scene))
            )
            return
        if isinstance(data, Snapshot):
            require_form(data.form, self.form)
            require_same_rope(data.scene, self._scene)
            self._state = data.kept
            return
        if not isinstance(data, State):
            raise ValueError(
                f"a {type(data).__name__} must be a State of rope_model.reference.state, bytes of "
                "save() or a Snapshot: give one of the reference rope"
            )
        self._state = self._fitting(data)

    def _fitting(self, state: State) -> State:
        """Return the state; ValueError unless it is one of this rope's mesh, in finite numbers."""
        require_mesh_of(self._scene, state.mesh)
        require_finite(state)
        return state

    def _retune(self, scene: Scene) -> None:
        require_published(scene)
        self._scene = scene


def failure_message(failure: Failure) -> str:
    """Return what fails, cause and cure."""
    cause = failure.cause.value
    return (
        f"at t = {failure.t:.6g} s {failure.what} fails: {cause}; "
        "check the motions of the ends, refine the mesh, or lower solver.step_min"
    )


def _pulls(state: State) -> NDArray[np.float64]:
    """Return the vertical reactions at both ends (2,), N."""
    return state.motion.reaction[[0, -1], HEIGHT]


def _no_point_forces() -> str:
    return messages.engine_alone("the reference rope takes no point forces")


def _no_engine_state(kept: object) -> RopeState:
    raise ValueError(messages.engine_alone("a state of the reference rope is none of the engine"))
