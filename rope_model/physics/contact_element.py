"""Beam element in contact with bodies in the shaft: physics.element with the forces of physics.contact.

Where the element is near a body, the force per length is integrated along the pressed part of the
centre line (physics.contact_points):

    R -= int N^T f dx,   J += int N^T (-c_q df/dr - c_v df/dv) N dx

with the cubic Hermite shapes N of r.
"""

from functools import cache
from typing import Any, NamedTuple

import casadi as ca

from rope_model.physics import contact_points, hermite
from rope_model.physics.contact import SUMS, ContactLaw, contact_law
from rope_model.physics.element import ELEMENT_DOF, ElementFidelity, ElementFunctions
from rope_model.physics.elementary import Scalar, Vector, logical_and, where
from rope_model.physics.node import ANGLE
from rope_model.physics.shaft import KINDS, Body

LAW = (*ContactLaw._fields, "diameter")  #: entries of the law
BODY_SIZE = 13  #: number of entries of a body: those of shaft.Body and its velocity
#: entries of the balance behind element.BALANCE
CONTACT_BALANCE = (
    "contact",  # J, stored where bodies press the rope
    "contact_dissipated",  # W, never negative
    "contact_moved",  # W, power of moving bodies on the rope
    "contact_fx",  # N, on the rope
    "contact_fy",
    "contact_fz",
    "contact_mx",  # N m, about the origin
    "contact_my",
    "contact_mz",
    *KINDS,  # N, sums of the pressure
)


@cache
def contact_element(
    fidelity: ElementFidelity, base: ElementFunctions, kinds: tuple[int, ...]
) -> ElementFunctions:
    """Build the functions of the ``base`` element of a fidelity with a body of each of the ``kinds``.

    F has a further entry for each body, 1 where the element is near it, else 0; P has LAW and the
    bodies behind its own entries.  Contact adds to residual, tangent, balance and losses, the
    latter two in further entries.
    """
    m = len(ELEMENT_DOF[fidelity])
    base_frame = base.residual.size1_in(4)
    base_size = base.residual.size1_in(5)
    bodies = len(kinds)
    q, v, a, q_prestress = (ca.MX.sym(name, 2 * m) for name in ("q", "v", "a", "q_prestress"))
    l = ca.MX.sym("l")
    F = ca.MX.sym("F", base_frame + bodies)
    P = ca.MX.sym("P", base_size + len(LAW) + bodies * BODY_SIZE)
    c_q, c_v, c_a = (ca.MX.sym(name) for name in ("c_q", "c_v", "c_a"))
    base_args = (F[:base_frame], P[:base_size])
    is_near = ca.sum1(F[base_frame:]) > 0
    contact = _integrals(ELEMENT_DOF[fidelity], kinds)

    def added(function: ca.Function, *factors: Scalar) -> ca.MX:
        return _where_near(function)(is_near, q, v, l, F[base_frame:], P[base_size:], *factors)

    R_base, J_base = base.tangent(q, v, a, l, *base_args, c_q, c_v, c_a, q_prestress)
    balance = added(contact.sums)
    return base.replaced(
        residual=(
            [q, v, a, l, F, P],
            [base.residual(q, v, a, l, *base_args) + added(contact.residual)],
        ),
        tangent=(
            [q, v, a, l, F, P, c_q, c_v, c_a, q_prestress],
            [R_base + added(contact.residual), J_base + added(contact.tangent, c_q, c_v)],
        ),
        balance=([q, v, l, F, P], [ca.vertcat(base.balance(q, v, l, *base_args), balance)]),
        losses=([q, v, l, F, P], [ca.vertcat(base.losses(q, v, l, *base_args), balance[1:3])]),
        strains=([q, v, l, F], [base.strains(q, v, l, base_args[0])]),
        momentum=([q, v, l, P], [base.momentum(q, v, l, base_args[1])]),
        transport=([q, v, a, l, F], [base.transport(q, v, a, l, base_args[0])]),
    )


class _Integrals(NamedTuple):
    """Functions of (q, v, l, near, P)."""

    residual: ca.Function  # R (2 m,)
    tangent: ca.Function  # of c_q and c_v too: J (2 m, 2 m)
    sums: ca.Function  # CONTACT_BALANCE


#: Component i of node value k, which is r or r' of either node, to its index among an element's
#: coordinates.
_Entries = dict[tuple[int, int], int]


def _entries_of(dofs: tuple[int, ...]) -> _Entries:
    """Return the entries that an element with these degrees of freedom of a node has."""
    m = len(dofs)
    index = {dof: i for i, dof in enumerate(dofs) if dof < ANGLE}
    entries = {}
    for i in (i for i in range(3) if i in index):
        for k in range(4):
            entries[i, k] = index[i + 3 * (k % 2)] + m * (k // 2)
    return entries


def _node_values(x: ca.MX, entries: _Entries) -> ca.MX:
    """Return the node values (3, 4) in the coordinates or rates ``x``; zeros where it has none."""
    columns = []
    for k in range(4):
        column = [x[entries[i, k]] if (i, k) in entries else 0 for i in range(3)]
        columns.append(ca.vertcat(*column))
    return ca.horzcat(*columns)


def _integrals(dofs: tuple[int, ...], kinds: tuple[int, ...]) -> _Integrals:
    """Build the integrals of contact along an element with bodies of these ``kinds``."""
    m = len(dofs)
    q = ca.MX.sym("q", 2 * m)
    v = ca.MX.sym("v", 2 * m)
    l = ca.MX.sym("l")
    near = ca.MX.sym("near", len(kinds))
    P = ca.MX.sym("P", len(LAW) + len(kinds) * BODY_SIZE)
    c_q = ca.MX.sym("c_q")
    c_v = ca.MX.sym("c_v")
    entries = _entries_of(dofs)
    rows = _node_values(q, entries)
    speeds = _node_values(v, entries)

    force = ca.MX.zeros(3, 4)
    sums = ca.MX.zeros(len(CONTACT_BALANCE))
    stiff = ca.MX.zeros(6, 10)
    for k, kind in enumerate(kinds):
        body = P[len(LAW) + k * BODY_SIZE : len(LAW) + (k + 1) * BODY_SIZE]
        inputs = [rows, speeds, l, ca.vertcat(P[: len(LAW)], body)]
        terms = _where_near(_body_function(False))(near[k] > 0, *inputs)
        force += terms[0]
        sums[: len(SUMS) - 1] += terms[1][:-1]
        sums[len(SUMS) - 1 + kind] += terms[1][-1]
        stiff += _where_near(_body_function(True))(near[k] > 0, *inputs, c_q, c_v)
    R = ca.MX.zeros(2 * m)
    J = ca.MX(2 * m, 2 * m)
    for (i, k), row in entries.items():
        R[row] = -force[i, k]
        for (j, n), column in entries.items():
            J[row, column] = stiff[_upper(i, j, 3), _upper(k, n, 4)]
    return _Integrals(
        residual=ca.Function("contact_residual", [q, v, l, near, P], [R]),
        tangent=ca.Function("contact_tangent", [q, v, l, near, P, c_q, c_v], [ca.densify(J)]),
        sums=ca.Function("contact_sums", [q, v, l, near, P], [sums]),
    )


def _where_near(function: ca.Function) -> ca.Function:
    """Build (condition, inputs) -> ``function`` of the inputs, or zeros."""
    zeros = [ca.MX.zeros(*function.size_out(i)) for i in range(function.n_out())]
    nothing = ca.Function(f"no_{function.name()}", function.mx_in(), zeros)
    return ca.Function.if_else(f"{function.name()}_if", function, nothing)


def _upper(i: int, j: int, size: int) -> int:
    """Return the index of entry (i, j) of a symmetric matrix (size, size) in its upper half, stored row by row."""
    i, j = min(i, j), max(i, j)
    return size * i - i * (i - 1) // 2 + j - i


@cache
def _body_function(stiff: bool) -> ca.Function:
    """Build (rows (3, 4), speeds (3, 4), l, P) -> force on the node values (3, 4) and SUMS of one body.

    With (c_q, c_v) it is the tangent: entries of (3, 3), upper half, in columns for pairs of node
    values, upper half.
    """
    rows = ca.MX.sym("r", 3, 4)
    speeds = ca.MX.sym("v", 3, 4)
    l = ca.MX.sym("l")
    P = ca.MX.sym("P", len(LAW) + BODY_SIZE)
    c = [ca.MX.sym("c_q"), ca.MX.sym("c_v")] if stiff else []
    searches = _search_functions()
    start = ca.MX.sym("start")
    stop = ca.MX.sym("stop")
    ends = [searches.probe(xi, rows, l, P) for xi in (start, stop)]
    bracket = searches.halve.fold(contact_points.HALVINGS)(ca.horzcat(*ends), rows, l, P)
    turn_xi = ca.if_else(ends[0][2] * ends[1][2] < 0, _turning_function()(bracket), stop)
    probes = ca.horzcat(ends[0], searches.probe(turn_xi, rows, l, P), ends[1])
    cell = _where_near(_cell_function(stiff))(
        ca.mmax(probes[1, :]) > 0, probes, rows, speeds, l, P, *c
    )
    cell_function = ca.Function(
        "cell", [start, stop, rows, speeds, l, P, *c], list(cell) if not stiff else [cell]
    )
    bounds = ca.DM(
        [[(k + end) / contact_points.CELLS for k in range(contact_points.CELLS)] for end in (0, 1)]
    )
    terms = [
        cell_function(bounds[0, k], bounds[1, k], rows, speeds, l, P, *c)
        for k in range(contact_points.CELLS)
    ]
    totals = [sum(x) for x in (zip(*terms, strict=True) if not stiff else [terms])]
    return ca.Function("pressed_tangent" if stiff else "pressed", [rows, speeds, l, P, *c], totals)


@cache
def _cell_function(stiff: bool) -> ca.Function:
    """Build (probes (3, 3) at ends and extremum of a cell, rows, speeds, l, P) -> its part of ``_body_function``."""
    probes = ca.MX.sym("probes", 3, 3)
    rows = ca.MX.sym("r", 3, 4)
    speeds = ca.MX.sym("v", 3, 4)
    l = ca.MX.sym("l")
    P = ca.MX.sym("P", len(LAW) + BODY_SIZE)
    c = [ca.MX.sym("c_q"), ca.MX.sym("c_v")] if stiff else []
    quadrature = _quadrature(probes, rows, l, P)
    N = quadrature.shares
    number = N.shape[1]
    touch = _touch_functions()
    repeated = (rows @ N, speeds @ N, ca.repmat(P, 1, number))
    inputs = [probes, rows, speeds, l, P, *c]
    if stiff:
        T = touch.tangent.map(number)(*repeated, *(ca.repmat(x, 1, number) for x in c))
        pairs = [N[k, :] * N[n, :] for k in range(4) for n in range(k, 4)]
        weights = ca.repmat(quadrature.weights, 1, len(pairs))
        return ca.Function("cell_tangent", inputs, [T @ (ca.vertcat(*pairs).T * weights)])
    force, sums = touch.load.map(number)(*repeated)
    weights = ca.repmat(quadrature.weights, 1, 4)
    return ca.Function("cell_force", inputs, [force @ (N.T * weights), sums @ quadrature.weights])


class _Quadrature(NamedTuple):
    """Points of a cell at which contact is evaluated."""

    shares: ca.MX  # (4, points), of the node values
    weights: ca.MX  # (points,), m


def _quadrature(probes: ca.MX, rows: ca.MX, l: ca.MX, P: ca.MX) -> _Quadrature:
    """Return the points between the ends of a cell and the extremum of its depth, by LEVELS of depth."""
    reach = _search_functions().reach.fold(contact_points.STEPS)
    pieces = []
    for side in (0, 1):
        swapped = probes[1, side] > probes[1, side + 1]
        deeper = ca.if_else(swapped, probes[:, side], probes[:, side + 1])
        other = ca.if_else(swapped, probes[:, side + 1], probes[:, side])
        start = deeper[0]
        for fraction in contact_points.LEVELS:
            level = fraction * P[LAW.index("diameter")]
            reached = reach(ca.vertcat(other, deeper[0]), rows, l, P, level)[0]
            above = ca.if_else(other[1] >= level, other[0], reached)
            stop = ca.if_else(deeper[1] <= level, deeper[0], above)
            pieces += [
                contact_points.contact_point(*point, start, stop)
                for point in zip(contact_points.PARTS, contact_points.WEIGHTS, strict=True)
            ]
            start = stop
    xi_points, weights = (ca.vertcat(*x) for x in zip(*pieces, strict=True))
    number = len(pieces)
    xi = ca.SX.sym("xi")
    length = ca.SX.sym("l")
    shape_functions = ca.Function(
        "shares", [xi, length], [ca.horzcat(*hermite.shape_functions(xi, length))]
    ).map(number)
    # a column for each point
    return _Quadrature(ca.reshape(shape_functions(xi_points.T, l), 4, number), weights * l)


class _Searches(NamedTuple):
    """Functions with which contact is found along an element."""

    probe: ca.Function  # (xi, rows, l, P) -> probe
    halve: ca.Function  # (ends, rows, l, P) -> ends of the half with the extremum of the depth
    reach: ca.Function  # (state, rows, l, P, level) -> state nearer to that depth


@cache
def _search_functions() -> _Searches:
    rows = ca.SX.sym("r", 3, 4)
    l = ca.SX.sym("l")
    P = ca.SX.sym("P", len(LAW) + BODY_SIZE)
    a = [*ca.vertsplit(rows[:, 0]), *ca.vertsplit(rows[:, 1])]
    b = [*ca.vertsplit(rows[:, 2]), *ca.vertsplit(rows[:, 3])]
    diameter = P[LAW.index("diameter")]
    body, _ = _body(P[len(LAW) :])
    ends = ca.SX.sym("ends", 3, 2)
    state = ca.SX.sym("at", 4)
    xi = ca.SX.sym("place")
    level = ca.SX.sym("level")

    def probe_at(xi: Scalar) -> Any:
        return ca.vertcat(*contact_points.probe(xi, l, a, b, diameter, body))

    start = ends[:, 0]
    stop = ends[:, 1]
    middle = probe_at(0.5 * (start[0] + stop[0]))
    turns = start[2] * stop[2] < 0
    first = start[2] * middle[2] > 0
    start = where(logical_and(turns, first), middle, start)
    stop = where(logical_and(turns, ca.logic_not(first)), middle, stop)
    next_probe = probe_at(contact_points.reaching(_probe(state[:3]), state[3], level))
    nearer = where(
        next_probe[1] < level,
        ca.vertcat(next_probe, state[3]),
        ca.vertcat(state[:3], next_probe[0]),
    )
    return _Searches(
        probe=ca.Function("probe", [xi, rows, l, P], [probe_at(xi)]),
        halve=ca.Function("halve", [ends, rows, l, P], [ca.cse(ca.horzcat(start, stop))]),
        reach=ca.Function("reach", [state, rows, l, P, level], [ca.cse(nearer)]),
    )


@cache
def _turning_function() -> ca.Function:
    ends = ca.SX.sym("ends", 3, 2)
    return ca.Function(
        "turning", [ends], [contact_points.turning(_probe(ends[:, 0]), _probe(ends[:, 1]))]
    )


def _probe(x: Vector) -> contact_points.Probe:
    return contact_points.Probe(x[0], x[1], x[2])


def _body(x: Any) -> tuple[Body, Any]:
    """Return a body and its velocity from their entries (BODY_SIZE,)."""
    return Body(x[0:3], x[3:6], x[6], x[7], x[8], x[9]), x[10:13]


class _Touch(NamedTuple):
    """Contact of a point with one body, per length."""

    load: ca.Function  # (point, velocity, P) -> force (3,) and SUMS
    tangent: ca.Function  # (point, velocity, P, c_q, c_v) -> tangent


@cache
def _touch_functions() -> _Touch:
    point = ca.SX.sym("point", 3)
    speed = ca.SX.sym("speed", 3)
    P = ca.SX.sym("P", len(LAW) + BODY_SIZE)
    c_q = ca.SX.sym("c_q")
    c_v = ca.SX.sym("c_v")
    entries: list[Any] = ca.vertsplit(P[: len(LAW)])
    law = ContactLaw._make(entries[:-1])
    body, body_velocity = _body(P[len(LAW) :])
    terms = contact_law(law, entries[-1], body, body_velocity, point, speed, c_q, c_v)
    load = [ca.vertcat(*terms.force), ca.vertcat(*terms.sums)]
    tangent = ca.cse(ca.vertcat(*terms.tangent))
    return _Touch(
        load=ca.Function("contact_law", [point, speed, P], ca.cse(load)),
        tangent=ca.Function("touch_tangent", [point, speed, P, c_q, c_v], [tangent]),
    )
