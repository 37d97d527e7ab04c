"""Equations of a chain of equal two-node elements, and the direction of Newton's method by block elimination.

Element i joins nodes i and i + 1, so the matrix of the chain is block tridiagonal with blocks of the node's size.
Forward elimination carries the Schur complement of everything to the left, back substitution returns:

    W_i = D_i^-1 U_i,   z_i = D_i^-1 y_i,   D_{i+1} = J22 - L_i W_i,   y_{i+1} = y2 - L_i z_i
    x_n = z_n,          x_i = z_i - W_i x_{i+1}

There is no pivoting beyond the block: the matrices of a time step and of pseudo-transient continuation are nearly
symmetric and positive definite.  Rows and columns of degrees of freedom that are not free are replaced by those of
the identity, so their correction is zero and their residual is the reaction.

Everything is built from CasADi functions of one element; this module does not know what the element is.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca


@dataclass(frozen=True)
class ChainFunctions:
    """CasADi functions of a chain of n elements, n + 1 nodes with m degrees of freedom each, columns are nodes.

    direction: (q, v, a, l, load, node_mass, free, P, c) -> correction (m, n + 1), R (m, n + 1)
        solves J x = -R on the free degrees of freedom, J = c[0] dR/dq + c[1] dR/dv + c[2] dR/da
    assess:    (q, v, a, l, load, node_mass, P) -> R (m, n + 1), balance summed over the elements
    strains:   (q, l, P) -> one column per element

    ``load`` and ``node_mass`` (m, n + 1) are dead loads and concentrated masses (inertias) at the nodes.
    """

    direction: ca.Function
    assess: ca.Function
    strains: ca.Function

    def all(self) -> tuple[ca.Function, ca.Function, ca.Function]:
        """The functions in the order in which a compiled library and a portable file hold them."""
        return self.direction, self.assess, self.strains


def chain_functions(
    n: int, residual: ca.Function, tangent: ca.Function, balance: ca.Function, strains: ca.Function
) -> ChainFunctions:
    """Functions for ``n`` elements from those of one, with the signatures of an element (see physics.element)."""
    m = residual.size1_out(0) // 2
    parameters = residual.size1_in(4)
    q, v, a, load, node_mass, free = (ca.MX.sym(s, m, n + 1) for s in ("q", "v", "a", "load", "node_mass", "free"))
    l, P, c = ca.MX.sym("l", 1, n), ca.MX.sym("P", parameters), ca.MX.sym("c", 3)

    def both_ends(x: ca.MX) -> ca.MX:
        return ca.vertcat(x[:, :-1], x[:, 1:])

    def assembled(R: ca.MX) -> ca.MX:
        zero = ca.MX.zeros(m, 1)
        return ca.horzcat(R[:m, :], zero) + ca.horzcat(zero, R[m:, :])

    nodal = node_mass * a - load

    # one sweep evaluates the elements and eliminates their left node
    forward = _forward_step(tangent, m).mapaccum("forward_sweep", n, 2)
    diagonal = c[2] * node_mass
    D, y, W, z, R = forward(
        ca.diag(free[:, 0] * diagonal[:, 0] + 1 - free[:, 0]),
        free[:, 0] * nodal[:, 0],
        *(both_ends(x) for x in (q, v, a)),
        l,
        both_ends(free),
        diagonal[:, 1:],
        nodal[:, 1:],
        ca.repmat(P, 1, n),
        *(ca.repmat(c[i], 1, n) for i in range(3)),
    )
    last = _last_solve(m)(D[:, -m:], y[:, -1])
    backward = _backward_step(m).mapaccum("backward_sweep", n, 1)
    order = list(range(n - 1, -1, -1))
    columns = [i * m + j for i in order for j in range(m)]
    x = backward(last, W[:, columns], z[:, order])
    correction = ca.horzcat(x[:, order], last)

    R_map = residual.map(n)(*(both_ends(x) for x in (q, v, a)), l, ca.repmat(P, 1, n))
    sums = ca.sum2(balance.map(n)(*(both_ends(x) for x in (q, v)), l, ca.repmat(P, 1, n)))
    return ChainFunctions(
        direction=ca.Function(
            "direction", [q, v, a, l, load, node_mass, free, P, c], [correction, assembled(R) + nodal]
        ),
        assess=ca.Function("assess", [q, v, a, l, load, node_mass, P], [assembled(R_map) + nodal, sums]),
        strains=ca.Function("strains", [q, l, P], [strains.map(n)(both_ends(q), l, ca.repmat(P, 1, n))]),
    )


def _forward_step(tangent: ca.Function, m: int) -> ca.Function:
    """(D, y; element inputs; free of both nodes, diagonal and residual of the right one) -> next D, y; W, z, R."""
    D, y = ca.SX.sym("D", m, m), ca.SX.sym("y", m)
    free, diagonal, nodal = ca.SX.sym("free", 2 * m), ca.SX.sym("diagonal", m), ca.SX.sym("nodal", m)
    R_e, J_e = ca.SX.sym("R", 2 * m), ca.SX.sym("J", 2 * m, 2 * m)
    J, R = J_e * (free @ free.T), R_e * free
    solved = _solve(D + J[:m, :m], ca.horzcat(J[:m, m:], y + R[:m]))
    W, z = solved[:, :m], solved[:, m]
    fixed = 1 - free[m:]
    D_next = J[m:, m:] + ca.diag(free[m:] * diagonal + fixed) - J[m:, :m] @ W
    y_next = R[m:] + free[m:] * nodal - J[m:, :m] @ z
    eliminate = ca.Function("eliminate", [D, y, R_e, J_e, free, diagonal, nodal], ca.cse([D_next, y_next, W, z]))

    element = tangent.mx_in()
    D_m, y_m, _, _, *node = eliminate.mx_in()
    R_m, J_m = tangent(*element)
    outputs = eliminate(D_m, y_m, R_m, J_m, *node)
    return ca.Function("forward_step", [D_m, y_m, *element[:4], *node, *element[4:]], [*outputs, R_m])


def _backward_step(m: int) -> ca.Function:
    """(x of the node to the right; W, z) -> x of this node."""
    x, W, z = ca.SX.sym("x", m), ca.SX.sym("W", m, m), ca.SX.sym("z", m)
    return ca.Function("backward_step", [x, W, z], [-z - W @ x])


def _last_solve(m: int) -> ca.Function:
    D, y = ca.SX.sym("D", m, m), ca.SX.sym("y", m)
    return ca.Function("last_solve", [D, y], [-_solve(D, y)])


def _solve(A: ca.SX, b: ca.SX) -> ca.SX:
    """A^-1 b by Gaussian elimination without pivoting, unrolled."""
    A, b = ca.SX(A), ca.SX(b)
    m = A.shape[0]
    for i in range(m):
        pivot = 1 / A[i, i]
        for j in range(i + 1, m):
            factor = A[j, i] * pivot
            A[j, i + 1 :] -= factor * A[i, i + 1 :]
            b[j, :] -= factor * b[i, :]
    for i in reversed(range(m)):
        for j in range(i + 1, m):
            b[i, :] -= A[i, j] * b[j, :]
        b[i, :] /= A[i, i]
    return b
