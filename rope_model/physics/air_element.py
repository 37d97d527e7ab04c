"""Beam element in air: physics.element with the drag of physics.air.

An element integrates the drag f with the cubic Hermite shapes N of r over the four Gauss points of
physics.hermite:

    R -= int N^T f dx,   J += int N^T (-c_v df/dv) N dx

The power that the rope gives to the air is -f . r_t; it is negative where the wind drives the rope.
"""

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import casadi as ca

from rope_model.physics import hermite
from rope_model.physics.air import COEFFICIENT_LENGTHS, AirCoefficients, Passing, drag, flow
from rope_model.physics.element import ELEMENT_DOF, PARAMETERS, ElementFidelity, ElementFunctions
from rope_model.physics.elementary import Scalar, Vector, cross, dot
from rope_model.physics.node import NODE_DOF

#: numbers of AirCoefficients
COEFFICIENTS_SIZE = sum(max(length, 1) for length in COEFFICIENT_LENGTHS)
PASSING_SIZE = 4  #: numbers of a Passing
AIR_SIZE = COEFFICIENTS_SIZE + 2 * PASSING_SIZE
#: entries of the balance behind element.BALANCE
AIR_BALANCE = (
    "given_to_air",  # W
    "air_fx",  # N, on the rope
    "air_fy",
    "air_fz",
    "air_mx",  # N m, about the origin
    "air_my",
    "air_mz",
)


class AirFunctions(NamedTuple):
    """CasADi functions of the air on an element; ``A`` contains AirCoefficients and both Passing conveyances.

    residual: (q, v, l, A) -> R (2 m,)
    tangent:  (q, v, l, A, c_v) -> J (2 m, 2 m)
    sums:     (q, v, l, A) -> AIR_BALANCE
    """

    residual: ca.Function
    tangent: ca.Function
    sums: ca.Function


@cache
def air_functions(fidelity: ElementFidelity) -> AirFunctions:
    """Build the functions for a fidelity."""
    dofs = ELEMENT_DOF[fidelity]
    entries = [*dofs, *(NODE_DOF + k for k in dofs)]
    symbols = [ca.SX.sym(name, len(entries)) for name in "qv"]
    l = ca.SX.sym("l")
    A = ca.SX.sym("A", AIR_SIZE)
    c_v = ca.SX.sym("c_v")
    q, v = (ca.SX.zeros(2 * NODE_DOF) for _ in symbols)
    for x, symbol in zip((q, v), symbols, strict=True):
        x[entries] = symbol
    air, conveyances = _numbers(ca.vertsplit(A))
    R = ca.SX.zeros(2 * NODE_DOF)
    J = ca.SX.zeros(2 * NODE_DOF, 2 * NODE_DOF)
    sums = ca.SX.zeros(len(AIR_BALANCE))
    for xi, weight in hermite.GAUSS:
        nodes = dict(_nodes(hermite.shape_functions(xi, l)))
        (point, slope), (speed, _) = (_at(xi, l, x) for x in (q, v))
        velocity = flow(air, conveyances, point, l)
        if 2 not in dofs:  # a planar model ignores wind across its plane
            velocity[2] = 0
        force, tangent = drag(air, velocity, slope, speed)
        w = weight * l
        sums += w * ca.vertcat(-dot(force, speed), *force, *cross(point, force))
        for row, (i, N_i) in nodes.items():
            R[row] -= w * N_i * force[i]
            for column, (j, N_j) in nodes.items():
                J[row, column] += c_v * w * N_i * N_j * tangent[i][j]
    inputs = [*symbols, l, A]
    return AirFunctions(
        ca.Function("air_residual", inputs, [ca.cse(R[entries])]),
        ca.Function("air_tangent", [*inputs, c_v], [ca.cse(J[entries, entries])]),
        ca.Function("air_sums", inputs, [ca.cse(sums)]),
    )


@cache
def air_element(fidelity: ElementFidelity, base: ElementFunctions) -> ElementFunctions:
    """Build the functions of the ``base`` element in air, with A behind its P and AIR_BALANCE behind its balance."""
    air = air_functions(fidelity)
    m = len(ELEMENT_DOF[fidelity])
    q, v, a, q_prestress = (ca.SX.sym(name, 2 * m) for name in ("q", "v", "a", "q_prestress"))
    l = ca.SX.sym("l")
    F = ca.SX.sym("F", base.residual.size1_in(4))
    P = ca.SX.sym("P", len(PARAMETERS) + AIR_SIZE)
    c_q, c_v, c_a = (ca.SX.sym(name) for name in ("c_q", "c_v", "c_a"))
    base_args = (l, F, P[: len(PARAMETERS)])
    air_inputs = (q, v, l, P[len(PARAMETERS) :])
    R, J = base.tangent(q, v, a, *base_args, c_q, c_v, c_a, q_prestress)
    force = air.residual(*air_inputs)
    return base.replaced(
        residual=([q, v, a, l, F, P], [base.residual(q, v, a, *base_args) + force]),
        tangent=(
            [q, v, a, l, F, P, c_q, c_v, c_a, q_prestress],
            [R + force, J + air.tangent(*air_inputs, c_v)],
        ),
        balance=(
            [q, v, l, F, P],
            [ca.vertcat(base.balance(q, v, *base_args), air.sums(*air_inputs))],
        ),
        losses=([q, v, l, F, P], [base.losses(q, v, *base_args)]),
        momentum=([q, v, l, P], [base.momentum(q, v, l, base_args[2])]),
    )


def _numbers(A: Vector) -> tuple[AirCoefficients, list[Passing]]:
    return AirCoefficients.from_numbers(A), [
        Passing((A[k], A[k + 1], A[k + 2]), A[k + 3])
        for k in (COEFFICIENTS_SIZE, COEFFICIENTS_SIZE + PASSING_SIZE)
    ]


def _at(xi: float, l: ca.SX, x: ca.SX) -> tuple[list[Scalar], list[Scalar]]:
    """Return r and r', or their rates, at ``xi`` of the element."""
    pairs = [
        hermite.interpolate(xi, l, x[i], x[3 + i], x[NODE_DOF + i], x[NODE_DOF + 3 + i])
        for i in range(3)
    ]
    return [value for value, _ in pairs], [slope for _, slope in pairs]


def _nodes(N: tuple[Scalar, ...]) -> Iterator[tuple[int, tuple[int, Scalar]]]:
    """Yield the index of each entry of r and r' in the element, with its component and its shape function."""
    for first, N_i in zip((0, 3, NODE_DOF, NODE_DOF + 3), N, strict=True):
        for i in range(3):
            yield first + i, (i, N_i)
