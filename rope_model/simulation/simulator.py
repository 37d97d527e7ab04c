"""The rope in time: physics and methods married.

``RopeSimulator`` advances a ``RopeState`` from one instant of the host to the next.  In between it chooses its own
steps, which end on the instants where something changes: a transformation of the mesh, the release of a swivel, a
change between stick and slip.  A step that does not converge or errs too much is rejected, halved and tried again;
when the smallest step fails too, the run reports why and keeps the state of the host's last instant.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from ..numerics.events import locate
from ..numerics.generalized_alpha import Motion, StepResult
from ..parameters import Scene
from ..physics.estimates import bending_length
from . import messages
from .adaptation import raise_fidelity, transform_if_due, with_loop_yaw
from .balance_rope import BalanceRope, Snapshot, Status, state_in
from .diagnostics import LoopBottom, loop_bottom
from .ends import (
    SHORTEST_AIM,
    SIDES,
    EndMotion,
    EndPath,
    HangingEnds,
    Phase,
    SwivelState,
    nominal_points,
    refusal,
    right_offset,
)
from .fidelity import Fidelity, choose_fidelity, unsupported_motion
from .mesh import LATEST, Partition, distance_to_due, fit_mesh, partition, placement_problem
from .model import RopeModel, ends_of, energies, powers
from .result_warnings import WARNINGS
from .rigid import rigid_added_mass, rigid_rope
from .rope_system import ANGLE, Array, Evaluation, KernelCache, RopeSystem
from .signals import checked_names, group_of
from .state import Counts, RopeState
from .statics import StaticsError, find_equilibrium, hanging_guess
from .switching import chatters, next_release, release_swivels, switch_swivels, switching_step

log = logging.getLogger(__name__)

#: s: in less nothing moves; hosts that end on a multiple of their step arrive there by such rests of it
SHORTEST_INTERVAL = 1e-9
#: steps, rejected ones too, of one communication step: some hundred seconds, and no call goes on for ever
MOST_STEPS = 20000
#: s: beyond, the shortest steps are lost in the rounding of the time
FARTHEST_START = 1e10
#: a step that errs by more than what is allowed makes the next one half as long, and this many times that is rejected
ACCEPT_BELOW = 2.0
#: the step grows after errors below this part of what is allowed for so long, s: the loop's place errs by a part that
#: goes with the step's length, and every change of that sends a wave along the rope
GROW_BELOW, CALM = 0.05, 0.5
#: Newton iterations that a step is reckoned to take where they are bounded: the most that steps of trips took
STEP_WORK = 12
#: as good as no bound
UNBOUNDED = 2**31 - 1
#: rad of twist put in at once, at most and at least
TWIST_STEP, LEAST_TWIST_STEP = 1.0, 0.01
#: rad: a rope whose frame turns by more at the right end, twice the loop's yaw, has left the way it was on
MOST_TURN = 2.0


@dataclass(frozen=True)
class _Accepted:
    """An accepted trial step, the one to try next, since when errors are small, and whether it ends where it was to."""

    result: StepResult[Evaluation]
    step_next: float
    calm_since: float
    counts: Counts
    reaches_stop: bool


class RopeSimulator(BalanceRope):
    """The Python form of the rope; ``system``, ``ends`` and ``model`` are there for analysis.

    ``bundle`` is a folder with prepared kernels, as inside an exported FMU.  Raises RuntimeError when compiled
    kernels are demanded in vain, ValueError when the mesh does not fit the rope.
    """

    def __init__(self, scene: Scene, bundle: Path | None = None) -> None:
        try:
            self._mesh = fit_mesh(scene)
            elements = partition(self._mesh, scene.rope.length, 0.5 * scene.rope.length).lengths.size
        except ValueError as error:
            if scene.mesh.kind != "auto":
                raise
            raise ValueError(messages.fitted_mesh_fails(str(error))) from error
        self.model = RopeModel(scene, KernelCache(elements, scene.solver.kernels, bundle))
        self._state: RopeState | None = None
        self._system: RopeSystem | None = None
        self._loop: LoopBottom | None = None
        self._signals: dict[str, float] = {}  # of the present state, as far as they were asked for
        self._unmoved: tuple[RopeSystem, Array, Array] | None = None  # what `answer` compares with

    @property
    def scene(self) -> Scene:
        return self.model.scene

    @property
    def state(self) -> RopeState:
        if self._state is None:
            raise RuntimeError(messages.no_state())
        return self._state

    @property
    def system(self) -> RopeSystem:
        """Equations of motion of the present state."""
        if self._system is None:
            self._system = self.model.system(self.state)
        return self._system

    @property
    def form(self) -> str:
        return self.system.kernels.form

    @property
    def elements(self) -> int:
        return self.model.kernels.elements

    @property
    def time(self) -> float:
        return self.state.motion.t

    @property
    def fidelity(self) -> Fidelity:
        return self.state.fidelity

    @property
    def fidelity_reason(self) -> str:
        return self.state.fidelity_reason

    @property
    def loop(self) -> LoopBottom:
        """The loop's lowest point in the present state."""
        if self._loop is None:
            self._loop = loop_bottom(self.state.motion.q, self.state.partition.lengths)
        return self._loop

    @property
    def ends(self) -> HangingEnds:
        """How the present state's ends are held."""
        return ends_of(self.system)

    def signals(self, names: Iterable[str] | None = None) -> dict[str, float]:
        wanted = checked_names(names)
        for name in wanted:
            if name not in self._signals:
                self._signals |= group_of(name)(self)
        return {name: self._signals[name] for name in wanted}

    def warnings(self) -> dict[str, str]:
        told = {warning.__name__: warning(self.scene, self.state) for warning in WARNINGS}
        return {subject: text for subject, text in told.items() if text}

    def restore(self, data: bytes | RopeState | Snapshot) -> None:
        state = state_in(data)
        self._require_fitting(state)
        self._accept(state)

    def _require_fitting(self, state: RopeState) -> None:
        if state.partition.lengths.size != self.model.kernels.elements:
            raise ValueError(
                f"the saved state has {state.partition.lengths.size} elements, "
                f"this rope {self.model.kernels.elements}; restore it into a rope with the same parameters"
            )
        if (saved := _pattern(state.partition)) != self._own_pattern:
            raise ValueError(
                f"not a state of this rope: counts of II to VI, of I and VII, end_levels, grading_length and l are "
                f"{saved}, here {self._own_pattern}; restore it into a rope with the same parameters"
            )

    @cached_property
    def _own_pattern(self) -> tuple[tuple[int, ...], int, int, float, float]:
        return _pattern(partition(self._mesh, self.scene.rope.length, 0.5 * self.scene.rope.length))

    def retune(self, scene: Scene) -> None:
        self.model, self._system, self._signals = replace(self.model, scene=scene), None, {}

    def initialize(self, t: float, left: EndMotion, right: EndMotion) -> Status:
        scene, rope = self.scene, self.scene.rope
        if not abs(t) <= FARTHEST_START:
            return Status(False, messages.start_time_out_of_range(t, FARTHEST_START))
        paths = (EndPath.at_rest(t, left), EndPath.at_rest(t, right))
        for side, target, path in zip(SIDES, (left, right), paths, strict=True):
            if message := refusal(target, path, side):
                return Status(False, message)
            if max(map(abs, (*target.velocity, target.yaw_rate))) > 1e-6:
                return Status(False, messages.moves_at_start(side))
        ends = nominal_points(scene.layout.spacing) + np.array([left.position, right.position])
        fidelity, reason = choose_fidelity(scene, (left, right))
        try:
            bottom = self.model.bottom(paths, t)
            cells = partition(self._mesh, rope.length, bottom)
            guess = hanging_guess(cells.nodes_s, *ends)
            if message := unsupported_motion(scene, fidelity, (left, right)) or self._placement_problem(cells, bottom):
                return Status(False, message)
            rest = np.zeros_like(guess)
            state = RopeState(
                motion=Motion(t, guess, rest, rest, rest, rest, 0.0, rest),
                partition=cells,
                offsets=(0.0, right_offset(*ends.tolist())),
                swivels=(SwivelState(Phase.LOCKED, 0.0, 0.0), SwivelState(Phase.LOCKED, rope.installed_twist, 0.0)),
                paths=paths,
                step_next=scene.solver.step_max,
                last_interval=scene.solver.step_max,
                force_mean=(0.0, 0.0),
                calm_since=t,
                loop_yaw=0.0,
                fidelity=fidelity,
                fidelity_reason=reason,
            )
            state = self._rigid(state, t) if fidelity == "rigid" else self._initial_equilibrium(state)
        except (StaticsError, ValueError) as error:
            return Status(False, str(error))
        force_mean = -float(state.motion.reaction[0, 1]), -float(state.motion.reaction[-1, 1])
        energy_balance = state.energy_balance._replace(start=state.energy_balance.total)
        state = state._replace(force_mean=force_mean, energy_balance=energy_balance, events=())
        self._accept(self.model.audit_begun(state))
        return Status(True)

    def _placement_problem(self, cells: Partition, bottom: float) -> str:
        """As mesh.misplaced; where the mesh was fitted to the rope, with what it was fitted to."""
        message, rope, stiff = placement_problem(cells, bottom), self.scene.rope, bending_length(self.scene)
        if not message or self.scene.mesh.kind != "auto":
            return message
        return messages.loop_near_end_of_fitted_mesh(bottom, rope.length, rope.EI, stiff, cells.centre)

    def _initial_equilibrium(self, state: RopeState) -> RopeState:
        """``state`` at rest, hung up untwisted and then turned in."""
        q, held = state.motion.q, self.model.system(state).prescribed_motion(state.motion.t)[0]
        q[:, ANGLE] = held[0, ANGLE]
        twist = float(held[-1, ANGLE] - held[0, ANGLE])
        return self._turned_in(self._equilibrium_in_frame(_turn_right_end(state, -twist)), twist)

    def _turned_in(self, state: RopeState, twist: float) -> RopeState:
        """``state`` with ``twist`` (rad) more, put in so slowly that the speed does not matter.

        Steps are halved where the rope turns far or finds no rest.  Where the shortest does, the way it was on ends at
        a limit point: it snaps over, and goes on from where it comes to rest.
        """
        left, step = twist, math.copysign(TWIST_STEP, twist)
        while left != 0:
            step = step if abs(step) < abs(left) else left
            last = abs(step) <= LEAST_TWIST_STEP
            try:
                after = self._equilibrium_in_frame(_twist_evenly(state, step), math.inf if last else MOST_TURN)
            except StaticsError as error:
                if last:
                    raise StaticsError(messages.fails_at_twist(twist - left, twist, str(error))) from error
                step *= 0.5
                continue
            left -= step
            if abs(after.offsets[1] - state.offsets[1] - step) > MOST_TURN:
                after = after._replace(snapped_at=twist - left)
            state, step = after, math.copysign(min(2 * abs(step), TWIST_STEP), twist)
        return state

    def _equilibrium_in_frame(self, state: RopeState, most_turn: float = math.inf) -> RopeState:
        """``state`` in equilibrium."""
        m, rest = state.motion, np.zeros_like(state.motion.q)
        found = find_equilibrium(self.model.system(state), m.q, m.t, most_turn=most_turn)
        motion = Motion(m.t, found.q, rest, rest, rest, rest, 0.0, found.reaction)
        state = _turn_right_end(state._replace(motion=motion), found.turn)
        balance = self.model.system(state).evaluate(found.q, rest, rest, found.reaction).balance
        # a loop that yaws by psi turns the frame of the right end by -2 psi: which tells full turns on a long way
        yaw = state.loop_yaw - 0.5 * found.turn
        books = state.energy_balance._replace(**energies(balance))
        return with_loop_yaw(state._replace(energy_balance=books, loop_yaw=yaw))

    def _rigid(self, state: RopeState, t: float) -> RopeState:
        """``state`` as the rigid model has it at ``t``."""
        state = transform_if_due(self.model, state._replace(motion=replace(state.motion, t=t)))
        rope = rigid_rope(self.scene, state.paths, t, state.partition.nodes_s)
        return state._replace(
            motion=rope.motion, energy_balance=state.energy_balance._replace(kinetic=rope.kinetic, gravity=rope.gravity)
        )

    def advance_to(self, t: float, left: EndMotion, right: EndMotion, within: float = SHORTEST_AIM) -> Status:
        state = self.state
        start = state.motion.t
        if abs(t - start) < SHORTEST_INTERVAL:
            return Status(True)
        if not (math.isfinite(t) and t > start):
            return Status(False, messages.time_goes_back(start, t))
        step_max, steps_before = self.scene.solver.step_max, state.counts.steps + state.counts.rejections
        if t - start > MOST_STEPS * step_max:
            return Status(False, messages.too_far_at_once(start, t, MOST_STEPS, step_max, MOST_STEPS * step_max))
        paths = tuple(path.to(t, target, within) for path, target in zip(state.paths, (left, right), strict=True))
        for side, target, path in zip(SIDES, (left, right), paths, strict=True):
            if message := refusal(target, path, side):
                return Status(False, message)
        state = state._replace(paths=(paths[0], paths[1]), events=())
        if why := unsupported_motion(self.scene, state.fidelity, (left, right)):
            if self.scene.model.fidelity != "auto":
                return Status(False, messages.fixed_model_cannot_follow(state.fidelity, why))
            try:
                state = self.model.audit_begun(raise_fidelity(self.model, state, why))
            except StaticsError as error:
                return Status(False, str(error))
        impulse = [0.0, 0.0]
        work_end = state.counts.newton + (self.scene.solver.work_max or UNBOUNDED)
        while state.motion.t < t:
            before = state.motion
            if state.counts.steps + state.counts.rejections - steps_before >= MOST_STEPS:
                return Status(False, messages.too_many_steps(before.t, MOST_STEPS, start, t))
            advanced = self._step_towards(state, t, work_end)
            if isinstance(advanced, str):
                return Status(False, messages.fails_at(before.t, advanced))
            state = advanced
            now = state.motion
            for node in (0, -1):
                impulse[node] -= 0.5 * (now.t - before.t) * float(before.reaction[node, 1] + now.reaction[node, 1])
        mean = impulse[0] / (t - start), impulse[1] / (t - start)
        if state.counts.given_up and not self.state.counts.given_up:
            state = state._replace(given_up_since=start)
        state = self.model.audited(self.state, state)
        self._accept(state._replace(last_interval=t - start, force_mean=mean))
        return Status(True)

    def added_mass(self) -> tuple[float, float]:
        # one step of that length carries the change y = a h^2 / 2, v = a h
        m, h, size = self.state.motion, self.state.last_interval, 1e-3
        if self.state.fidelity == "rigid":
            return rigid_added_mass(self.scene, self.state.paths, m.t, h)
        held, none, masses = np.array([0.5 * h * h, h, 1.0]), np.zeros(3), []
        for side, node in enumerate((0, -1)):
            before, after = (self.answer(side, 1, change)[1][node, 1] for change in (none, size * held))
            masses.append(float(after - before) / size)
        return masses[0], masses[1]

    def answer(self, side: int, dof: int, change: Array) -> tuple[Array, Array]:
        """q and reactions when a coordinate of an end is moved by ``change`` in q, q_t, q_tt at the last step's end.

        The rest of the rope answers as its equations are linear in that step.
        """
        m, system, c = self.state.motion, self.system, self.model.method.newton(self.state.last_interval)
        if self._unmoved is None or self._unmoved[0] is not system:
            self._unmoved = system, *system.newton_step(m.q, m.v, m.a, m.reaction, c)
        _, unperturbed, reaction = self._unmoved
        if not change.any():
            return m.q, reaction
        q, v, a = m.q.copy(), m.v.copy(), m.a.copy()
        for x, dx in zip((q, v, a), change, strict=True):
            x[-side, dof] += dx
        y = system.newton_step(q, v, a, m.reaction, c)[0] - unperturbed
        q += y
        return q, system.evaluate(q, v + c[1] * y, a + c[2] * y, m.reaction).reaction

    # one step, and what may end it

    def _step_towards(self, state: RopeState, t_end: float, work_end: int) -> RopeState | str:
        """The state after one accepted step, or why there is none.

        ``work_end`` is the number of Newton iterations since the start beyond which accuracy is given up.
        """
        model = self.model
        if state.fidelity == "rigid":
            return self._rigid_step(state, t_end)
        state = release_swivels(model, transform_if_due(model, state))
        if message := self._placement_problem(state.partition, model.bottom(state.paths, state.motion.t)):
            return message
        system = model.system(state)
        stop = self._next_stop(state, t_end)
        while True:
            step = self._accepted_step(system, state, stop, work_end)
            if isinstance(step, str):
                return step
            result, reaches_stop, counts = step.result, step.reaches_stop, step.counts
            assert result.motion is not None
            whole = result.motion.t - state.motion.t
            # the step to the event, and one from there on, come after the trials
            work = work_end - counts.newton - 2 * STEP_WORK
            if (switching := switching_step(model, system, state, result, work)) is None:
                break
            h, iterations = switching
            result = model.trial(system, state.motion, h)
            counts = counts.plus(newton=iterations + result.newton.iterations, given_up=int(iterations >= work))
            if result.motion is not None:
                break
            # a shorter one may not reach the event, or find it more easily
            shorter = max(0.5 * whole, self.scene.solver.step_min)
            if shorter > 0.75 * whole:
                return messages.step_to_event_fails(result.newton.status.text)
            log.debug("t = %.6f s: step to a swivel event rejected: %s", state.motion.t, result.newton.status.text)
            counts = counts.plus(rejections=1)
            state = state._replace(step_next=shorter, calm_since=step.calm_since, counts=counts)
        after = model.commit(state, system, result)
        after = after._replace(step_next=step.step_next, calm_since=step.calm_since, counts=counts.plus(steps=1))
        if switching is not None:
            after = switch_swivels(model, after)
            if chatters(after):
                return messages.swivel_chatters()
        elif reaches_stop:
            after = after._replace(motion=replace(after.motion, t=stop))  # to the bit, not to rounding
        return with_loop_yaw(after)

    def _rigid_step(self, state: RopeState, t_end: float) -> RopeState | str:
        """The rigid rope follows its ends in one go."""
        try:
            after = self._rigid(state, t_end)
        except (StaticsError, ValueError) as error:
            return str(error)
        now, h = powers(self.model.system(after), after.motion), t_end - state.motion.t
        work = after.energy_balance.work_ends + 0.5 * h * (state.powers.ends + now.ends)
        return after._replace(
            powers=now, energy_balance=after.energy_balance._replace(work_ends=work), counts=after.counts.plus(steps=1)
        )

    def _accepted_step(self, system: RopeSystem, state: RopeState, stop: float, work_end: int) -> _Accepted | str:
        """A step towards ``stop`` that converges and errs little enough, halved as often as it takes.

        Where the work that is left does not allow for more steps, one that errs too much will do.
        """
        solver, t = self.scene.solver, state.motion.t
        step_next, cause = min(state.step_next, solver.step_max), ""
        iterations = rejections = 0
        parts = max(math.ceil((stop - t) / step_next - 1e-9), 1)
        # the work that is left may take longer ones, but Newton's method need not converge in much longer ones
        parts = min(parts, max(_steps_left(work_end - state.counts.newton), math.ceil(0.5 * parts)))
        h = (stop - t) / parts
        while True:
            result = self.model.trial(system, state.motion, h)
            iterations += result.newton.iterations
            error = self.model.relative_error(state, result)
            if error <= ACCEPT_BELOW * solver.tolerance:
                break
            left = _steps_left(work_end - state.counts.newton - iterations)
            if result.motion is not None and stop - t > 0.5 * h * left:
                step_next = h
                break
            cause = (
                result.newton.status.text
                if result.motion is None
                else messages.error_too_large(error / solver.tolerance)
            )
            log.debug("t = %.6f s: step %.3g s rejected: %s", t, h, cause)
            rejections += 1
            if h <= solver.step_min:
                return messages.step_fails(h, solver.step_min, cause)
            h = max(0.5 * h, solver.step_min)
            parts, step_next = 2, h
        calm_since = t + h if cause or error > GROW_BELOW * solver.tolerance else state.calm_since
        given_up = error > ACCEPT_BELOW * solver.tolerance
        if not given_up and error > solver.tolerance:
            step_next = max(0.5 * h, solver.step_min)
        elif t + h - calm_since > CALM and step_next < solver.step_max:
            step_next, calm_since = min(2.0 * step_next, solver.step_max), t + h
        given_up |= h > solver.step_max * (1.0 + 1e-9)
        counts = state.counts.plus(newton=iterations, rejections=rejections, given_up=int(given_up))
        return _Accepted(result, step_next, calm_since, counts, parts == 1)

    def _next_stop(self, state: RopeState, t_end: float) -> float:
        """The instant at which the coming steps must end: the host's or a release.

        Also a transformation, where a step would carry the loop too far past it; else it waits for the step's end,
        because a step that is cut short errs by more than a mesh that is a little late.
        """
        t, stop = state.motion.t, min(t_end, next_release(self.model, state))
        ahead = min(stop, t + min(state.step_next, self.scene.solver.step_max))

        def due(time: float) -> float:
            return distance_to_due(state.partition, self.model.bottom(state.paths, time))

        # a crossing that falls between these instants is found by the next step, at most one step late
        at_start = due(t)
        for time in (0.5 * (t + ahead), ahead):
            if at_start < 0 and (at_time := due(time)) >= LATEST * state.partition.coarse:
                return min(locate(due, t, time, at_start, at_time, 1e-9), stop)
        return stop

    def _accept(self, state: RopeState) -> None:
        self._state, self._system, self._loop, self._signals = state, None, None, {}


def _steps_left(work: int) -> int:
    """Steps that so many Newton iterations allow for, one at least."""
    return max(work // STEP_WORK, 1)


def _turn_right_end(state: RopeState, angle: float) -> RopeState:
    """The right end turned by ``angle`` (rad) against its conveyance."""
    left, right = state.offsets
    return state._replace(offsets=(left, right + angle))


def _twist_evenly(state: RopeState, angle: float) -> RopeState:
    """The same, the angle spread along the rope."""
    m, s = state.motion, state.partition.nodes_s
    q = m.q.copy()
    q[:, ANGLE] += angle * (s / s[-1])
    return _turn_right_end(state._replace(motion=replace(m, q=q)), angle)


def _pattern(cells: Partition) -> tuple[tuple[int, ...], int, int, float, float]:
    """What all places of the loop have in common."""
    return cells.counts[1:6], sum(cells.counts[::6]), cells.end_levels, cells.grading_length, cells.coarse
