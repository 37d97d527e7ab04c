"""Equations of motion, trial steps and bookkeeping of a scene, for any state of the rope."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from rope_model.numerics import generalized_alpha as alpha
from rope_model.parameters import Scene
from rope_model.physics.accuracy import (
    BOUNDED_STEP_ERROR,
    add_errors,
    effective_tolerance,
    step_error,
    step_limits,
)
from rope_model.physics.contact_error import add_contact
from rope_model.physics.element import parameters
from rope_model.physics.elementary import sum_of
from rope_model.physics.energy_balance import after_step as account_of_step
from rope_model.physics.energy_balance import with_energies
from rope_model.physics.node import ANGLE, POSITION, SLOPE
from rope_model.physics.shaft import KINDS
from rope_model.rules.audit import (
    NO_LOAD,
    Audit,
    Load,
    after_interval,
    after_step,
    axial_share,
    end_load,
)
from rope_model.rules.end_paths import END_NODE, EndPath
from rope_model.rules.fidelity import flexible
from rope_model.rules.generalized_alpha import Coefficients, Motion, local_error
from rope_model.rules.mesh_pattern import NO_DIVIDERS
from rope_model.rules.point_forces import NO_FORCES, PointForces, nodal_forces
from rope_model.rules.state import EnergyBalance, Powers, RopeState
from rope_model.rules.swivel_phases import Phase
from rope_model.simulation.contact.obstacles import find_obstacles
from rope_model.simulation.contact.self_contact import SelfContactSystem
from rope_model.simulation.ends.ends import HangingEnds, end_strain, nominal_points
from rope_model.simulation.mesh.partition import mesh_dividers
from rope_model.simulation.rope_kernels import KernelCache
from rope_model.simulation.rope_system import Evaluation, RopeSystem, air_parameters
from rope_model.simulation.scene_kernels import acting_along


@dataclass(frozen=True)
class RopeModel:
    """Scene with its kernels; immutable to callers, it keeps the latest system as the start of the next."""

    scene: Scene
    kernels: KernelCache
    forces: PointForces = NO_FORCES
    _latest: list[tuple[tuple[Any, ...], RopeSystem]] = field(
        default_factory=list, init=False, compare=False
    )

    def system(self, state: RopeState) -> RopeSystem:
        """Return the equations of motion of ``state``: its mesh, swivel phases, end paths and frame."""
        rubs = state.hysteresis.size > 0
        scene, key = self.scene, (state.partition, state.swivels, state.fidelity, rubs)
        if self._latest and all(
            one is other for one, other in zip(self._latest[0][0], key, strict=True)
        ):
            latest = self._latest[0][1]
            ends = ends_of(latest)
            alike = ends.paths is state.paths and ends.offsets is state.offsets
            system = (latest if alike else latest.with_boundary(self.ends(state))).with_reference(
                state.motion.q, state.hysteresis, state.director
            )
        else:
            node_mass = np.zeros((state.partition.lengths.size + 1, 7))
            node_mass[[0, -1], ANGLE] = scene.left.inertia, scene.right.inertia
            rope_parameters, air = (
                np.array(parameters(scene.rope, scene.layout.gravity)),
                air_parameters(scene),
            )
            fidelity, obstacles = flexible(state.fidelity), find_obstacles(scene)
            along = acting_along(scene, fidelity, rubs)
            make_system = (
                partial(SelfContactSystem, scene)
                if scene.shaft.contact.rope_stiffness > 0
                else RopeSystem
            )
            system = make_system(
                self.kernels.of(fidelity, along),
                state.partition.lengths,
                np.concatenate((rope_parameters, air)),
                self.ends(state),
                state.motion.q,
                node_mass,
                obstacles,
                partial(
                    self.kernels.of, fidelity, (*along, *obstacles.kinds) if obstacles else along
                ),
                scene.rope,
                state.hysteresis,
                state.director,
            )
        self._latest[:] = [(key, system)]
        return self.with_host_forces(system, state.motion.t)

    def with_host_forces(self, system: RopeSystem, t: float) -> RopeSystem:
        """Return ``system`` with the forces that act at ``t``."""
        return (
            system.with_forces(nodal_forces(self.forces, system.lengths, t))
            if self.forces.s.size
            else system
        )

    def ends(self, state: RopeState) -> HangingEnds:
        """Return the boundary at the ends of ``state``."""
        scene = self.scene
        points = nominal_points(scene.layout.spacing)
        return HangingEnds(
            points, state.paths, (scene.left, scene.right), state.swivels, state.offsets
        )

    @cached_property
    def method(self) -> Coefficients:
        """Coefficients of the integration method."""
        return Coefficients(self.scene.solver.rho_inf)

    def relative_error(self, old: RopeState, result: alpha.StepResult[Evaluation]) -> float:
        """Return the local error of a trial step over the allowed error; infinite if Newton's method failed."""
        if result.motion is None:
            return math.inf
        s, h = self.bottom_s(old.paths, old.motion.t), result.motion.h
        constant = local_error(self.method, 1.0, 1.0)
        limits = step_limits(self.scene, old.errors, s, relative_end_speed(old.motion), constant)
        assert result.a_rate is not None
        rates = (
            abs(end_strain(self.scene, result.motion.q, result.a_rate, side)) for side in (0, 1)
        )
        strain = local_error(self.method, h, h * max(rates))
        return float(step_error(limits, h, result.error, strain))

    def trial(self, system: RopeSystem, old: Motion, h: float) -> alpha.StepResult[Evaluation]:
        """Take a step that is not accepted yet."""
        solver = self.scene.solver
        tolerance = float(
            effective_tolerance(solver.newton_tolerance, solver.work_max, BOUNDED_STEP_ERROR)
        )
        return alpha.step(self.with_host_forces(system, old.t + h), old, h, self.method, tolerance)

    def bottom_s(self, paths: tuple[EndPath, EndPath], t: float) -> float:
        """Return the arc length (m) of the loop's lowest point, from the ends' heights alone."""
        return float(0.5 * (self.scene.rope.length + paths[0].height(t) - paths[1].height(t)))

    def dividers(self, paths: tuple[EndPath, EndPath], t: float) -> Sequence[float]:
        """Return the arc lengths of the dividers along the legs, from the ends' heights: mesh_fit.divider_positions."""
        return (
            mesh_dividers(self.scene, paths[0].height(t), paths[1].height(t))
            if self._has_dividers
            else NO_DIVIDERS
        )

    @cached_property
    def _has_dividers(self) -> bool:
        """True if some divider may press a leg, at whatever heights."""
        return mesh_dividers(self.scene, 0.0, 0.0) != NO_DIVIDERS

    def restart(self, state: RopeState) -> RopeState:
        """Return the state with consistent accelerations and no history."""
        m = state.motion
        system = self.system(state)
        motion, _ = alpha.restart(system, m.t, m.q, m.v, m.reaction)
        audit = restart_audit(state.audit, load_on(ends_of(system), motion, system))
        return state._replace(motion=motion, powers=powers(system, motion), audit=audit)

    def commit(
        self, old: RopeState, system: RopeSystem, result: alpha.StepResult[Evaluation]
    ) -> RopeState:
        """Return the state after an accepted step, with energies and work; angles count along its own curve."""
        motion, evaluation = result.motion, result.evaluation
        assert motion is not None
        assert evaluation is not None
        after, before, h = powers(system, motion), old.powers, motion.t - old.motion.t
        s, force = self.bottom_s(old.paths, old.motion.t), largest_end_force(motion)
        strain_tt = [
            end_strain(self.scene, motion.q, motion.v - old.motion.v, side) / h for side in (0, 1)
        ]
        constant, speed = local_error(self.method, 1.0, 1.0), relative_end_speed(old.motion)
        errors = add_errors(
            self.scene, old.errors, s, speed, h, constant, strain_tt, result.error, force
        )
        # the material's dissipation follows from the strains' differences over the step: the rates at its ends contain
        # the integrator's own oscillation, whose square does not average out
        middle, rate = 0.5 * (old.motion.q + motion.q), (motion.q - old.motion.q) / h
        halfway = self.with_host_forces(system, old.motion.t + 0.5 * h)
        losses, update = halfway.losses(middle, rate), system.update_hysteresis(motion.q)
        energy, external = (
            energies(old.energy_balance, evaluation.balance),
            system.external_sums(middle, rate),
        )
        energy = account_of_step(
            energy, h, before, after, losses, update.dissipated, external["given_to_air"]
        )
        pressures = [external[kind] for kind in (*KINDS, "rope")]
        contact = add_contact(self.scene, old.contact, h, pressures, system.longest_near(middle))
        state = old._replace(
            motion=motion,
            hysteresis=update.z,
            energy_balance=energy,
            errors=errors,
            powers=after,
            contact=contact,
        )
        return self._audit_step(old.motion, update_angles(system, state), system)

    def _audit_step(self, old: Motion, state: RopeState, system: RopeSystem) -> RopeState:
        """Return ``state`` with the impulse of a time step from ``old``, for the audit of the communication step."""
        m, method, (left, right) = state.motion, self.method, old.reaction[[0, -1], 1].tolist()
        forces, h = m.reaction[[0, -1], 1].tolist(), m.t - old.t
        audit = after_step(
            state.audit,
            method,
            h,
            alpha.recentring(method, m.h, old.h),
            load_on(self.ends(state), m, self.with_host_forces(system, m.t)),
            max(map(abs, forces)),
            max(abs(forces[0] - left), abs(forces[1] - right)),
            axial_share(self.scene.rope, self.bottom_s(state.paths, m.t), h),
        )
        return state._replace(audit=audit)

    def begin_audit(self, state: RopeState) -> RopeState:
        """Return ``state`` as the reference for the momentum of the next communication step."""
        if state.fidelity == "rigid":
            return state
        m, system = state.motion, self.system(state)
        audit = restart_audit(state.audit, load_on(ends_of(system), m, system))
        return state._replace(
            audit=audit._replace(sums=system.momentum(m.q, m.v), impulse=NO_LOAD, interval=0.0)
        )

    def audit_interval(self, before: RopeState, state: RopeState) -> RopeState:
        """Return ``state`` with the audit of a communication step from ``before``: momentum against loads."""
        if state.fidelity == "rigid":
            return state
        m, scene = state.motion, self.scene
        audit = after_interval(
            state.audit,
            m.t - before.motion.t,
            scene.rope.mass_per_length * scene.rope.length,
            scene.layout.gravity,
            self.system(state).momentum(m.q, m.v),
            (0.5 * (m.q[0, POSITION] + m.q[-1, POSITION])).tolist(),
            state.energy_balance.residual - before.energy_balance.residual,
            float(np.square(m.q[1:, SLOPE] - m.q[:-1, SLOPE]).sum(axis=1).max()),
        )
        return state._replace(audit=audit)


def largest_end_force(motion: Motion) -> float:
    """Return the largest component (N) of the forces at the ends."""
    return float(np.abs(motion.reaction[[0, -1], POSITION]).max())


def update_angles(system: RopeSystem, state: RopeState) -> RopeState:
    """Return ``state``, whose angles count from the reference of ``system``, as one that is its own reference.

    The rate of theta is then the spin.  b differs from a by events within a step: both change alike.
    """
    m = state.motion
    gained = system.transport(m.q, m.v, m.a)
    q, v, a, b = fields = [x.copy() for x in (m.q, m.v, m.a, m.b)]
    for x, more in zip(fields, (*gained, gained[2]), strict=True):
        x[:, ANGLE] += more
    offsets = state.offsets[0], state.offsets[1] + float(gained[0, -1])
    motion = Motion(m.t, q, v, a, b, m.a_rate, m.h, m.reaction)
    return state._replace(motion=motion, offsets=offsets, director=system.carried_director(m.q))


def ends_of(system: RopeSystem) -> HangingEnds:
    """Return the ends of a rope that hangs between conveyances."""
    assert isinstance(system.boundary, HangingEnds)
    return system.boundary


def load_on(ends: HangingEnds, motion: Motion, system: RopeSystem) -> Load:
    """Return the loads on the rope by the conveyances at its ends, by touched bodies, and by the air; audit.Load."""
    external, pulls = system.external_sums(motion.q, motion.v), motion.reaction[[0, -1], 1].tolist()
    loads = [tuple(external[name] for name in names) for names in (_CONTACT_LOAD, _AIR_LOAD)]
    for side, node in enumerate(END_NODE):
        q, R = motion.q[node].tolist(), motion.reaction[node].tolist()
        loads.append(end_load(q, R, ends.moment(side, motion.q, motion.reaction)))
    total = tuple(sum_of(parts) for parts in zip(*loads, strict=True))
    if system.kernels.fidelity == "planar":  # a planar rope does not feel forces across its plane
        return total[0], total[1], 0.0, 0.0, 0.0, total[5], *pulls
    return *total, *pulls


_CONTACT_LOAD, _AIR_LOAD = (
    tuple(f"{of}_{name}" for name in ("fx", "fy", "fz", "mx", "my", "mz"))
    for of in ("contact", "air")
)


def restart_audit(audit: Audit, load: Load) -> Audit:
    """Return ``audit`` for accelerations that begin anew, as after an event."""
    return audit._replace(load=load, auxiliary=load, rate=NO_LOAD)


def energies(energy_balance: EnergyBalance, balance: dict[str, float]) -> EnergyBalance:
    """Return the energy balance with the energies (J) of a state, from its element balance."""
    account: EnergyBalance = with_energies(
        energy_balance, tuple(balance.values()), balance["contact"]
    )
    return account


def powers(system: RopeSystem, motion: Motion) -> Powers:
    """Return the powers at the ends and in the swivels at this instant, W."""
    ends, at_ends, at_swivels = ends_of(system), 0.0, 0.0
    for side, node in enumerate(END_NODE):
        force, velocity = motion.reaction[node, POSITION], motion.v[node, POSITION]
        moment = ends.moment(side, motion.q, motion.reaction)
        at_ends += float(force @ velocity)
        if ends.swivels[side].attachment == "clamped":
            at_ends += float(motion.reaction[node, SLOPE] @ motion.v[node, SLOPE])
        spin = float(motion.v[node, ANGLE])
        if ends.states[side].phase is Phase.SLIP:
            rate = float(ends.relative(side, motion.t, 0.0, spin)[1])
            at_swivels -= moment * rate
            spin -= rate
        at_ends += moment * spin
    return Powers(at_ends, at_swivels)


def relative_end_speed(motion: Motion) -> float:
    """Return the vertical speed (m/s) of the left end against the right one."""
    return float(motion.v[0, 1] - motion.v[-1, 1])
