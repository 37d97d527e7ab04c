"""Equations of motion of the rope on one mesh: physics.element chained by numerics.block_chain.

A ``RopeSystem`` is immutable: mesh, material, the frame's reference and the boundary conditions are fixed in it.  A
change of any of them makes a new one, which is cheap, because the kernels are shared.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from rope_model.arrays import Array
from rope_model.numerics.coupled_newton import Coupled, Iterate, newton
from rope_model.numerics.generalized_alpha import Solution
from rope_model.numerics.newton import report
from rope_model.parameters import Rope, Scene
from rope_model.physics.air import air_coefficients
from rope_model.physics.air_element import AIR_BALANCE, AIR_SIZE, COEFFICIENTS_SIZE
from rope_model.physics.contact import CONTACT_MARGIN, largest_motion
from rope_model.physics.contact_element import CONTACT_BALANCE
from rope_model.physics.element import BALANCE, NODE_DOF, PARAMETERS
from rope_model.physics.initial_curvature import START, carried_director
from rope_model.physics.node import ANGLE, POSITION, SLOPE
from rope_model.physics.point_forces import point_load
from rope_model.physics.wire_element import HISTORY_SIZE, TANGENT_SIZE
from rope_model.rules.newton import GOOD, HUGE, KINKED, SMALL, SMOOTH, UNKNOWN
from rope_model.rules.state import NO_HYSTERESIS
from rope_model.simulation.curvature import Director, curved_reference, is_curved
from rope_model.simulation.rope_kernels import RopeKernels
from rope_model.simulation.wires import HysteresisUpdate, history, latest_tangent, update_hysteresis

#: matrix (elements, bodies): true if an element may touch a body
Near = NDArray[np.bool_]

_NOTHING = np.zeros((1, 1), dtype=bool)
_NO_EXTERNAL_SUMS = dict.fromkeys((*AIR_BALANCE, *CONTACT_BALANCE, "rope"), 0.0)
_Solver = Callable[[Array], Array]


def air_parameters(scene: Scene) -> Array:
    """Return the element's parameters for air, with conveyances at rest; empty without air."""
    c = air_coefficients(scene.shaft.air, scene.rope.diameter, scene.layout.spacing)
    return np.array(
        [c.factor, *c.velocity, *c[2:], *(AIR_SIZE - COEFFICIENTS_SIZE) * [0.0]] if c.factor else []
    )


class Obstacles(Protocol):
    """Bodies that a rope may touch: simulation.contact.obstacles."""

    @property
    def scene(self) -> Scene:
        """Return the scene with the bodies."""

    def numbers(self, q: Array, v: Array) -> Array:
        """Return the entries of P beyond element.PARAMETERS, for physics.contact_element."""

    def distances(self, q: Array, lengths: Array) -> Array:
        """Return the least distance (m) of each element from each body (elements, bodies)."""


#: rounds in which the friction of a swivel whose end may lean settles, and its relative error then
FRICTION_ITERATIONS = 20
FRICTION_ERROR = 1e-9


class Boundary(Protocol):
    """Boundary conditions and loads of the ends; arrays of shape (nodes, 7)."""

    def free(self, nodes: int) -> NDArray[np.bool_]:
        """Return true where a degree of freedom is free."""

    def prescribed_motion(self, t: float, nodes: int) -> Array:
        """Return q, v, a (3, nodes, 7) with the prescribed entries filled in."""

    def load(self, nodes: int) -> Array:
        """Return the dead loads at the nodes."""

    def friction_load(self, nodes: int) -> Array:
        """Return the loads per newton of the node's own vertical reaction, where it pulls upwards: friction."""

    def slanted_friction(self, q: Array, reaction: Array) -> Array | None:
        """Return the friction at these tensions of swivels whose ends may lean (nodes, 7); None if none slips."""


class Losses(NamedTuple):
    """Powers of material damping, of the coupling without energy, of contact losses, and of moving bodies, W."""

    damping: float
    nonconservative: float
    contact: float = 0.0
    moved: float = 0.0


@dataclass(frozen=True)
class Evaluation:
    """Residual (nodes, 7), reactions where prescribed (N, N m), and sums of the elements by name (J, W, N)."""

    reaction: Array
    balance: dict[str, float]


class RopeSystem:
    """Equations of motion for numerics.generalized_alpha and for statics.

    ``reference`` (nodes, 7) is the state from which the frame is counted; see physics.frame.  ``z`` is the hysteresis
    of the wires of ``rope`` where they rub; ``rope`` also has the permanent curvature.  ``P`` are the element's
    parameters, then those of the air; ``contact_kernels`` makes the kernels of a rope that touches ``obstacles``.
    """

    def __init__(
        self,
        kernels: RopeKernels,
        lengths: Array,
        P: Array,
        boundary: Boundary,
        reference: Array,
        node_mass: Array | None = None,
        obstacles: Obstacles | None = None,
        contact_kernels: Callable[[], RopeKernels] | None = None,
        rope: Rope | None = None,
        z: Array = NO_HYSTERESIS,
        director: Director = START,
    ) -> None:
        nodes = lengths.size + 1
        self.obstacles, self._contact_kernels = obstacles, contact_kernels
        # the rope at the last search for bodies, and its distance from them, m
        self._last_search: list[tuple[Array, float]] = []
        # weights of a node's coordinates in largest_motion
        longest = np.maximum(np.append(lengths, 0.0), np.append(0.0, lengths))
        units = np.eye(NODE_DOF)[:, :, None].repeat(nodes, axis=2)
        self._motion = np.array(
            [largest_motion(longest, unit, np.zeros_like(unit)) for unit in units]
        ).T
        self.kernels, self.lengths, self.P, self.boundary = kernels, lengths, P, boundary
        self.reference, self.z, self._rope = reference, z, rope
        self.director = director
        self.free = boundary.free(nodes)
        self.load = self._dead_load = boundary.load(nodes)
        self.host_forces: Array | None = None
        self.node_mass = np.zeros((nodes, NODE_DOF)) if node_mass is None else node_mass
        self._free = self.free.astype(float)
        self._scale = np.ones(NODE_DOF)
        self._scale[SLOPE] = lengths.min()
        self._loads = self.load, boundary.friction_load(nodes), self.node_mass
        self._refer()

    def _refer(self) -> None:
        self.frames = self.kernels.reference(self.reference, self.lengths)[0]
        if self._rope is not None and is_curved(self._rope, self.kernels.fidelity):
            self.frames = np.hstack(
                (
                    self.frames,
                    curved_reference(self._rope, self.reference, self.lengths, self.director),
                )
            )
        if self._rope is not None and self.z.size:
            self.frames = np.hstack(
                (self.frames, np.zeros((self.lengths.size, HISTORY_SIZE + TANGENT_SIZE)))
            )
            strains = self.strains(self.reference, np.zeros_like(self.reference))
            self._history = history(
                self._rope, self._sections_of(self.reference), self.lengths, self.z, strains
            )
            self.frames[:, -HISTORY_SIZE - TANGENT_SIZE : -TANGENT_SIZE] = self._history
        self._constants = self.lengths, self.frames, *self._loads

    def with_boundary(self, boundary: Boundary) -> RopeSystem:
        """Return this system with other motions of the ends, held in the same way."""
        other = self._alike()
        other.boundary = boundary
        return other

    def with_forces(self, forces: Array) -> RopeSystem:
        """Return this system with these ``forces`` on its nodes (nodes, 7), and no others of the kind."""
        other = self._alike()
        other.host_forces, other.load = forces, self._dead_load + forces
        other._loads = other.load, *self._loads[1:]
        other._constants = self.lengths, self.frames, *other._loads
        return other

    def carried_director(self, q: Array) -> Director:
        """Return e1 of the permanent curvature at the left end as the rope moves from the reference to ``q``."""
        return carried_director(
            self.director, self.reference[0, SLOPE].tolist(), q[0, SLOPE].tolist()
        )

    def with_reference(
        self, q: Array, z: Array = NO_HYSTERESIS, director: Director | None = None
    ) -> RopeSystem:
        """Return this system with the frame counted from ``q``, where its wires have ``z``.

        ``director`` is e1 of the permanent curvature at the left end; None if the rope moves there from the reference.
        """
        if q is self.reference and z is self.z and director in (None, self.director):
            return self
        other = self._alike()
        other.director = self.carried_director(q) if director is None else director
        other.reference, other.z = q, z
        other._refer()
        return other

    def _alike(self) -> RopeSystem:
        """Return a shallow copy; faster than copy.copy."""
        other = object.__new__(type(self))
        vars(other).update(vars(self))
        return other

    def transport(self, q: Array, v: Array, a: Array) -> Array:
        """Return the increase of theta, theta_t and theta_tt (3, nodes) when ``q`` becomes the reference.

        The frame of the left end stays, and the sections stay where they are.
        """
        gained = np.zeros((3, q.shape[0]))
        gained[:, 1:] = self.kernels.transport(q, v, a, self.lengths, self.frames)[0].T
        gained[0] = gained[0].cumsum()
        return gained

    def update_hysteresis(self, q: Array) -> HysteresisUpdate:
        """Return the update of the hysteresis on the way to ``q``."""
        if not self.z.size:
            return HysteresisUpdate(NO_HYSTERESIS, 0.0)
        return update_hysteresis(self._history, self._sections_of(q), self.lengths)

    def _sections_of(self, q: Array) -> Array:
        """Return ``q`` for the wires: theta is 0 if the fidelity computes no torsion, whatever the ends prescribe."""
        return (
            q
            if self.kernels.fidelity == "torsional"
            else np.where(np.arange(NODE_DOF) == ANGLE, 0.0, q)
        )

    def frame_turn(self, q: Array) -> Array:
        """Return the increase of theta (nodes,), rad, when ``q`` becomes the reference."""
        zeros = np.zeros_like(q)
        return np.asarray(self.transport(q, zeros, zeros)[0])

    def prescribed_motion(self, t: float) -> Array:
        return self.boundary.prescribed_motion(t, self.lengths.size + 1)

    @property
    def smooth(self) -> bool:
        """True if accelerations are likely to continue at their rate: not if wires begin to stick and to slide."""
        return not self.z.size

    def solve(
        self,
        q: Array,
        v: Array,
        a: Array,
        reaction: Array,
        c: Array,
        tolerance: float,
        before: Array | None = None,
    ) -> Solution[Evaluation]:
        """Solve R = 0 by Newton's method; repeat with the bodies that the solution touches until none is new."""
        near, x = self._near(q, CONTACT_MARGIN), Iterate(q, v, a, reaction)
        while True:
            solution = self._newton(near, x, c, tolerance, before)
            more = self._near(solution.q, 0.0) if solution.newton.converged else _NOTHING
            if not more.any() or (near.any() and not (more & ~near).any()):
                return solution
            x = Iterate(solution.q, solution.v, solution.a, solution.evaluation.reaction)
            near, before = near | more, None

    def _newton(
        self, near: Near, x: Iterate, c: Array, tolerance: float, before: Array | None
    ) -> Solution[Evaluation]:
        """Solve with contact of the bodies ``near`` only."""
        if self.z.size:
            return self._iterate(near, x, c, tolerance)
        kernels, constants, P = self._with_bodies(near, x.q, x.v)
        friction = self.boundary.slanted_friction(x.q, x.R)
        if friction is not None:
            return self._rubbed(near, x, c, tolerance, friction)
        # the friction of a swivel depends on the reaction, which the tangent leaves out
        good = (
            before is not None
            and tolerance <= SMALL
            and not near.any()
            and not self._constants[3].any()
        )
        method = (
            self._free,
            P,
            c,
            self._scale,
            tolerance,
            x.q if before is None else before,
            GOOD if good else UNKNOWN,
        )
        q, v, a, reaction, sums, progress = kernels.solve(*x, *constants, *method)
        return Solution(
            q, v, a, self._evaluation(v, reaction, kernels.balance, sums), report(progress.tolist())
        )

    def _rubbed(
        self, near: Near, x: Iterate, c: Array, tolerance: float, friction: Array
    ) -> Solution[Evaluation]:
        """Solve with the ``friction`` of swivels whose ends may lean, until it is that of the solution's tensions."""
        kernels, constants, P = self._with_bodies(near, x.q, x.v)
        method = self._free, P, c, self._scale, tolerance, x.q, UNKNOWN
        for _ in range(FRICTION_ITERATIONS):
            loaded = self._with_friction(constants, friction)
            q, v, a, reaction, sums, progress = kernels.solve(*x, *loaded, *method)
            newton_report = report(progress.tolist())
            after = self.boundary.slanted_friction(q, reaction)
            assert after is not None
            if (
                not newton_report.converged
                or np.abs(after - friction).max() <= FRICTION_ERROR * np.abs(after).max()
            ):
                break
            x, friction = Iterate(q, v, a, reaction), after
        return Solution(
            q, v, a, self._evaluation(v, reaction, kernels.balance, sums), newton_report
        )

    @staticmethod
    def _with_friction(constants: tuple[Array, ...], friction: Array | None) -> tuple[Array, ...]:
        """Return ``constants`` with this ``friction`` in the load."""
        lengths, frames, load, *others = constants
        return constants if friction is None else (lengths, frames, load + friction, *others)

    def _iterate(self, near: Near, x: Iterate, c: Array, tolerance: float) -> Solution[Evaluation]:
        """Solve where a tangent depends on the previous one (wires), or where elements far apart are coupled."""
        kernels, constants, P = self._with_bodies(near, x.q, x.v)
        latest = np.zeros((self.lengths.size, TANGENT_SIZE))
        solve: _Solver

        def evaluated(q: Array, v: Array, a: Array, known: Array) -> Evaluation:
            loaded = self._with_friction(constants, self.boundary.slanted_friction(q, known))
            R, sums = kernels.evaluate(q, v, a, known, *loaded, P)
            return self._with_touches(self._evaluation(v, R, kernels.balance, sums), q, v)

        def factorized(at: Iterate) -> _Solver:
            nonlocal latest, solve
            solve = self._solver(kernels, self._following(constants, latest), P, at, c)
            if self.z.size:
                latest = latest_tangent(
                    self._history, self._sections_of(at.q), self.lengths, latest
                )
            return solve

        def resolve(change: Array) -> Array:
            without = evaluated(x.q, x.v, x.a - change, x.R).reaction
            return np.asarray(c[2] * self._free * solve(without - x.R))

        x, newton_report = newton(
            Coupled(
                factorized,
                lambda at: self._coupling(at, c),
                lambda *at: evaluated(*at).reaction,
                self.norm,
            ),
            x._replace(R=evaluated(*x).reaction),
            c,
            tolerance,
            *((KINKED, HUGE) if self.z.size else (SMOOTH, UNKNOWN)),
        )
        solution = Solution(x.q, x.v, x.a, evaluated(*x), newton_report)
        return replace(solution, resolve=resolve) if self.z.size else solution

    def _following(self, constants: tuple[Array, ...], latest: Array) -> tuple[Array, ...]:
        """Return ``constants`` with the wires' latest tangents in the last columns of the frames."""
        lengths, frames, *loads = constants
        if self.z.size:
            frames, own = frames.copy(), self.frames.shape[1]
            frames[:, own - TANGENT_SIZE : own] = latest
        return lengths, frames, *loads

    def _solver(
        self, kernels: RopeKernels, constants: tuple[Array, ...], P: Array, at: Iterate, c: Array
    ) -> _Solver:
        """Return a solver of J x = -R with the chain's tangent J; the kernels take R as a load."""
        lengths, frames, load, friction_load, mass = constants
        known = kernels.evaluate(*at, *constants, P)[0]

        def solve(R: Array) -> Array:
            shifted = load + known - R
            x: Array = kernels.newton_step(
                *at, lengths, frames, shifted, friction_load, mass, self._free, P, c
            )[0]
            return x

        return solve

    def _coupling(self, at: Iterate, c: Array) -> _Solver | None:
        """Return the product with the tangent of forces between elements far apart, or None."""
        return None

    def _with_touches(self, evaluation: Evaluation, q: Array, v: Array) -> Evaluation:
        """Add the forces of the rope on itself to ``evaluation``; a rope that can touch itself overrides it."""
        return evaluation

    def newton_step(
        self, q: Array, v: Array, a: Array, reaction: Array, c: Array
    ) -> tuple[Array, Array]:
        kernels, constants, P = self._with_bodies(self._near(q, 0.0), q, v)
        loaded = self._with_friction(constants, self.boundary.slanted_friction(q, reaction))
        x, R = kernels.newton_step(q, v, a, reaction, *loaded, self._free, P, c)
        return x, R

    def evaluate(self, q: Array, v: Array, a: Array, reaction: Array) -> Evaluation:
        """Evaluate residual and balance; the kinetic energy includes concentrated masses."""
        kernels, constants, P = self._with_bodies(self._near(q, 0.0), q, v)
        loaded = self._with_friction(constants, self.boundary.slanted_friction(q, reaction))
        R, sums = kernels.evaluate(q, v, a, reaction, *loaded, P)
        return self._evaluation(v, R, kernels.balance, sums)

    def _evaluation(self, v: Array, R: Array, names: tuple[str, ...], sums: Array) -> Evaluation:
        balance = dict(zip(names, sums.tolist(), strict=True))
        balance.setdefault("contact", 0.0)
        balance["kinetic"] += 0.5 * float(np.vdot(self.node_mass, v * v))
        return Evaluation(R, balance)

    def external_sums(self, q: Array, v: Array) -> dict[str, float]:
        """Return the sums of bodies and air by name: contact_element.CONTACT_BALANCE, air.AIR_BALANCE, and "rope"."""
        kernels, constants, P = self._with_bodies(self._near(q, 0.0), q, v)
        external = (
            _NO_EXTERNAL_SUMS
            if self.host_forces is None
            else _NO_EXTERNAL_SUMS | _push(self.host_forces, q, v)
        )
        if len(kernels.balance) == len(BALANCE):
            return external
        zeros = np.zeros_like(q)
        sums = kernels.evaluate(q, v, zeros, zeros, *constants, P)[1].tolist()
        return external | {
            name: external.get(name, 0.0) + x for name, x in zip(kernels.balance, sums, strict=True)
        }

    def losses(self, q: Array, v: Array) -> Losses:
        """Return the powers that the rope and its contacts lose [W]."""
        kernels, constants, P = self._with_bodies(self._near(q, 0.0), q, v)
        losses = Losses(*kernels.losses(q, v, *constants[:2], P)[0].tolist())
        forces = self.host_forces
        return (
            losses
            if forces is None
            else losses._replace(moved=losses.moved + float(np.vdot(forces, v)))
        )

    def longest_near(self, q: Array) -> float:
        """Return the length of the longest element that may touch a body [m]; 0 for none."""
        near = self._near(q, 0.0)
        return float(self.lengths[near.any(axis=1)].max()) if near.any() else 0.0

    def _near(self, q: Array, margin: float) -> Near:
        """Return whether each element may touch each body after a move by ``margin`` (m) (elements, bodies)."""
        if self.obstacles is None:
            return _NOTHING
        if self._last_search:
            # a distant body stays distant while the rope has hardly moved
            before, gap = self._last_search[0]
            if (
                gap > margin
                and gap - (np.abs(q - before) * self._motion).sum(axis=1).max() > margin
            ):
                return _NOTHING
        distances = self.obstacles.distances(q, self.lengths)
        self._last_search[:] = [(q, float(distances.min()))]
        return distances < margin

    def _with_bodies(
        self, near: Near, q: Array, v: Array
    ) -> tuple[RopeKernels, tuple[Array, ...], Array]:
        """Return kernels, their constants and parameters, with or without bodies."""
        P = self._air_parameters(q, v)
        if self.obstacles is None or self._contact_kernels is None or not near.any():
            return self.kernels, self._constants, P
        lengths, frames, *loads = self._constants
        P = np.concatenate((P, self.obstacles.numbers(q, v)))
        return self._contact_kernels(), (lengths, np.hstack((frames, near)), *loads), P

    def _air_parameters(self, q: Array, v: Array) -> Array:
        """Return the element's parameters, in air with the conveyances at the rope's ends."""
        if self.P.size == len(PARAMETERS):
            return self.P
        P = self.P.copy()
        P[COEFFICIENTS_SIZE - AIR_SIZE :].reshape(2, 4)[:] = np.column_stack(
            (q[[0, -1], POSITION], v[[0, -1], 1])
        )
        return P

    def element_data(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Return frames (elements, entries) and parameters of the element, away from all bodies."""
        return self.frames, self._air_parameters(q, v)

    def strains(self, q: Array, v: Array) -> Array:
        """Return the strains (elements, 5) with the columns physics.element.STRAINS."""
        return self.kernels.strains(q, v, self.lengths, self.frames)[0]

    def momentum(self, q: Array, v: Array) -> Any:
        """Return physics.element.MOMENTUM (9,) with the spin of concentrated masses; ``q`` is the reference."""
        sums = self.kernels.momentum(q, v, self.lengths, self.P)[0]
        sums[3:6] += (self.node_mass[:, ANGLE] * v[:, ANGLE]) @ q[:, SLOPE]
        return tuple(sums.tolist())

    def norm(self, x: Array) -> float:
        return float((np.abs(x) * self._scale).max())


def _push(forces: Array, q: Array, v: Array) -> dict[str, float]:
    """Return the load of ``forces`` on the nodes (nodes, 7), and their power."""
    of_r, of_slope = (
        point_load(q[:, columns].T, forces[:, columns].T) for columns in (POSITION, SLOPE)
    )
    load = [
        float(x.sum())
        for x in (*of_r[:3], *(a + b for a, b in zip(of_r[3:], of_slope[3:], strict=True)))
    ]
    names = (
        "contact_fx",
        "contact_fy",
        "contact_fz",
        "contact_mx",
        "contact_my",
        "contact_mz",
        "contact_moved",
    )
    return dict(zip(names, (*load, float(np.vdot(forces, v))), strict=True))
