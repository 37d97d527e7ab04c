"""Contact between several ropes that hang side by side, each a BalanceRope with its own time steps.

Between two of them the law of physics.rope_contact holds.  Over a step of the host, from t to
t + h, forces act at points of both ropes, linear in time and opposite on the two: they cancel to
the bit.  Those at t are known from the step before; those at t + h, F, satisfy the law f where the
ropes are then:

    F = f(x(F)) ,    x: separations of the points and their rates, from advancing the ropes from t to t + h

Newton's method solves this for all ropes at once.  With the law's tangent K and the ropes'
compliance Y to such forces (BalanceRope.displacement) a correction is r - K dx, r = f - F, with
(1 + Y K) dx = Y r: by conjugate gradients, in which each rope responds separately.  Where every
rope takes one step of its own from t to t + h this is its integrator's step of all ropes as one
system.

The work of the springs and that of the other forces are accounted separately.  Energy that is
missing in the first was created by the steps.  A blow that one step cannot resolve creates much of
it: such a step is halved, repeatedly if need be.

Ropes at rest hang as if each was alone.  Those that then overlap are taken to be thinner by as much
at the start, and grow to their diameter in GROWTH; the energy of this counts as created, too.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import NamedTuple, Protocol

import numpy as np

from rope_model.analysis.conjugate_gradients import conjugate_gradients
from rope_model.analysis.pair_contact import (
    NO_CONTACTS,
    Numbers,
    Pair,
    PairContact,
    Rows,
    rows_of,
)
from rope_model.arrays import Array
from rope_model.boundary.point_forces import NO_FORCES, PointForces
from rope_model.interface import BalanceRope
from rope_model.method.generalized_alpha import Coefficients
from rope_model.parameter_table import require
from rope_model.parameters import Scene

ITERATIONS = 15  #: largest number of Newton iterations
TOLERANCE = 1e-4  #: error of the law over the sum of the forces
SMALL_FORCE = 1e-3  #: N, error of the law that is always allowed
#: a step is halved if the created energy exceeds this fraction of the largest work of any step
CREATED_FRACTION = 0.02
SLOW = 0.1  #: m/s, speed at which the kinetic energy of a metre of the rope is a lower bound of that work
MIN_CONTACT_STEP = 2e-3  #: s, shortest step
#: a step is also halved if touching points approach by more diameters: they might pass through each
#: other
LEAP = 0.5
GROWTH = 1.0  #: s, duration in which ropes that overlap at rest grow to their diameter

PairKey = tuple[int, int]
Forces = Mapping[PairKey, PairContact]  #: contact of each pair of ropes
Present = Sequence[Rows | None]  #: nodes of all ropes, None for one in pieces
_NOWHERE = (math.nan, math.nan, math.nan)


class Partner(Protocol):
    """Rope that takes part in a step and repeats it as often as necessary."""

    @property
    def rope(self) -> BalanceRope | None:
        """Present rope; None once it hangs in pieces."""

    def begin(self, t: float, h: float) -> None:
        """Begin the step from the present state at ``t`` to ``t`` + ``h`` (s)."""

    def go(self) -> bool:
        """Advance over the step; return whether that succeeded."""

    def back(self) -> None:
        """Go back to the start of the step."""

    def accept(self) -> None:
        """Accept the step."""


class Account(NamedTuple):
    """Contact of two ropes so far."""

    pressure: float = 0.0  #: present sum of the normal forces, N
    energy: float = 0.0  #: energy stored now, J
    work: float = 0.0  #: work on both ropes, J
    dissipated: float = 0.0  #: energy dissipated, J
    created: float = 0.0  #: energy that the steps created, J
    largest: float = 0.0  #: largest work of a step, J
    approach: float = 0.0  #: approach of touching points in the last step, m
    missed: float = 0.0  #: worst relative error of the forces against the law
    peak: float = 0.0  #: largest pressure, N
    peak_t: float = math.nan  #: its time, s
    peak_place: tuple[float, float, float] = _NOWHERE  #: its centre, m


@dataclass(frozen=True)
class Contacts:
    """State of ``Neighbours``, by the numbers of each pair of ropes."""

    start: float  #: time of the start, s
    insets: Mapping[PairKey, float]  #: depth of the ropes in each other at the start, m
    forces: Mapping[PairKey, PairContact]  #: present forces
    accounts: Mapping[PairKey, Account]  #: contact until now


class _ForcesOnRope(NamedTuple):
    """Contact forces on one rope, by the pairs that it belongs to."""

    s: list[Array]  # m
    force: list[Array]  # (m, 3), N


def _forces_on(k: int, forces: Forces) -> _ForcesOnRope:
    """Return the forces on rope ``k``; a pair has those on its first rope."""
    found = _ForcesOnRope([], [])
    for key, contact in forces.items():
        if k not in key:
            continue
        is_first = key[0] == k
        found.s.append(contact.s[0] if is_first else contact.s[1])
        found.force.append(contact.force if is_first else -contact.force)
    return found


class Neighbours:
    """Ropes that press each other.

    Parameters
    ----------
    scenes : sequence of Scene
        Data of each rope.
    origins : sequence of (float, float, float)
        Origin of each rope's coordinates in the shaft [m].

    Raises
    ------
    ValueError
        If contact is off, differs between ropes, or a model leaves it out.
    """

    def __init__(
        self, scenes: Sequence[Scene], origins: Sequence[tuple[float, float, float]]
    ) -> None:
        law = scenes[0].shaft.contact
        require(
            law.rope_stiffness > 0,
            "contact.rope_stiffness",
            law.rope_stiffness,
            "above 0",
            "use 1e6 N/m2",
        )
        for scene in scenes:
            cure = "give all ropes the same contact"
            require(
                scene.shaft.contact == law,
                "contact",
                scene.shaft.contact,
                "that of the first rope",
                cure,
            )
            model = scene.model.fidelity
            bound = "auto, torsional or spatial"
            require(model not in ("planar", "rigid"), "model.fidelity", model, bound, "set it so")
        self._origins = [np.array(origin) for origin in origins]
        self._method = Coefficients(scenes[0].solver.rho_inf)
        self._min_energy = 0.5 * scenes[0].rope.mass_per_length * SLOW**2
        self._pairs = {
            (i, j): Pair(scenes[i], scenes[j]) for i, j in combinations(range(len(scenes)), 2)
        }
        nothing = dict.fromkeys(self._pairs, NO_CONTACTS)
        unused = dict.fromkeys(self._pairs, Account())
        self.contacts = self._begun = Contacts(
            0.0, dict.fromkeys(self._pairs, 0.0), nothing, unused
        )

    def begin(self, t: float, ropes: Sequence[BalanceRope]) -> None:
        """Take ``ropes`` at rest at ``t`` (s)."""
        rows = [rows_of(rope, origin) for rope, origin in zip(ropes, self._origins, strict=True)]
        insets = {(i, j): pair.inset(rows[i], rows[j]) for (i, j), pair in self._pairs.items()}
        self.contacts = replace(self._begun, start=t, insets=insets)

    def step(self, t: float, h: float, partners: Sequence[Partner]) -> bool:
        """Advance all partners from ``t`` to ``t`` + ``h`` (s); return whether that succeeded."""
        before = self.contacts
        for partner in partners:
            partner.begin(t, h)
        missed = self._whole_step(t, h, partners)
        shortest = 0.5 * h < MIN_CONTACT_STEP
        if missed is not None and (
            shortest or (missed <= TOLERANCE and not self._too_long(before))
        ):
            for partner in partners:
                partner.accept()
            return True
        if shortest:
            return False
        for partner in partners:
            partner.back()
        self.contacts = before
        half = 0.5 * h
        return self.step(t, half, partners) and self.step(t + half, half, partners)

    def _too_long(self, before: Contacts) -> bool:
        return any(
            abs(account.created - before.accounts[key].created)
            > CREATED_FRACTION * max(account.largest, self._min_energy)
            or account.approach > LEAP * self._pairs[key].diameter
            for key, account in self.contacts.accounts.items()
        )

    def _whole_step(self, t: float, h: float, partners: Sequence[Partner]) -> float | None:
        """Advance all ropes; return the relative error of the forces against the law, None if a rope fails."""
        before = self._rows(partners)
        end = self.contacts.forces
        going = set(range(len(partners)))
        for iteration in range(ITERATIONS):
            for k in sorted(going) if iteration > 0 else ():
                partners[k].back()
            self._apply(t, h, partners, end)
            if not all(partners[k].go() for k in sorted(going)):
                return None
            rows = self._rows(partners)
            law = self._law(t + h, rows, self._method.newton(h))
            joint = _Iterate(end, law)
            if joint.missed <= TOLERANCE or iteration == ITERATIONS - 1:
                break
            end = joint.corrected(partners)
            going = joint.ropes
        self._book(t + h, before, rows, joint.forces, law, joint.missed)
        return joint.missed

    def _rows(self, partners: Sequence[Partner]) -> list[Rows | None]:
        there = zip(partners, self._origins, strict=True)
        return [None if one.rope is None else rows_of(one.rope, origin) for one, origin in there]

    def _law(self, t: float, rows: Present, c: Array) -> dict[PairKey, PairContact]:
        law = {}
        grown = min((t - self.contacts.start) / GROWTH, 1.0)
        for (i, j), pair in self._pairs.items():
            one = rows[i]
            other = rows[j]
            inset = (1.0 - grown) * self.contacts.insets[i, j]
            if one is None or other is None:
                law[i, j] = NO_CONTACTS
            else:
                law[i, j] = pair.find_contacts(one, other, c, inset)
        return law

    def _apply(self, t: float, h: float, partners: Sequence[Partner], end: Forces) -> None:
        """Apply forces that change from the present ones to those of ``end``."""
        present = self.contacts.forces
        for k, partner in enumerate(partners):
            if partner.rope is None:
                continue
            before = _forces_on(k, present)
            after = _forces_on(k, end)
            s = np.concatenate((*before.s, *after.s))
            if not s.size:
                partner.rope.apply(NO_FORCES)
                continue
            first = np.concatenate((*before.force, *(0 * force for force in after.force)))
            last = np.concatenate((*(0 * force for force in before.force), *after.force))
            order = np.argsort(s, kind="stable")
            partner.rope.apply(PointForces(s[order], first[order], last[order], t, t + h))

    def _book(
        self, t: float, before: Present, after: Present, end: Forces, law: Forces, missed: float
    ) -> None:
        """Add work, dissipation and created energy of a step to the accounts of the pairs, by the trapezoidal rule."""
        present = self.contacts.forces
        accounts = dict(self.contacts.accounts)
        for key, account in self.contacts.accounts.items():
            if not (present[key].point_id.size or end[key].point_id.size):
                continue
            work = 0.0
            spring_work = 0.0
            approach = 0.0
            for forces in (present[key], end[key]):
                motion = _relative_motion(key, forces, before, after)
                work += 0.5 * float(np.vdot(forces.force, motion))
                spring_work += 0.5 * float(np.vdot(forces.spring, motion))
                approach = max(
                    approach,
                    -float(np.einsum("mi,mi->m", motion, _along(forces.force)).min(initial=0.0)),
                )
            contact = law[key]
            pressure = float(contact.pressure.sum())
            account = account._replace(
                pressure=pressure,
                energy=contact.energy,
                work=account.work + work,
                dissipated=account.dissipated + spring_work - work,
                created=account.created + spring_work + contact.energy - account.energy,
                largest=max(account.largest, abs(work)),
                approach=approach,
                missed=max(account.missed, missed if end[key].point_id.size else 0.0),
            )
            if pressure > account.peak:
                x, y, z = (contact.pressure @ contact.position / pressure).tolist()
                account = account._replace(peak=pressure, peak_t=t, peak_place=(x, y, z))
            accounts[key] = account
        self.contacts = replace(self.contacts, forces=end, accounts=accounts)


class _Iterate:
    """Trial forces of all ropes that press each other, and the error of the law.

    ``forces`` contain the trial forces with the law's springs and tangents.
    """

    def __init__(self, trial: Forces, law_forces: Forces) -> None:
        self._keys = [
            key for key in trial if trial[key].point_id.size or law_forces[key].point_id.size
        ]
        self.ropes = {k for key in self._keys for k in key}
        parts = [(_union(trial[key], law_forces[key]), law_forces[key]) for key in self._keys]
        self.forces = dict.fromkeys(trial, NO_CONTACTS) | dict(
            zip(self._keys, (x for x, _ in parts), strict=True)
        )
        self._trial = _stacked([x.force for x, _ in parts])
        # rows of each pair of ropes in `_trial`
        rows = np.split(
            np.arange(len(self._trial)), np.cumsum([x.point_id.size for x, _ in parts])
        )[:-1]
        self._rows_by_pair = dict(zip(self._keys, rows, strict=True))
        law = _stacked([_spread(one, x.point_id, one.force) for x, one in parts])
        self._missing = law - self._trial
        largest = max(float(np.abs(x).sum()) for x in (law, self._trial))
        self.missed = float(np.abs(self._missing).sum()) / max(largest, SMALL_FORCE / TOLERANCE)

    def corrected(self, partners: Sequence[Partner]) -> Forces:
        """Return the forces of the next iteration."""
        K = np.concatenate([self.forces[key].tangent for key in self._keys])
        resisted = partial(np.einsum, "mij,mj->mi", K)
        x = conjugate_gradients(lambda f: self._response(partners, -f), resisted, -self._missing)
        force = self._trial + self._missing - resisted(x)
        changed = {
            key: self.forces[key]._replace(force=force[rows])
            for key, rows in self._rows_by_pair.items()
        }
        return self.forces | changed

    def _response(self, partners: Sequence[Partner], force: Array) -> Array:
        """Return the change of the points' separations by these forces."""
        moved = np.zeros_like(force)
        for k in sorted(self.ropes):
            mine = [key for key in self._keys if k in key]
            sense = np.concatenate(
                [np.full(self._rows_by_pair[key].size, 1.0 - 2.0 * key.index(k)) for key in mine]
            )
            index = np.concatenate([self._rows_by_pair[key] for key in mine])
            s = np.concatenate([self.forces[key].s[key.index(k)] for key in mine])
            order = np.argsort(s, kind="stable")
            forces = sense[order, None] * force[index[order]]
            rope = partners[k].rope
            if rope is not None:
                response = rope.displacement(PointForces(s[order], forces, forces, 0.0, 1.0))
                np.add.at(moved, index[order], sense[order, None] * response)
        return moved


def _relative_motion(key: PairKey, forces: PairContact, before: Present, after: Present) -> Array:
    """Return the displacement (m, 3) of points on the first rope relative to those on the second, m."""
    motion = np.zeros_like(forces.force)
    for side, k in enumerate(key):
        before_k = before[k]
        after_k = after[k]
        if before_k is not None and after_k is not None:
            motion += (1 - 2 * side) * (
                after_k.positions(forces.s[side]) - before_k.positions(forces.s[side])
            )
    return motion


def _along(force: Array) -> Array:
    """Return unit vectors along the forces, 0 where there is no force."""
    size = np.linalg.norm(force, axis=1, keepdims=True)
    return force / np.where(size > 0.0, size, 1.0)


def _union(trial: PairContact, law: PairContact) -> PairContact:
    """Return the ``trial`` forces at the points of both, at their latest s, with spring and tangent of the law."""
    point_id = np.union1d(trial.point_id[np.any(trial.force != 0.0, axis=1)], law.point_id)
    s = _spread(trial, point_id, trial.s.T)
    s[np.isin(point_id, law.point_id)] = law.s.T
    return law._replace(
        point_id=point_id,
        s=s.T,
        force=_spread(trial, point_id, trial.force),
        spring=_spread(law, point_id, law.spring),
        tangent=_spread(law, point_id, law.tangent),
    )


def _spread(contacts: PairContact, point_id: Numbers, values: Array) -> Array:
    """Return ``values`` of the points of ``contacts`` at the points with these numbers, 0 elsewhere."""
    out = np.zeros((point_id.size, *values.shape[1:]))
    known = np.isin(contacts.point_id, point_id)
    out[np.searchsorted(point_id, contacts.point_id[known])] = values[known]
    return out


def _stacked(parts: Sequence[Array]) -> Array:
    return np.concatenate(parts) if parts else np.zeros((0, 3))
