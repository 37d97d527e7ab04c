"""The rope in time: physics and methods married.

``RopeSimulator`` advances a ``RopeState`` from one instant of the host to the next.  In between it chooses its own
steps, which end on the instants where something changes: a transformation of the mesh, the release of a swivel, a
change between stick and slip.  A step that does not converge or errs too much is rejected, halved and tried again;
when the smallest step fails too, the run reports why and keeps the state of the host's last instant.
"""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..numerics.events import locate
from ..numerics.generalized_alpha import Coefficients, Motion, StepResult, restart, step
from ..parameters import Scene
from ..physics.frame import best_pole, pole_change_angle, pole_margin, smallest_rotation_rate
from .diagnostics import loop_bottom
from .ends import EndMotion, EndPath, HangingEnds, Phase, SwivelState, checked, nominal_points
from .mesh import Partition, distance_to_due, partition, transformation_due, transformed
from .rope_system import ANGLE, POSITION, SLOPE, Assessment, RopeKernels, RopeSystem, parameter_vector
from .state import Ledger, Powers, RopeState
from .statics import StaticsError, find_equilibrium, hanging_guess
from .transfer import transferred

log = logging.getLogger(__name__)

#: width in s to which swivel events are located
EVENT_WIDTH = 1e-9
#: 1 + p . t below which a new frame pole is taken; 0 is singular
POLE_MARGIN = 0.35
#: local error below this part of the tolerance lets the step grow
GROW_BELOW = 0.1


@dataclass(frozen=True)
class Status:
    """Whether the rope's state is valid; if not, the message names cause and cure."""

    valid: bool
    message: str = ""


class RopeSimulator:
    """A balance rope between two conveyances.

    ``initialize`` finds the hanging shape, ``advance_to`` follows the conveyances.  ``bundle`` is a folder with
    prepared kernels, as inside an exported FMU.  Raises RuntimeError when compiled kernels are demanded in vain,
    ValueError when the mesh does not fit the rope.
    """

    def __init__(self, scene: Scene, bundle: Path | None = None) -> None:
        self.scene = scene
        self.points = nominal_points(scene.layout.spacing)
        elements = partition(scene.mesh, scene.rope.length, 0.5 * scene.rope.length).lengths.size
        self.kernels = RopeKernels(elements, scene.solver.kernels, bundle)
        self._state: RopeState | None = None
        self._system: RopeSystem | None = None

    @property
    def method(self) -> Coefficients:
        """The integration method."""
        return Coefficients(self.scene.solver.rho_inf)

    @property
    def state(self) -> RopeState:
        """The present state; RuntimeError before ``initialize``."""
        if self._state is None:
            raise RuntimeError("the rope has no state yet; call initialize first")
        return self._state

    @property
    def system(self) -> RopeSystem:
        """Equations of motion of the present state."""
        if self._system is None:
            self._system = self._system_of(self.state)
        return self._system

    @property
    def ends(self) -> HangingEnds:
        """How the present state's ends are held."""
        return _ends(self.system)

    def save(self) -> bytes:
        """The complete state."""
        return self.state.to_bytes()

    def restore(self, data: bytes | RopeState) -> None:
        """Go on from a saved state; ValueError when it does not fit this scene."""
        state = RopeState.from_bytes(data) if isinstance(data, bytes) else data
        if state.partition.lengths.size != self.kernels.elements:
            raise ValueError(
                f"the saved state has {state.partition.lengths.size} elements, this rope {self.kernels.elements}; "
                "restore it into a rope with the same parameters"
            )
        self._accept(state)

    def retune(self, scene: Scene) -> None:
        """Go on with other solver tolerances or swivel friction; nothing else of the scene may differ."""
        self.scene, self._system = scene, None

    def initialize(self, t: float, left: EndMotion, right: EndMotion) -> Status:
        """Hang the rope at rest between the ends' positions, untwisted but for the installed twist."""
        scene, rope = self.scene, self.scene.rope
        paths = (EndPath.resting(t, left), EndPath.resting(t, right))
        for side, target, path in zip(("left", "right"), (left, right), paths, strict=True):
            if message := checked(target, path, side):
                return Status(False, message)
            if max(map(abs, (*target.velocity, target.yaw_rate))) > 0.01:
                return Status(False, f"the {side} end moves at the start; a run starts from rest")
        ends = self.points + [left.position, right.position]
        held = (SwivelState(Phase.LOCKED, 0.0, 0.0), SwivelState(Phase.LOCKED, rope.installed_twist, 0.0))
        try:
            cells = partition(scene.mesh, rope.length, self._bottom(paths, t))
            guess = hanging_guess(np.concatenate(([0.0], np.cumsum(cells.lengths))), *ends)
            rest = np.zeros_like(guess)
            motion = Motion(t, guess, rest, rest, rest, rest, 0.0, rest)
            state = RopeState(
                motion=motion,
                partition=cells,
                pole=np.array([1.0, 0.0, 0.0]),
                offsets=(0.0, 0.0),
                swivels=held,
                paths=paths,
                step_next=scene.solver.step_max,
                last_interval=scene.solver.step_max,
                force_mean=(0.0, 0.0),
                loop_yaw=0.0,
            )
            equilibrium = find_equilibrium(self._system_of(state), guess, t)
        except (StaticsError, ValueError) as error:
            return Status(False, str(error))
        reaction = equilibrium.reaction
        state = replace(
            state,
            motion=replace(motion, q=equilibrium.q, reaction=reaction),
            force_mean=(-float(reaction[0, 1]), -float(reaction[-1, 1])),
        )
        balance = self._system_of(state).assess(t, equilibrium.q, rest, rest, reaction).balance
        ledger = _with_energies(Ledger(), balance)
        state = replace(state, ledger=replace(ledger, start=ledger.total))
        self._accept(self._with_loop_yaw(self._with_good_pole(state)))
        return Status(True)

    def advance_to(self, t: float, left: EndMotion, right: EndMotion) -> Status:
        """Follow the conveyances to their motions at ``t``.  On failure the state stays what it was."""
        state = self.state
        start = state.motion.t
        if not math.isfinite(t) or t <= start:
            return Status(False, f"cannot advance from t = {start:g} s to {t} s; time must go forward")
        paths = tuple(path.to(t, target) for path, target in zip(state.paths, (left, right), strict=True))
        for side, target, path in zip(("left", "right"), (left, right), paths, strict=True):
            if message := checked(target, path, side):
                return Status(False, message)
        state = replace(state, paths=(paths[0], paths[1]))
        impulse = np.zeros(2)
        while state.motion.t < t:
            before = state
            advanced = self._step_towards(state, t)
            if isinstance(advanced, str):
                return Status(False, f"t = {state.motion.t:.6g} s: {advanced}")
            state = advanced
            forces = [-x.motion.reaction[[0, -1], 1] for x in (before, state)]
            impulse += 0.5 * (state.motion.t - before.motion.t) * (forces[0] + forces[1])
        mean = impulse / (t - start)
        self._accept(replace(state, last_interval=t - start, force_mean=(float(mean[0]), float(mean[1]))))
        return Status(True)

    def added_mass(self) -> tuple[float, float]:
        """kg: how much each end's downward force grows with an upward acceleration held over the last interval.

        The rope is linearised about the present state; one generalized-alpha step of that length carries the
        perturbation y = a h^2 / 2, v = a h.
        """
        state, system, method, m = self.state, self.system, self.method, self.state.motion
        h = state.last_interval
        c = np.array(
            [
                1.0,
                method.gamma / (method.beta * h),
                (1 - method.alpha_m) / (method.beta * h * h * (1 - method.alpha_f)),
            ]
        )
        size = 1e-3
        masses = []
        for node in (0, -1):
            q, v, a = m.q.copy(), m.v.copy(), m.a.copy()
            q[node, 1] += 0.5 * h * h * size
            v[node, 1] += h * size
            a[node, 1] += size
            _, unperturbed = system.direction(m.t, m.q, m.v, m.a, m.reaction, c)
            correction, _ = system.direction(m.t, q, v, a, m.reaction, c)
            settled, _ = system.direction(m.t, m.q, m.v, m.a, m.reaction, c)
            x = correction - settled
            reaction = system.assess(m.t, q + x, v + c[1] * x, a + c[2] * x, m.reaction).reaction
            masses.append(float(reaction[node, 1] - unperturbed[node, 1]) / size)
        return masses[0], masses[1]

    # one step, and what may end it

    def _step_towards(self, state: RopeState, t_end: float) -> RopeState | str:
        """The state after one accepted step, or why there is none."""
        state = self._released(self._transformed_if_due(state))
        solver, t = self.scene.solver, state.motion.t
        system = self._system_of(state)
        stop, transforms = self._next_stop(state, t_end)
        whole = math.ceil((stop - t) / state.step_next - 1e-9)
        h = (stop - t) / max(whole, 1)
        counts, step_next, cause = state.counts, state.step_next, ""
        while h >= solver.step_min or whole <= 1:
            result = self._trial(system, state.motion, h)
            counts = counts.plus(newton=result.newton.iterations)
            if result.motion is not None and result.error <= solver.tolerance:
                break
            cause = (
                result.newton.status.value
                if result.motion is None
                else f"the local error {result.error:.3g} exceeds the tolerance {solver.tolerance:.3g}"
            )
            log.debug("t = %.6f s: step %.3g s rejected: %s", t, h, cause)
            counts = counts.plus(rejections=1)
            h, whole = 0.5 * h, 2 * max(whole, 1)
            step_next = h
        else:
            return (
                f"the smallest step of {solver.step_min:g} s fails too: {cause}. "
                "Use shorter elements (coarse_length), a smaller step_min, or a gentler motion"
            )
        assert result.motion is not None and result.assessment is not None
        if cause == "" and result.error < GROW_BELOW * solver.tolerance:
            step_next = min(2.0 * step_next, solver.step_max)
        state = replace(state, step_next=step_next, counts=counts)

        switching = self._switching_instant(system, state, result)
        if switching is not None:
            result = self._trial(system, state.motion, switching)
            if result.motion is None or result.assessment is None:
                return f"the step to a swivel event fails: {result.newton.status.value}"
        after = self._committed(state, system, result)
        if switching is not None:
            after = self._switched(after)
        elif whole <= 1:
            after = replace(after, motion=replace(after.motion, t=stop))  # to the bit, not to rounding
            if transforms:
                after = self._transformed_if_due(after)
        return self._with_loop_yaw(self._with_good_pole(after))

    def _trial(self, system: RopeSystem, old: Motion, h: float) -> StepResult[Assessment]:
        return step(system, old, h, self.method, self.scene.solver.newton_tolerance)

    def _next_stop(self, state: RopeState, t_end: float) -> tuple[float, bool]:
        """The instant at which the coming steps must end, and whether a transformation waits there."""
        t = state.motion.t
        stop = t_end
        for swivel, now in zip((self.scene.left, self.scene.right), state.swivels, strict=True):
            if now.phase is Phase.LOCKED and swivel.mode != "locked" and t < swivel.release_time < stop:
                stop = swivel.release_time

        def due(time: float) -> float:
            return distance_to_due(state.partition, self._bottom(state.paths, time))

        # within one interval of the host the loop travels a small part of l: its two ends and the middle suffice
        at_start = due(t)
        for time in (0.5 * (t + stop), stop):
            if (at_time := due(time)) >= 0 > at_start:
                return min(locate(due, t, time, at_start, at_time, 1e-9), stop), True
        return stop, False

    def _bottom(self, paths: tuple[EndPath, EndPath], t: float) -> float:
        """Arc length (m) of the loop's lowest point by the ends' heights alone."""
        return 0.5 * (self.scene.rope.length + float(paths[0](t)[0][1] - paths[1](t)[0][1]))

    def _committed(self, old: RopeState, system: RopeSystem, result: StepResult[Assessment]) -> RopeState:
        """The accepted step, with energies and work booked."""
        motion, assessment = result.motion, result.assessment
        assert motion is not None and assessment is not None
        powers = _powers(system, motion, assessment)
        h = motion.t - old.motion.t

        def work(name: str) -> float:
            return 0.5 * h * (getattr(old.powers, name) + getattr(powers, name))

        ledger = _with_energies(old.ledger, assessment.balance)
        ledger = replace(
            ledger,
            work_ends=ledger.work_ends + work("ends"),
            dissipated_material=ledger.dissipated_material + work("material"),
            dissipated_swivel=ledger.dissipated_swivel + work("swivel"),
            nonconservative=ledger.nonconservative + work("nonconservative"),
        )
        return replace(old, motion=motion, ledger=ledger, powers=powers, counts=old.counts.plus(steps=1))

    # swivels

    def _released(self, state: RopeState) -> RopeState:
        """Swivels whose release time has come begin to stick or slip."""
        swivels = list(state.swivels)
        for side, swivel in enumerate((self.scene.left, self.scene.right)):
            due = swivel.mode != "locked" and state.motion.t >= swivel.release_time
            if due and state.swivels[side].phase is Phase.LOCKED:
                swivels[side] = state.swivels[side]._replace(phase=Phase.STICK)
        if swivels == list(state.swivels):
            return state
        state = replace(state, swivels=(swivels[0], swivels[1]))
        return self._switched(state) if self._excess(self._system_of(state), state.motion) >= 0 else state

    def _excess(self, system: RopeSystem, motion: Motion) -> float:
        """Event function of both swivels: negative while each may stay in its phase."""
        return max(self._excess_of(side, system, motion) for side in (0, 1))

    def _excess_of(self, side: int, system: RopeSystem, motion: Motion) -> float:
        ends, node = _ends(system), -side
        state = ends.states[side]
        if state.phase is Phase.LOCKED or (state.phase is Phase.SLIP and ends.swivels[side].mode == "free"):
            return -np.inf
        if state.phase is Phase.STICK:
            return abs(ends.moment(side, motion.reaction)) - ends.friction(side, motion.reaction, kinetic=False)
        rate = ends.relative(side, motion.t, motion.q[node, ANGLE], motion.v[node, ANGLE])[1]
        return -state.sign * rate

    def _switching_instant(
        self, system: RopeSystem, state: RopeState, result: StepResult[Assessment]
    ) -> float | None:
        """Length of the step that ends where a swivel must change its phase; None when none must."""
        assert result.motion is not None
        if self._excess(system, result.motion) < 0:
            return None

        def excess(h: float) -> float:
            motion = self._trial(system, state.motion, h).motion
            return np.inf if motion is None else self._excess(system, motion)

        h = result.motion.t - state.motion.t
        at_start = self._excess(system, state.motion)
        if at_start >= 0:  # a slip that has just begun has no rate yet
            at_start = -1e-12
        return locate(excess, 0.0, h, at_start, max(excess(h), 0.0), EVENT_WIDTH)

    def _switched(self, state: RopeState) -> RopeState:
        """Swivels that cannot stay in their phase change it, and the motion restarts consistently."""
        system, motion, swivels = self._system_of(state), state.motion, list(state.swivels)
        changed = 0
        for side in (0, 1):
            if self._excess_of(side, system, motion) < 0:
                continue
            changed += 1
            swivels[side] = self._next_phase(side, replace(state, swivels=(swivels[0], swivels[1])))
            log.debug("t = %.9f s: %s swivel: %s", motion.t, ("left", "right")[side], swivels[side])
        state = replace(
            state, swivels=(swivels[0], swivels[1]), counts=state.counts.plus(swivel_events=changed)
        )
        return self._restarted(state)

    def _next_phase(self, side: int, state: RopeState) -> SwivelState:
        """What a swivel that cannot stay in its phase does next: stick if its friction can hold, else slip."""
        now, motion = state.swivels[side], state.motion
        if now.phase is Phase.SLIP:
            angle = _ends(self._system_of(state)).relative(side, motion.t, motion.q[-side, ANGLE], 0.0)[0]
            now = SwivelState(Phase.STICK, angle, 0.0)
            state = self._restarted(
                replace(state, swivels=(now, state.swivels[1]) if side == 0 else (state.swivels[0], now))
            )
            if self._excess_of(side, self._system_of(state), state.motion) < 0:
                return now
        return SwivelState(Phase.SLIP, now.angle, -float(np.sign(state.motion.reaction[-side, ANGLE])))

    def _restarted(self, state: RopeState) -> RopeState:
        m = state.motion
        system = self._system_of(state)
        motion, assessment = restart(system, m.t, m.q, m.v, m.reaction)
        return replace(state, motion=motion, powers=_powers(system, motion, assessment))

    # mesh and frame

    def _transformed_if_due(self, state: RopeState) -> RopeState:
        """The state on the transformed mesh when the loop has travelled far enough."""
        while direction := transformation_due(state.partition, self._bottom(state.paths, state.motion.t) + 1e-9):
            state = self._on_partition(state, transformed(state.partition, direction))
        return state

    def _on_partition(self, state: RopeState, new: Partition) -> RopeState:
        old_s = np.concatenate(([0.0], np.cumsum(state.partition.lengths)))
        new_s = np.concatenate(([0.0], np.cumsum(new.lengths)))
        m = state.motion
        carried = {name: transferred(getattr(m, name), old_s, new_s) for name in ("q", "v", "a", "b", "a_rate")}
        reaction = np.zeros_like(m.reaction)
        reaction[[0, -1]] = m.reaction[[0, -1]]
        moved = replace(state, partition=new, motion=replace(m, **carried, reaction=reaction))
        moved = self._booked(moved, state.ledger)
        log.debug(
            "t = %.6f s: transformation, kinetic energy %+.3g J, potential %+.3g J",
            m.t,
            moved.ledger.last_transformation_kinetic,
            moved.ledger.last_transformation_potential,
        )
        return replace(moved, counts=moved.counts.plus(transformations=1))

    def _booked(self, state: RopeState, before: Ledger) -> RopeState:
        """A changed representation with its energy change in the ledger."""
        m, system = state.motion, self._system_of(state)
        assessment = system.assess(m.t, m.q, m.v, m.a, m.reaction)
        after = _with_energies(before, assessment.balance)
        kinetic, total = after.kinetic - before.kinetic, after.total - before.total
        ledger = replace(
            after,
            transformations=before.transformations + total,
            last_transformation_kinetic=kinetic,
            last_transformation_potential=total - kinetic,
        )
        return replace(state, ledger=ledger)

    def _with_good_pole(self, state: RopeState) -> RopeState:
        """Theta expressed in a frame whose singularity is far from every tangent of the rope."""
        d = state.motion.q[:, SLOPE]
        t = d / np.linalg.norm(d, axis=1)[:, None]
        if pole_margin(state.pole, t) >= POLE_MARGIN:
            return state
        old, new, m = state.pole, best_pole(t), state.motion
        if pole_margin(new, t) <= pole_margin(old, t):
            return state
        angle = pole_change_angle(old, new, t)
        q, v = m.q.copy(), m.v.copy()
        q[:, ANGLE] += angle
        rates = [smallest_rotation_rate(p, d.T, m.v[:, SLOPE].T) for p in (old, new)]
        v[:, ANGLE] += rates[0] - rates[1]
        log.info("t = %.6f s: the frame's pole moves from %s to %s", m.t, old, new)
        moved = replace(
            state,
            pole=new,
            offsets=(state.offsets[0] + float(angle[0]), state.offsets[1] + float(angle[-1])),
            motion=replace(m, q=q, v=v),
            counts=state.counts.plus(pole_changes=1),
        )
        return self._booked(self._restarted(moved), state.ledger)

    def _with_loop_yaw(self, state: RopeState) -> RopeState:
        yaw = loop_bottom(state.motion.q, state.partition.lengths).yaw
        turns = round((state.loop_yaw - yaw) / (2 * math.pi))
        return replace(state, loop_yaw=yaw + 2 * math.pi * turns)

    # plumbing

    def _accept(self, state: RopeState) -> None:
        self._state, self._system = state, None

    def _system_of(self, state: RopeState) -> RopeSystem:
        scene = self.scene
        ends = HangingEnds(self.points, state.paths, (scene.left, scene.right), state.swivels, state.offsets)
        node_mass = np.zeros((state.partition.lengths.size + 1, 7))
        node_mass[[0, -1], ANGLE] = scene.left.inertia, scene.right.inertia
        P = parameter_vector(scene.rope, scene.layout.gravity, state.pole)
        return RopeSystem(self.kernels, state.partition.lengths, P, ends, node_mass)


def _ends(system: RopeSystem) -> HangingEnds:
    assert isinstance(system.boundary, HangingEnds)
    return system.boundary


def _with_energies(ledger: Ledger, balance: dict[str, float]) -> Ledger:
    strain = balance["axial"] + balance["coupling"] + balance["torsion"] + balance["bending"]
    kinetic = balance["kinetic"] + balance["spin"]
    return replace(ledger, kinetic=kinetic, strain=strain, gravity=balance["gravity"])


def _powers(system: RopeSystem, motion: Motion, assessment: Assessment) -> Powers:
    ends, at_ends, at_swivels = _ends(system), 0.0, 0.0
    for side in (0, 1):
        force, velocity = motion.reaction[-side, POSITION], motion.v[-side, POSITION]
        moment = ends.moment(side, motion.reaction)
        rate = ends.relative(side, motion.t, 0.0, motion.v[-side, ANGLE])[1]
        at_ends += float(force @ velocity) + moment * (motion.v[-side, ANGLE] - rate)
        if ends.states[side].phase is Phase.SLIP:
            at_swivels -= moment * rate
    balance = assessment.balance
    return Powers(at_ends, balance["damping_power"], at_swivels, balance["nonconservative_power"])


