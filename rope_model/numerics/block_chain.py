"""Block elimination and Newton's method for a chain of equal two-node elements, as CasADi functions.

Element i joins nodes i and i + 1, so the matrix of the chain is block tridiagonal with blocks of the node's size.
Forward elimination carries the Schur complement of everything to the left, back substitution returns:

    W_i = D_i^-1 U_i,   D_{i+1} = J22 - L_i W_i                       factorization
    z_i = D_i^-1 y_i,   y_{i+1} = R_{i+1} - L_i z_i,   y_0 = R_0      for each right hand side
    x_n = -z_n,         x_i = -z_i - W_i x_{i+1}

There is no pivoting beyond the block: the matrices of a time step and of pseudo-transient continuation are nearly
symmetric and positive definite.  Rows and columns of prescribed degrees of freedom are those of the identity.  So their
correction is zero and their residual is the reaction.

Everything is built from CasADi functions of one element; this module knows nothing of the element.  The work per
element is the same in chains of any length and is compiled once: ``chain_parts``.
"""

from functools import partial
from typing import NamedTuple

import casadi as ca

from rope_model.numerics.newton import newton

#: degree of freedom whose reaction presses the bearings at a node, for friction
PRESSED = 1


class ChainParts(NamedTuple):
    """Functions that a chain calls for each element, with m degrees of freedom per node as the element knows them.

    residual ... transport: the element's own, see physics.element
    eliminate:   (D, q, v, a, l, F, free, mass, P, cq, cv, ca, before) -> next D, factors of D, W, L
    factor_last: D -> its factors
    forward:     (y, factors, L, R) -> next y, z
    backward:    (next x, W, z) -> x
    solve_last:  (factors, y) -> the last x
    """

    residual: ca.Function
    balance: ca.Function
    losses: ca.Function
    strains: ca.Function
    momentum: ca.Function
    reference: ca.Function
    transport: ca.Function
    eliminate: ca.Function
    factor_last: ca.Function
    forward: ca.Function
    backward: ca.Function
    solve_last: ca.Function


class ChainFunctions(NamedTuple):
    """CasADi functions of a chain of n elements; arrays are (dof, n + 1), columns are nodes.

    A compiled library and a portable file contain them in this order.  The element may know only some of the ``dof``
    degrees of freedom of a node; the others stay zero.  ``l`` and ``F`` have a column for each element.

    solve:     (q, v, a, R, l, F, load, friction_load, node_mass, free, P, c, scale, tolerance, before, error_fraction)
                -> q, v, a, R, balance, progress
        Solve for q by Newton's method; v and a follow by c[1] and c[2] times the corrections, whose size is the largest
        entry times ``scale`` (dof,).  The first factorization takes the axial strains from the q ``before``.
        ``error_fraction`` and ``progress`` are those of numerics.newton.
    newton_step: (q, v, a, R, l, F, load, friction_load, node_mass, free, P, c) -> correction, R
        Solve J x = -R on the free degrees of freedom, J = c[0] dR/dq + c[1] dR/dv + c[2] dR/da.
    evaluate:  (q, v, a, R, l, F, load, friction_load, node_mass, P) -> R, balance summed over the elements
    losses:    (q, v, l, F, P) -> powers of the balance, summed
    strains:   (q, v, l, F) -> one column per element
    momentum:  (q, v, l, P) -> momentum, summed over the elements
    reference: (q, l) -> F
    transport: (q, v, a, l, F) -> one column per element

    ``load`` is dead load, ``friction_load`` the load per unit of the last known reaction R in direction 1 of the same
    node, ``node_mass`` are concentrated masses (inertias).
    """

    solve: ca.Function
    newton_step: ca.Function
    evaluate: ca.Function
    losses: ca.Function
    strains: ca.Function
    momentum: ca.Function
    reference: ca.Function
    transport: ca.Function


def chain_parts(tangent: ca.Function, *own: ca.Function) -> ChainParts:
    """Build the parts of all chains of an element from its ``tangent`` and its ``own`` functions, in their order."""
    m = own[0].size1_in(0) // 2
    return ChainParts._make((*own, *_elimination(tangent, m), *_substitution(m)))


def chain_functions(n: int, parts: ChainParts, dof: int, rows: tuple[int, ...]) -> ChainFunctions:
    """Build the functions for ``n`` elements that know the degrees of freedom ``rows`` of a node's ``dof``."""
    m, parameters = len(rows), parts.residual.size1_in(5)
    names = ("q", "v", "a", "R", "load", "friction_load", "node_mass", "free")
    q, v, a, R, load, friction_load, node_mass, free = (ca.MX.sym(name, m, n + 1) for name in names)
    l, P, c, scale = (
        ca.MX.sym("l", 1, n),
        ca.MX.sym("P", parameters),
        ca.MX.sym("c", 3),
        ca.MX.sym("scale", m),
    )
    before = ca.MX.sym("before", m, n + 1)
    tolerance, error_fraction = ca.MX.sym("tolerance"), ca.MX.sym("error_fraction")
    F, Ps = ca.MX.sym("F", parts.residual.size1_in(4), n), ca.repmat(P, 1, n)
    factorize, substitute = _factorize(n, parts, m), _substitute(n, parts, m)

    def nodal(a: ca.MX, R: ca.MX) -> ca.MX:
        return node_mass * a - load - friction_load * ca.repmat(ca.fmax(R[PRESSED, :], 0), m, 1)

    residual_map, balance_map = parts.residual.map(n), parts.balance.map(n)

    def residual(q: ca.MX, v: ca.MX, a: ca.MX, R: ca.MX) -> ca.MX:
        R_e, zero = residual_map(*(_both_ends(x) for x in (q, v, a)), l, F, Ps), ca.MX.zeros(m, 1)
        return ca.horzcat(R_e[:m, :], zero) + ca.horzcat(zero, R_e[m:, :]) + nodal(a, R)

    # x of Newton's method contains q, v, a, R and before side by side
    x = ca.MX.sym("x", m, 5 * (n + 1))
    motions = ca.horzsplit(x, n + 1)
    fixed = [l, F, load, friction_load, node_mass, free, P, c, scale]
    factors = [ca.MX.sym(f"factor{i}", factorize.sparsity_out(i)) for i in range(factorize.n_out())]
    new_factors = factorize(*motions[:3], l, F, node_mass, free, P, c, motions[4])
    step = substitute(*factors, free * motions[3])
    weighted = ca.vec(step * ca.repmat(scale, 1, n + 1))
    # the maximum norm ignores NaN, the sum of squares does not
    norm = ca.if_else(ca.sumsqr(weighted) < ca.inf, ca.norm_inf(weighted), ca.inf)
    dx = ca.MX.sym("dx", m, n + 1)
    q_x, v_x, a_x = (part + c[i] * dx for i, part in enumerate(motions[:3]))
    iteration = newton(
        ca.Function("factorize", [x, *fixed], list(new_factors)),
        ca.Function("correct", [x, *factors, *fixed], [step, norm]),
        ca.Function(
            "apply",
            [x, dx, *fixed],
            [ca.horzcat(q_x, v_x, a_x, residual(q_x, v_x, a_x, motions[3]), q_x)],
        ),
    )
    solution, progress = iteration(
        ca.horzcat(q, v, a, residual(q, v, a, R), before), *fixed, tolerance, error_fraction
    )
    solved = ca.horzsplit(solution, n + 1)

    def sums(q: ca.MX, v: ca.MX) -> ca.MX:
        return ca.sum2(balance_map(_both_ends(q), _both_ends(v), l, F, Ps))

    R_a = residual(q, v, a, R)
    correction = substitute(*factorize(q, v, a, l, F, node_mass, free, P, c, q), free * R_a)
    losses = ca.sum2(parts.losses.map(n)(_both_ends(q), _both_ends(v), l, F, Ps))
    strains = parts.strains.map(n)(_both_ends(q), _both_ends(v), l, F)
    momentum = ca.sum2(parts.momentum.map(n)(_both_ends(q), _both_ends(v), l, Ps))
    reference = parts.reference.map(n)(_both_ends(q), l)
    transport = parts.transport.map(n)(*(_both_ends(x) for x in (q, v, a)), l, F)
    system = {"l": l, "F": F, "load": load, "friction_load": friction_load, "node_mass": node_mass}
    motion = {"q": q, "v": v, "a": a, "R": R}
    method = {"free": free, "P": P, "c": c}
    limits = {
        "scale": scale,
        "tolerance": tolerance,
        "before": before,
        "error_fraction": error_fraction,
    }
    after = dict(zip(("q", "v", "a", "R"), solved[:4], strict=True))

    function = partial(_widen, dof, rows)
    return ChainFunctions(
        solve=function(
            "solve",
            motion | system | method | limits,
            after | {"balance": sums(solved[0], solved[1]), "progress": progress},
            carried=("q", "v", "a"),
        ),
        newton_step=function("newton_step", motion | system | method, {"q": correction, "R": R_a}),
        evaluate=function(
            "evaluate", motion | system | {"P": P}, {"R": R_a, "balance": sums(q, v)}
        ),
        losses=function("losses", {"q": q, "v": v, "l": l, "F": F, "P": P}, {"powers": losses}),
        strains=function("strains", {"q": q, "v": v, "l": l, "F": F}, {"strains": strains}),
        momentum=function("momentum", {"q": q, "v": v, "l": l, "P": P}, {"sums": momentum}),
        reference=function("reference", {"q": q, "l": l}, {"F": reference}),
        transport=function(
            "transport", {"q": q, "v": v, "a": a, "l": l, "F": F}, {"transport": transport}
        ),
    )


#: names of arguments and results with a row for each degree of freedom of a node
_NODAL = ("q", "v", "a", "R", "load", "friction_load", "node_mass", "free", "scale", "before")


def _widen(
    dof: int,
    rows: tuple[int, ...],
    name: str,
    inputs: dict[str, ca.MX],
    outputs: dict[str, ca.MX],
    carried: tuple[str, ...] = (),
) -> ca.Function:
    """Build a function with all ``dof`` rows from ``outputs`` of ``inputs``, which have the ``rows`` only.

    Other degrees of freedom are ignored; in a result they are zero, or unchanged where it is one of ``carried``.
    """
    narrow = ca.Function(name, [*inputs.values()], [*outputs.values()])
    if rows == tuple(range(dof)):
        return narrow
    wide = {
        key: ca.MX.sym(key, dof if key in _NODAL else x.shape[0], x.shape[1])
        for key, x in inputs.items()
    }
    results = narrow.call([x[list(rows), :] if key in _NODAL else x for key, x in wide.items()])
    for i, key in enumerate(outputs):
        if key in _NODAL:
            y = ca.MX(wide[key]) if key in carried else ca.MX.zeros(dof, results[i].shape[1])
            y[list(rows), :] = results[i]
            results[i] = y
    return ca.Function(name, [*wide.values()], results)


def _both_ends(x: ca.MX) -> ca.MX:
    return ca.vertcat(x[:, :-1], x[:, 1:])


def _elimination(tangent: ca.Function, m: int) -> tuple[ca.Function, ca.Function]:
    """Build ``eliminate``, with the element's tangent and the elimination of its left node, and ``factor_last``."""
    D, J = ca.SX.sym("D", m, m), ca.SX.sym("J", 2 * m, 2 * m)
    both, mass = ca.SX.sym("free", 2 * m), ca.SX.sym("mass", m)
    J_f = J * (both @ both.T)
    factor = _factor(D + J_f[:m, :m])
    W = _solve(factor, J_f[:m, m:])
    next_D = J_f[m:, m:] + ca.diag(both[m:] * mass + 1 - both[m:]) - J_f[m:, :m] @ W
    block = ca.Function("eliminate", [D, J, both, mass], ca.cse([next_D, factor, W, J_f[m:, :m]]))
    D_m, _, both_m, mass_m = block.mx_in()
    element = tangent.mx_in()
    out = block(D_m, tangent(*element)[1], both_m, mass_m)
    A = ca.SX.sym("A", m, m)
    return (
        ca.Function("eliminate_node", [D_m, *element[:5], both_m, mass_m, *element[5:]], [*out]),
        ca.Function("factor_last", [A], [_factor(A)]),
    )


def _factorize(n: int, parts: ChainParts, m: int) -> ca.Function:
    """Build (q, v, a, l, F, node_mass, free, P, c, before) -> factors of n eliminated blocks, W, L, last factors."""
    names = ("q", "v", "a", "node_mass", "free", "before")
    q, v, a, node_mass, free, before = (ca.MX.sym(s, m, n + 1) for s in names)
    l, F = ca.MX.sym("l", 1, n), ca.MX.sym("F", parts.residual.size1_in(4), n)
    P, c = ca.MX.sym("P", parts.residual.size1_in(5)), ca.MX.sym("c", 3)
    diagonal = c[2] * node_mass
    Ds, factors, Ws, Ls = parts.eliminate.mapaccum("factor_sweep", n)(
        ca.diag(free[:, 0] * diagonal[:, 0] + 1 - free[:, 0]),
        *(_both_ends(x) for x in (q, v, a)),
        l,
        F,
        _both_ends(free),
        diagonal[:, 1:],
        ca.repmat(P, 1, n),
        *(ca.repmat(c[i], 1, n) for i in range(3)),
        _both_ends(before),
    )
    last = parts.factor_last(Ds[:, -m:])
    return ca.Function(
        "factorized", [q, v, a, l, F, node_mass, free, P, c, before], [factors, Ws, Ls, last]
    )


def _substitution(m: int) -> tuple[ca.Function, ca.Function, ca.Function]:
    """Build ``forward``, ``backward`` and ``solve_last`` of ChainParts."""
    F, W, L = (ca.SX.sym(s, m, m) for s in "FWL")
    y, r, z, x = (ca.SX.sym(s, m) for s in "yrzx")
    z_y = _solve(F, y)
    return (
        ca.Function("forward", [y, F, L, r], ca.cse([r - L @ z_y, z_y])),
        ca.Function("backward", [x, W, z], [-z - W @ x]),
        ca.Function("solve_last", [F, y], [-z_y]),
    )


def _substitute(n: int, parts: ChainParts, m: int) -> ca.Function:
    """Build (factors, R (m, n + 1)) -> x (m, n + 1) with J x = -R."""
    forward, backward = (
        parts.forward.mapaccum("forward_sweep", n),
        parts.backward.mapaccum("backward_sweep", n),
    )
    Fs, Ws, Ls = (ca.MX.sym(s, m, m * n) for s in ("Fs", "Ws", "Ls"))
    last, R = ca.MX.sym("last", m, m), ca.MX.sym("R", m, n + 1)
    ys, zs = forward(R[:, 0], Fs, Ls, R[:, 1:])
    order = list(range(n - 1, -1, -1))
    columns = [i * m + j for i in order for j in range(m)]
    x_n = parts.solve_last(last, ys[:, -1])
    xs = backward(x_n, Ws[:, columns], zs[:, order])
    return ca.Function("substitute", [Fs, Ws, Ls, last, R], [ca.horzcat(xs[:, order], x_n)])


def _factor(A: ca.SX) -> ca.SX:
    """Return the unrolled LU factors of A without pivoting; the diagonal contains the inverse pivots."""
    A = ca.SX(A)
    for i in range(A.shape[0]):
        A[i, i] = 1 / A[i, i]
        for j in range(i + 1, A.shape[0]):
            A[j, i] *= A[i, i]
            A[j, i + 1 :] -= A[j, i] * A[i, i + 1 :]
    return A


def _solve(F: ca.SX, b: ca.SX) -> ca.SX:
    """Return A^-1 b from the factors ``F`` of A."""
    b, m = ca.SX(b), F.shape[0]
    for i in range(m):
        for j in range(i):
            b[i, :] -= F[i, j] * b[j, :]
    for i in reversed(range(m)):
        for j in range(i + 1, m):
            b[i, :] -= F[i, j] * b[j, :]
        b[i, :] *= F[i, i]
    return b
