"""Time stepping of the rope: RopeSimulator, the Python form of BalanceRope.

``RopeSimulator`` advances a ``RopeState`` from one instant of the host to the next.  In between it chooses its own
steps, which end at the instants where a swivel is released or changes between stick and slip.  A transformation of the
mesh waits for a step's end, unless the step would carry the loop mesh.MAX_OVERSHOOT l beyond the limit.  A step that
does not converge or whose error is too large is rejected, halved and repeated.  When the smallest step fails too, the
run returns the reason and keeps the state of the host's last instant.
"""

import logging
import math
from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np

from rope_model.arrays import Array
from rope_model.interface import BalanceRope, Snapshot, Status, state_in
from rope_model.parameters import Scene
from rope_model.physics.centreline import suspension_points
from rope_model.physics.inextensible import rigid_tensions
from rope_model.physics.node import ANGLE
from rope_model.rules.audit import END_LOADS
from rope_model.rules.bodies import MONITOR_INTERVAL, NO_ROOM
from rope_model.rules.end_conditions import right_offset
from rope_model.rules.end_paths import RESTS_BELOW, SIDES, EndMotion, EndPath, ends_at
from rope_model.rules.fidelity import choose_fidelity, unsupported_motion
from rope_model.rules.generalized_alpha import Motion
from rope_model.rules.input_filter import InputFilter, path_measures, settings_of
from rope_model.rules.messages import fidelity_messages, messages
from rope_model.rules.messages.result_warnings import WARNINGS, ends_yaw
from rope_model.rules.messages.rules import first_text
from rope_model.rules.partition import Partition
from rope_model.rules.point_forces import PointForces, at_places, elements_at, nodal_forces
from rope_model.rules.signal_table import checked_names
from rope_model.rules.state import RopeState
from rope_model.rules.stepping import (
    MAX_START_TIME,
    MAX_STEPS,
    MIN_INTERVAL,
    UNBOUNDED,
    max_iterations,
)
from rope_model.rules.swivel_phases import Phase, SwivelState
from rope_model.simulation.contact.shaft import update_passages
from rope_model.simulation.curvature import start_director
from rope_model.simulation.ends.ends import HangingEnds, refusal, stale_input_error
from rope_model.simulation.ends.filter_program import filter_program, filter_step
from rope_model.simulation.mesh.adaptation import raise_fidelity
from rope_model.simulation.mesh.partition import fit_mesh, mesh_elements, partition
from rope_model.simulation.model import RopeModel, ends_of
from rope_model.simulation.outputs.diagnostics import LoopBottom, loop_bottom
from rope_model.simulation.outputs.guards import set_rise_reference, update_guards
from rope_model.simulation.outputs.signals import group_of
from rope_model.simulation.rope_kernels import KernelCache
from rope_model.simulation.rope_system import RopeSystem
from rope_model.simulation.stepping.hang import hang, paths_at_rest
from rope_model.simulation.stepping.statics import StaticsError, hanging_guess
from rope_model.simulation.stepping.stepping import as_rigid, step_towards
from rope_model.simulation.wires import start_hysteresis

log = logging.getLogger(__name__)


class RopeSimulator(BalanceRope):
    """The Python form of the rope; ``system``, ``ends`` and ``model`` serve analysis.

    Parameters
    ----------
    scene : Scene
        Data of the run.
    bundle : Path, optional
        Folder with prepared kernels, as inside an exported FMU.

    Raises
    ------
    ValueError
        If the mesh does not fit the rope.
    RuntimeError
        If the scene asks for compiled kernels and none can be had.
    """

    def __init__(self, scene: Scene, bundle: Path | None = None) -> None:
        try:
            self._mesh = fit_mesh(scene)
            elements = mesh_elements(scene)
        except ValueError as error:
            if scene.mesh.kind != "auto":
                raise
            raise ValueError(messages.fit_fails(str(error))) from error
        self.model = RopeModel(scene, KernelCache(elements, scene.solver.kernels, bundle))
        self._filter, self._filter_settings = filter_program(scene.rope), settings_of(scene)
        self._state: RopeState | None = None
        self._system: RopeSystem | None = None
        self._loop: LoopBottom | None = None
        self._signals: dict[str, float] = {}  # cache for the present state

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
    def loop(self) -> LoopBottom:
        """Lowest point of the loop in the present state."""
        if self._loop is None:
            self._loop = loop_bottom(self.state.motion.q, self.state.partition.lengths)
        return self._loop

    @property
    def ends(self) -> HangingEnds:
        """Boundary at the ends of the present state."""
        return ends_of(self.system)

    def signals(self, names: Iterable[str] | None = None) -> dict[str, float]:
        wanted = checked_names(names)
        for name in wanted:
            if name not in self._signals:
                self._signals |= group_of(name)(self)
        return {name: self._signals[name] for name in wanted}

    def warnings(self) -> dict[str, str]:
        texts = {subject: warning(self.scene, self.state) for subject, warning in WARNINGS.items()}
        return {subject: text for subject, text in texts.items() if text}

    def restore(self, data: bytes | RopeState | Snapshot) -> None:
        state = state_in(data)
        self._require_fitting(state)
        self._accept(state)

    def _require_fitting(self, state: RopeState) -> None:
        elements, model, length = (
            self.model.kernels.elements,
            self.scene.model.fidelity,
            self.scene.rope.length,
        )
        remembers = 0 if state.fidelity == "rigid" else start_hysteresis(self.scene, elements).size
        saved_length = float(state.partition.lengths.sum())
        for what, saved, here in (
            ("elements", state.partition.lengths.size, elements),
            ("model.fidelity", state.fidelity, state.fidelity if model == "auto" else model),
            (
                "rope.length",
                saved_length,
                saved_length if math.isclose(saved_length, length) else length,
            ),
            (
                "counts of II to VI, of I and VII, end_levels, grading_length and l",
                _pattern(state.partition),
                self._own_pattern,
            ),
            ("numbers that wires remember (rope.EI_stick)", state.hysteresis.size, remembers),
        ):
            if saved != here:
                found = f"not a state of this rope: {what}: {saved} there, {here} here"
                raise ValueError(f"{found}; restore it into a rope with the same parameters")

    @cached_property
    def _own_pattern(self) -> tuple[tuple[int, ...], int, int, float, float]:
        return _pattern(partition(self._mesh, self.scene.rope.length, 0.5 * self.scene.rope.length))

    def _retune(self, scene: Scene) -> None:
        self.model, self._system, self._signals = replace(self.model, scene=scene), None, {}
        self._filter_settings = settings_of(scene)

    def initialize(self, t: float, left: EndMotion, right: EndMotion) -> Status:
        scene, rope = self.scene, self.scene.rope
        if not abs(t) <= MAX_START_TIME:
            return Status(False, messages.start_time_out_of_range(t, MAX_START_TIME))
        # a rigid rope needs no way to its position
        paths = paths_at_rest(scene, t, (left, right), float(scene.model.fidelity == "rigid"))
        for side, target in zip(SIDES, (left, right), strict=True):
            measures = path_measures(EndPath.at_rest(t, target), InputFilter.at_rest(t, target))
            if message := refusal(scene, target, measures, side):
                return Status(False, message)
            if max(map(abs, (*target.velocity, target.yaw_rate))) > RESTS_BELOW:
                return Status(False, messages.moves_at_start(side))
        ends = np.array(suspension_points(scene.layout, *(path.at(t) for path in paths)))
        fidelity, reason = choose_fidelity(scene, (left, right), self.model.forces.s.size)
        try:
            if why := unsupported_motion(scene, fidelity, (left, right), self.model.forces.s.size):
                return Status(False, fidelity_messages.fixed_model_cannot_follow(fidelity, why))
            if no_room := first_text(NO_ROOM, scene, fidelity, left, right):
                return Status(False, no_room)
            cells = partition(
                self._mesh,
                rope.length,
                self.model.bottom_s(paths, t),
                self.model.dividers(paths, t),
            )
            guess = hanging_guess(cells.nodes_s, *ends)
            zeros = np.zeros_like(guess)
            state = RopeState(
                motion=Motion(t, guess, zeros, zeros, zeros, zeros, 0.0, zeros),
                partition=cells,
                offsets=(0.0, right_offset(*ends.tolist())),
                swivels=(
                    SwivelState(Phase.LOCKED, 0.0, 0.0),
                    SwivelState(Phase.LOCKED, rope.installed_twist, 0.0),
                ),
                paths=paths,
                filters=(InputFilter.at_rest(t, left), InputFilter.at_rest(t, right)),
                step_next=scene.solver.step_max,
                last_interval=scene.solver.step_max,
                force_mean=(0.0, 0.0),
                calm_since=t,
                loop_yaw=ends_yaw(guess),
                fidelity=fidelity,
                fidelity_reason=reason,
                director=start_director(guess),
            )
            state = (
                as_rigid(self.model, state, t)
                if fidelity == "rigid"
                else hang(self.model, state, (left, right))
            )
        except (StaticsError, ValueError) as error:
            return Status(False, str(error))
        if fidelity != "rigid":
            state = state._replace(hysteresis=start_hysteresis(scene, cells.lengths.size))
        force_mean = -float(state.motion.reaction[0, 1]), -float(state.motion.reaction[-1, 1])
        energy_balance = state.energy_balance._replace(start=state.energy_balance.total)
        state = state._replace(force_mean=force_mean, energy_balance=energy_balance, events=())
        state = update_passages(scene, set_rise_reference(scene, self.model.begin_audit(state)))
        self._accept(update_guards(scene, state, self.model.ends(state)))
        return Status(True)

    def advance_to(
        self, t: float, left: EndMotion, right: EndMotion, given_at: float | None = None
    ) -> Status:
        scene, state = self.scene, self.state
        start = state.motion.t
        if abs(t - start) < MIN_INTERVAL:
            return Status(True)
        if not (math.isfinite(t) and t > start):
            return Status(False, messages.time_goes_back(start, t))
        step_max, steps_before = (
            self.scene.solver.step_max,
            state.counts.steps + state.counts.rejections,
        )
        if t - start > MAX_STEPS * step_max:
            return Status(
                False, messages.too_far_at_once(start, t, MAX_STEPS, step_max, MAX_STEPS * step_max)
            )
        at, earliest = t if given_at is None else given_at, start - scene.inputs.hold_max
        if not earliest <= at <= t + MIN_INTERVAL:
            return Status(False, messages.motions_of_another_time(at, earliest, t))
        settings, steps = self._filter_settings, []
        bottom_s = self.model.bottom_s(state.paths, start)
        legs = bottom_s, scene.rope.length - bottom_s
        for k, (side, end) in enumerate(zip(SIDES, (left, right), strict=True)):
            filtered = filter_step(
                self._filter, state.filters[k], state.paths[k], settings, at, t, end, legs[k]
            )
            refused = refusal(scene, end, filtered.measures, side)
            if message := refused or stale_input_error(scene.inputs, t, filtered.filter, side):
                return Status(False, message)
            steps.append((filtered.path, filtered.filter))
        paths, filters = zip(*steps, strict=True)
        state = state._replace(paths=paths, filters=filters, events=())
        if scene.inputs.given != "all":
            left, right = ends_at((paths[0], paths[1]), t)
        if why := unsupported_motion(
            self.scene, state.fidelity, (left, right), self.model.forces.s.size
        ):
            if self.scene.model.fidelity != "auto":
                return Status(
                    False, fidelity_messages.fixed_model_cannot_follow(state.fidelity, why)
                )
            try:
                state = self.model.begin_audit(raise_fidelity(self.model, state, why))
            except StaticsError as error:
                return Status(False, str(error))
        audited, impulse = state.audit.impulse[END_LOADS:], [0.0, 0.0]
        newton_limit = state.counts.newton + (self.scene.solver.work_max or UNBOUNDED)
        newton, most = state.counts.newton, max_iterations(t - start, step_max)
        while state.motion.t < t:
            before = state.motion
            if state.counts.newton - newton >= most:
                return Status(
                    False, messages.too_much_work(before.t, state.counts.newton - newton, start, t)
                )
            if state.counts.steps + state.counts.rejections - steps_before >= MAX_STEPS:
                return Status(False, messages.too_many_steps(before.t, MAX_STEPS, start, t))
            advanced = step_towards(self.model, state, t, newton_limit)
            if isinstance(advanced, str):
                return Status(False, messages.fails_at(before.t, advanced))
            state, after = advanced, advanced.motion
            if after.t >= t or after.t - state.monitored_at >= MONITOR_INTERVAL:
                state = update_passages(self.scene, state)
                state = update_guards(self.scene, state, self.model.ends(state))
            if state.fidelity == "rigid":
                middle = ends_at(state.paths, 0.5 * (before.t + after.t))
                between = rigid_tensions(scene.rope, scene.layout, *middle).at_ends
                for node in (0, -1):
                    forces = (
                        float(before.reaction[node, 1] + after.reaction[node, 1])
                        + 4.0 * between[node]
                    )
                    impulse[node] += (after.t - before.t) / 6.0 * forces
        sums = zip(audited, state.audit.impulse[END_LOADS:], impulse, strict=True)
        left_mean, right_mean = (
            -(now - before_it + rigid) / (t - start) for before_it, now, rigid in sums
        )
        if state.counts.given_up and not self.state.counts.given_up:
            state = state._replace(given_up_since=start)
        state = self.model.audit_interval(self.state, state)
        self._accept(state._replace(last_interval=t - start, force_mean=(left_mean, right_mean)))
        return Status(True)

    def apply(self, forces: PointForces) -> None:
        forces.require_on(self.scene.rope.length)
        self.model, self._system, self._signals = replace(self.model, forces=forces), None, {}

    def rows(self) -> Array:
        m = self.state.motion
        return np.hstack((self.state.partition.nodes_s[:, None], m.q[:, :ANGLE], m.v[:, :ANGLE]))

    def displacement(self, forces: PointForces) -> Array:
        forces.require_on(self.scene.rope.length)
        m, system, c = (
            self.state.motion,
            self.system,
            self.model.method.newton(self.state.last_interval),
        )
        nodal = nodal_forces(forces, system.lengths, forces.start)
        alone, moved = (
            system.with_forces(fraction * nodal).newton_step(m.q, m.v, m.a, m.reaction, c)[0]
            for fraction in (0.0, 1.0)
        )
        return at_places(moved - alone, *elements_at(forces.s, system.lengths))

    def _accept(self, state: RopeState) -> None:
        self._state, self._system, self._loop, self._signals = state, None, None, {}


def _pattern(cells: Partition) -> tuple[tuple[int, ...], int, int, float, float]:
    """Return the part of the mesh that does not depend on the position of the loop."""
    return (
        cells.counts[1:6],
        sum(cells.counts[::6]),
        cells.end_levels,
        cells.grading_length,
        cells.coarse,
    )
