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
from rope_model.method.stepping import MIN_INTERVAL
from rope_model.parameters import Scene
from rope_model.physics.node import ANGLE, SIDES
from rope_model.reference.ends import onwards, peak_acceleration, refusal, resting
from rope_model.reference.equations import HEIGHT
from rope_model.reference.hanging import hang
from rope_model.reference.mesh import mesh_of
from rope_model.reference.newton import Cause, Failure
from rope_model.reference.outputs import NAMES, group_of
from rope_model.reference.result_warnings import warnings_of
from rope_model.reference.scope import require_published
from rope_model.reference.state import State
from rope_model.reference.statics import StaticsError
from rope_model.reference.stepping import step_towards
from rope_model.signals.signal_table import checked_names
from rope_model.state import RopeState

MAX_STEPS = 20_000  #: accepted steps of an advance
CURE = "take the engine, balance_rope(scene)"


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
            raise RuntimeError("the rope has no state yet: call initialize first")
        return self._state

    def initialize(self, t: float, left: EndMotion, right: EndMotion) -> Status:
        for side, motion in zip(SIDES, (left, right), strict=True):
            message = refusal(motion, side)
            if message is not None:
                return Status(False, message)
            speed = max(map(abs, (*motion.velocity, motion.yaw_rate)))
            if speed > RESTS_BELOW:
                return Status(
                    False,
                    f"the {side} end moves at {speed:g} m/s or rad/s at the start and must rest: "
                    "start before it moves",
                )
        try:
            self._state = hang(self._scene, t, (resting(t, left), resting(t, right)))
        except (StaticsError, ValueError) as error:
            return Status(False, str(error))
        return Status(True)

    def advance_to(
        self, t: float, left: EndMotion, right: EndMotion, given_at: float | None = None
    ) -> Status:
        scene = self._scene
        before = self.state
        start = before.motion.t
        if abs(t - start) < MIN_INTERVAL:
            return Status(True)
        if not (math.isfinite(t) and t > start):
            return Status(False, f"t = {t:g} s must be after {start:g} s: give the end of the step")
        age = 0.0 if given_at is None else t - given_at
        earliest = start - scene.inputs.hold_max
        if not earliest <= t - age <= t + MIN_INTERVAL:
            return Status(
                False,
                f"given_at = {t - age:g} s must be between {earliest:g} s and {t:g} s: "
                "give the instant of the motions",
            )
        paths = []
        for side, path, motion in zip(SIDES, before.paths, (left, right), strict=True):
            message = refusal(motion, side)
            if message is not None:
                return Status(False, message)
            following_path = onwards(path, t, motion, age)
            peak = peak_acceleration(following_path)
            if not peak <= scene.inputs.acceleration_max:
                return Status(
                    False,
                    f"the {side} end would accelerate by {peak:.4g} m/s^2 or rad/s^2, above "
                    f"inputs.acceleration_max = {scene.inputs.acceleration_max:g}: give positions, "
                    "speeds and accelerations of one motion",
                )
            paths.append(following_path)
        state = replace(before, paths=(paths[0], paths[1]), events=())
        impulse = np.zeros(2)
        for _ in range(MAX_STEPS):
            after = step_towards(scene, state, t)
            if isinstance(after, Failure):
                return Status(False, failure_message(after))
            h = after.motion.t - state.motion.t
            impulse -= 0.5 * h * (_pulls(state) + _pulls(after))
            state = after
            if state.motion.t >= t:
                break
        else:
            what = f"the advance from {start:.6g} s to {t:.6g} s"
            return Status(False, failure_message(Failure(Cause.STEPS, state.motion.t, what)))
        mean = impulse / (t - start)
        self._state = replace(state, force_mean=(float(mean[0]), float(mean[1])))
        return Status(True)

    def signals(self, names: Iterable[str] | None = None) -> dict[str, float]:
        wanted = NAMES if names is None else checked_names(names)
        values: dict[str, float] = {}
        for name in wanted:
            group = group_of(name)
            if group is None:
                raise ValueError(f"the reference rope does not compute {name}: {CURE}")
            if name not in values:
                values |= group(self._scene, self.state)
        return {name: values[name] for name in wanted}

    def apply(self, forces: PointForces) -> None:
        if forces.s.size:
            raise ValueError(f"the reference rope takes no point forces: {CURE}")

    def rows(self) -> NDArray[np.float64]:
        m = self.state.motion
        return np.column_stack((self.state.mesh.nodes_s, m.q[:, :ANGLE], m.v[:, :ANGLE]))

    def displacement(self, forces: PointForces) -> NDArray[np.float64]:
        raise ValueError(f"the reference rope takes no point forces: {CURE}")

    def warnings(self) -> dict[str, str]:
        return warnings_of(self._scene, self.state)

    def save(self) -> bytes:
        return self.state.to_bytes()

    def snapshot(self) -> Snapshot:
        return Snapshot(self.state, _no_engine_state)

    def restore(self, data: bytes | RopeState | Snapshot) -> None:
        kept = data.kept if isinstance(data, Snapshot) else data
        state = State.from_bytes(kept) if isinstance(kept, bytes) else kept
        if not isinstance(state, State):
            raise ValueError("this is a state of the engine: restore one of the reference rope")
        saved = float(state.mesh.lengths.sum())
        length = self._scene.rope.length
        if not math.isclose(saved, length):
            raise ValueError(
                f"this is a state of a rope of {saved:g} m and must be one of {length:g} m: "
                "restore it into a rope with the same parameters"
            )
        self._state = state

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


def _no_engine_state(kept: object) -> RopeState:
    raise ValueError(f"a state of the reference rope is none of the engine: {CURE}")
