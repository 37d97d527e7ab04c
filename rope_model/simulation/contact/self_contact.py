"""Equations of motion of a rope that may touch itself: RopeSystem with physics.rope_contact.

Bounding boxes give the pairs of candidate elements.  Along an element of such a pair the distance changes by no more
than the arc length, so that far points are skipped and a leg costs a few checks.  Contact has no history in the state.
"""

import math
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from rope_model.analysis.conjugate_gradients import conjugate_gradients
from rope_model.arrays import Array
from rope_model.numerics.coupled_newton import Iterate
from rope_model.numerics.generalized_alpha import Solution
from rope_model.parameters import Scene
from rope_model.physics import hermite, rope_contact
from rope_model.physics.centreline import enclosing_box
from rope_model.physics.contact import SUMS, ContactTerms
from rope_model.physics.node import SLOPE
from rope_model.simulation.rope_system import Evaluation, Losses, Near, RopeSystem

#: offsets from the numbers of two elements to those of their nodes
_ENDS = np.array([0, 1, 0, 1])


class SelfContact(NamedTuple):
    """Two points in contact: elements, shape functions, length of rope, law."""

    elements: tuple[int, int]
    N: tuple[float, ...]  # (8,), those of the second element's nodes are negative
    weight: float
    terms: ContactTerms


class SelfContacts:
    """All contacts at one instant (m,), and their forces on the nodes."""

    def __init__(self, contacts: list[SelfContact]) -> None:
        self.any = bool(contacts)
        self._nodes = (
            np.array([x.elements for x in contacts], dtype=int).reshape(-1, 2).repeat(2, axis=1)
            + _ENDS
        )
        self._N = np.array([x.N for x in contacts]).reshape(-1, 4, 2)
        self._weights = np.array([x.weight for x in contacts])
        self._forces = np.array([x.terms.force for x in contacts]).reshape(-1, 3)
        self._tangents = np.array([x.terms.tangent for x in contacts]).reshape(-1, 6)[
            :, rope_contact.TANGENT_ENTRIES
        ]
        self._sums = np.array([x.terms.sums for x in contacts]).reshape(-1, len(SUMS))

    def sums(self) -> dict[str, float]:
        """Return energy (J), dissipation (W), the couple that friction leaves (N m) and the pressure (N)."""
        total = dict(zip(SUMS, (self._weights @ self._sums).tolist(), strict=True))
        couple = {f"contact_{name}": total[name] for name in ("mx", "my", "mz")}
        dissipated = {"contact_dissipated": total["dissipated"]}
        return {"contact": total["energy"], **dissipated, **couple, "rope": total["pressure"]}

    def take_force(self, R: Array) -> None:
        """Subtract the forces on the nodes from ``R`` (nodes, 7)."""
        self._spread(-self._forces, R)

    def times(self, x: Array) -> Array:
        """Return the product of the tangent with ``x`` (nodes, 7)."""
        rows = x[self._nodes, : SLOPE.stop].reshape(-1, 8, 3)
        separation = np.einsum("mk,mki->mi", self._N.reshape(-1, 8), rows)
        y = np.zeros_like(x)
        self._spread(np.einsum("mij,mj->mi", self._tangents, separation), y)
        return y

    def _spread(self, f: Array, y: Array) -> None:
        weighted = self._weights[:, None] * f
        for k, columns in enumerate((slice(0, SLOPE.start), SLOPE)):
            np.add.at(y[:, columns], self._nodes, self._N[..., k, None] * weighted[:, None, :])


def find_self_contacts(
    scene: Scene, q: Array, v: Array, lengths: Array, cq: float, cv: float
) -> SelfContacts:
    """Return the contacts of a rope with itself, with the tangent with respect to (cq, cv) times q and v."""
    rows, speeds, contacts = _rows(q), _rows(v), []
    diameter, law, l = scene.rope.diameter, scene.shaft.contact, lengths.tolist()
    start = (np.cumsum(lengths) - lengths).tolist()
    for e, N, weight, point, touching in _touching(q, rows, lengths, diameter):
        for n in rope_contact.strands(
            [start[o] + xi * l[o] for _, o, xi in touching], rope_contact.MIN_ARC * diameter
        ):
            _, other, xi = touching[n]
            partner = hermite.shape_functions(xi, l[other])
            separation = _difference(point, _at(rows, other, partner))
            velocity = _difference(_at(speeds, e, N), _at(speeds, other, partner))
            contact = rope_contact.self_contact_law(law, diameter, separation, velocity, cq, cv)
            contacts.append(SelfContact((e, other), (*N, *(-n for n in partner)), weight, contact))
    return SelfContacts(contacts)


def overlap_of(q: Array, lengths: Array, diameter: float) -> tuple[float, float]:
    """Return the largest depth (m) of the rope in itself, and its height (m); 0 and NaN without contact."""
    candidates = _touching(q, _rows(q), lengths, diameter)
    return max(
        ((diameter - near[0][0], point[1]) for *_, point, near in candidates if near),
        default=(0.0, math.nan),
    )


def _touching(
    q: Array, rows: list[list[float]], lengths: Array, diameter: float
) -> Iterator[
    tuple[int, tuple[float, ...], float, tuple[float, float, float], list[tuple[float, int, float]]]
]:
    """Yield points of candidate elements (element, N, length, position) with near ones (distance, element, xi)."""
    l = lengths.tolist()
    for e, others in _near_elements(q, lengths, diameter):
        number, k = int(rope_contact.number_of_points(l[e], diameter)), 0
        weight = l[e] / number
        while k < number:
            N = hermite.shape_functions((k + 0.5) / number, l[e])
            point = _at(rows, e, N)
            near = sorted(_nearest_point(rows, l[o], o, point) for o in others)
            yield e, N, weight, point, [x for x in near if x[0] < diameter]
            k += 1 + int(rope_contact.points_skipped(near[0][0], diameter, weight, number))


class SelfContactSystem(RopeSystem):
    """RopeSystem with the contact of the rope with itself, as in ``scene``."""

    def __init__(self, scene: Scene, *parts: Any) -> None:
        super().__init__(*parts)
        self.scene = scene

    def self_contacts(self, q: Array, v: Array, cq: float = 0.0, cv: float = 0.0) -> SelfContacts:
        """Return the contacts of the rope with itself, with the tangent with respect to (cq, cv) times q and v."""
        return find_self_contacts(self.scene, q, v, self.lengths, cq, cv)

    def _newton(
        self, near: Near, x: Iterate, c: Array, tolerance: float, before: Array | None
    ) -> Solution[Evaluation]:
        if not self.self_contacts(x.q, x.v).any:
            solution = super()._newton(near, x, c, tolerance, before)
            if not self.self_contacts(solution.q, solution.v).any:
                return solution
        return self._iterate(near, x, c, tolerance)

    def _coupling(self, at: Iterate, c: Array) -> Callable[[Array], Array] | None:
        return self.self_contacts(at.q, at.v, float(c[0]), float(c[1])).times

    def _with_touches(self, evaluation: Evaluation, q: Array, v: Array) -> Evaluation:
        contacts = self.self_contacts(q, v)
        R = evaluation.reaction.copy()
        contacts.take_force(R)
        return Evaluation(
            R,
            evaluation.balance
            | {"contact": evaluation.balance["contact"] + contacts.sums()["contact"]},
        )

    def newton_step(
        self, q: Array, v: Array, a: Array, reaction: Array, c: Array
    ) -> tuple[Array, Array]:
        contacts = self.self_contacts(q, v, float(c[0]), float(c[1]))
        if not contacts.any:
            return super().newton_step(q, v, a, reaction, c)
        R = self.evaluate(q, v, a, reaction).reaction
        solve = self._solver(
            *self._with_bodies(self._near(q, 0.0), q, v), Iterate(q, v, a, reaction), c
        )
        return conjugate_gradients(solve, contacts.times, R), R

    def evaluate(self, q: Array, v: Array, a: Array, reaction: Array) -> Evaluation:
        return self._with_touches(super().evaluate(q, v, a, reaction), q, v)

    def external_sums(self, q: Array, v: Array) -> dict[str, float]:
        sums, more = super().external_sums(q, v), self.self_contacts(q, v).sums()
        return {**sums, **{name: sums[name] + value for name, value in more.items()}}

    def losses(self, q: Array, v: Array) -> Losses:
        losses = super().losses(q, v)
        return losses._replace(
            contact=losses.contact + self.self_contacts(q, v).sums()["contact_dissipated"]
        )


def _near_elements(q: Array, lengths: Array, diameter: float) -> list[tuple[int, list[int]]]:
    """Return the elements that may touch others, each with the candidates to its right."""
    rows = q[:, : SLOPE.stop].T
    box = np.array(enclosing_box(lengths, rows[:, :-1], rows[:, 1:]))
    gaps = np.abs(box[:3, :, None] - box[:3, None, :]) - (box[3:, :, None] + box[3:, None, :])
    start = np.cumsum(lengths) - lengths
    near = (gaps < diameter).all(axis=0) & (
        start - (start + lengths)[:, None] >= rope_contact.MIN_ARC * diameter
    )
    return [(int(e), np.flatnonzero(near[e]).tolist()) for e in np.flatnonzero(near.any(axis=1))]


def _rows(x: Array) -> list[list[float]]:
    """Return r and r' of the nodes, or their rates."""
    rows: list[list[float]] = x[:, : SLOPE.stop].tolist()
    return rows


def _at(rows: list[list[float]], element: int, N: tuple[float, ...]) -> tuple[float, float, float]:
    """Return the position, or the velocity, at shape functions ``N`` of an element."""
    a, b = rows[element], rows[element + 1]
    x, y, z = (N[0] * a[k] + N[1] * a[k + 3] + N[2] * b[k] + N[3] * b[k + 3] for k in range(3))
    return x, y, z


def _difference(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def _nearest_point(
    rows: list[list[float]], l: float, element: int, point: tuple[float, ...]
) -> tuple[float, int, float]:
    """Return the distance (m) of the element from ``point``, the element, and xi of its nearest point."""

    def distance(xi: float) -> float:
        return float(
            np.linalg.norm(_difference(_at(rows, element, hermite.shape_functions(xi, l)), point))
        )

    xi = min(rope_contact.PROBES, key=distance)
    for _ in range(rope_contact.CORRECTIONS):
        xi = rope_contact.nearer_xi(xi, l, point, rows[element], rows[element + 1])
    return distance(xi), element, xi
