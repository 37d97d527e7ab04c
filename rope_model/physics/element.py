"""Torsion-deformable spatial beam element with 14 degrees of freedom, written once in CasADi.

Per node: position r (3), its derivative r' (3) with respect to reference arc length, angle theta (1).  Between the
nodes r is the cubic Hermite interpolant and theta is linear.  With t = r'/|r'|

    e     = |r'| - 1                    axial strain
    k     = r' x r'' / |r'|^2           curvature vector, per reference length
    tau   = theta' + frame(r', r'')     torsional strain
    w     = theta_t + frame(r', r'_t)   spin about the tangent

    U = int Costello energy(e, tau) + 1/2 EI |k|^2 dx
    K = int 1/2 rho |r_t|^2 + 1/2 rhoJ w^2 dx
    V = int rho g r_Y dx
    D = int beta_K times the quadratic form of U in the strain rates dx         (dissipates 2 D)

The rate of k is the one seen by an observer who turns with the cross-section, so that rigid motion dissipates
nothing.  Lagrange's equation gives the residual; everything else is a derivative of it.  Three Gauss points: two
leave an hourglass mode in the axial strain.

The fidelities of the model are this one text with degrees of freedom left out:

    torsional   r, r', theta     complete
    spatial     r, r'            no torsion: tau = 0, w = 0, no torque
    planar      r, r' in X, Y    the same in the plane
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import casadi as ca
import numpy as np

from . import costello
from .frame import FrameRate, smallest_rotation_rate
from .hermite import PRODUCTS

NODE_DOF = 7
ElementFidelity = Literal["torsional", "spatial", "planar"]
#: the degrees of freedom of a node that a fidelity keeps
ELEMENT_DOF: dict[ElementFidelity, tuple[int, ...]] = {
    "torsional": (0, 1, 2, 3, 4, 5, 6),
    "spatial": (0, 1, 2, 3, 4, 5),
    "planar": (0, 1, 3, 4),
}
#: order of the entries of the parameter vector
PARAMETERS = ("rho", "g", "Qa", "Qs", "Qk", "Qd", "EI", "rhoJ", "beta_K", "pole_x", "pole_y", "pole_z")
#: order of the entries of an element's balance
BALANCE = (
    "axial",  # J, 1/2 Qa e^2
    "coupling",  # J, Qs e tau
    "torsion",  # J, 1/2 Qd tau^2
    "bending",  # J, 1/2 EI k^2
    "kinetic",  # J, translation
    "spin",  # J, rotation about the tangent
    "gravity",  # J, zero at Y = 0
    "damping_power",  # W, dissipated, never negative
    "nonconservative_power",  # W, taken up by the part of the Costello law that has no energy
)
#: what one element's strain output holds: mean over the element, and root mean square of k and tau
STRAINS = ("e", "tau", "k_rms", "tau_rms")

_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class ElementFunctions:
    """The element as CasADi functions; q, v, a are (2 m,) with m degrees of freedom of a node, 7 for ``torsional``.

    ``l`` is the reference length in m, ``P`` see PARAMETERS.

    residual: (q, v, a, l, P) -> R (2 m,): inertia + internal - gravity, what external loads must balance
    tangent:  (q, v, a, l, P, cq, cv, ca) -> R, J (2 m, 2 m): J = cq dR/dq + cv dR/dv + ca dR/da at rest, symmetric;
              for Newton's method also in motion, where it leaves out how q and v change damping and spin inertia
    balance:  (q, v, l, P) -> (9,), see BALANCE
    losses:   (q, v, l, P) -> (2,), the two powers of the balance alone
    strains:  (q, l, P) -> (4,), see STRAINS
    """

    residual: ca.Function
    tangent: ca.Function
    balance: ca.Function
    losses: ca.Function
    strains: ca.Function


@cache
def element_functions(
    fidelity: ElementFidelity = "torsional", frame_rate: FrameRate = smallest_rotation_rate
) -> ElementFunctions:
    """Build the functions; a second call with the same arguments returns the same objects."""
    kept = [*ELEMENT_DOF[fidelity], *(NODE_DOF + i for i in ELEMENT_DOF[fidelity])]
    symbols = [ca.SX.sym(name, len(kept)) for name in ("q", "v", "a")]
    q, v, a = (ca.SX.zeros(2 * NODE_DOF) for _ in symbols)
    for x, symbol in zip((q, v, a), symbols, strict=True):
        x[kept] = symbol
    l, P = ca.SX.sym("l"), ca.SX.sym("P", len(PARAMETERS))
    cq, cv, c_a = ca.SX.sym("cq"), ca.SX.sym("cv"), ca.SX.sym("ca")

    point = _point_functions(frame_rate, fidelity == "torsional")
    mass, weight = _translational_mass(l, P), _weight(l, P)
    balance, strains = ca.SX.zeros(len(BALANCE)), ca.SX.zeros(len(STRAINS))
    balance[4], balance[6] = 0.5 * ca.dot(v, mass @ v), -ca.dot(weight, q)
    # everything but weight and translation depends on the 11 relative coordinates r2 - r1, r', theta only
    relative = _relative()
    R_r, J_r = ca.SX.zeros(11), ca.SX.zeros(11, 11)
    for xi, weight_xi in zip(0.5 * (1 + _GAUSS_POINTS), 0.5 * _GAUSS_WEIGHTS, strict=True):
        B = _interpolation(xi, l)
        z, z_t, z_tt = (B @ relative @ x for x in (q, v, a))
        R_p, J_p = point["tangent"](z, z_t, z_tt, P, cq, cv, c_a)
        dx = weight_xi * l
        R_r += B.T @ (dx * R_p)
        J_r += B.T @ (dx * J_p) @ B
        balance += dx * point["balance"](z, z_t, P)
        strains += weight_xi * point["strains"](z, P)
    R = (mass @ a - weight + relative.T @ R_r)[kept]
    J = _symmetric(c_a * mass + relative.T @ _symmetric(J_r) @ relative)[kept, kept]
    strains[2:] = ca.sqrt(strains[2:])

    def function(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
        return ca.Function(name, inputs, ca.cse(outputs))

    q, v, a = symbols
    return ElementFunctions(
        residual=function("element_residual", [q, v, a, l, P], [R]),
        tangent=function("element_tangent", [q, v, a, l, P, cq, cv, c_a], [R, J]),
        balance=function("element_balance", [q, v, l, P], [balance]),
        losses=function("element_losses", [q, v, l, P], [balance[7:]]),
        strains=function("element_strains", [q, l, P], [strains]),
    )


def _point_functions(frame_rate: FrameRate, torsional: bool) -> dict[str, ca.Function]:
    """The continuum at one point: z = (r', r'', theta', theta), its rates, and the work-conjugate forces (8,)."""
    z, z_t, z_tt = ca.SX.sym("z", 8), ca.SX.sym("z_t", 8), ca.SX.sym("z_tt", 8)
    P = ca.SX.sym("P", len(PARAMETERS))
    cq, cv, c_a = ca.SX.sym("cq"), ca.SX.sym("cv"), ca.SX.sym("ca")
    _, _, Qa, Qs, _, Qd, EI, rhoJ, _ = ca.vertsplit(P)[:9]
    pole = P[9:12]

    # strains, and the spin of the section
    d, c, theta_x = z[0:3], z[3:6], z[6]
    tau = theta_x + frame_rate(pole, d, c) if torsional else ca.SX(0)
    strain = ca.vertcat(ca.norm_2(d) - 1, tau, ca.cross(d, c) / ca.dot(d, d))
    w = z_t[7] + frame_rate(pole, d, z_t[0:3]) if torsional else ca.SX(0)

    # their rates; the curvature's as seen from the section
    turning = ca.cross(d, z_t[0:3]) / ca.dot(d, d) + w * d / ca.norm_2(d)
    rate = ca.jtimes(strain, z, z_t) - ca.vertcat(0, 0, ca.cross(turning, strain[2:]))

    # energies, and the stresses that are work-conjugate to the strains
    e, e_t = ca.SX.sym("e", 5), ca.SX.sym("e_t", 5)
    U, D, P_n = _energies(P, e, e_t)
    K = 0.5 * rhoJ * w * w
    stress = ca.gradient(U, e) + ca.gradient(D + P_n, e_t)

    # Lagrange's equation: internal forces B^T stress (the turning does no work on EI k), inertia of the spin
    B = ca.jacobian(rate, z_t)
    momentum = ca.gradient(K, z_t)
    inertia = ca.jtimes(momentum, z_t, z_tt) + ca.jtimes(momentum, z, z_t) - ca.gradient(K, z)
    values = [strain, rate]
    force = B.T @ ca.substitute(stress, ca.vertcat(e, e_t), ca.vertcat(*values)) + inertia

    # its derivative along (cq, cv, ca), exact at rest; how motion changes damping and spin inertia is left out
    put = ca.vertcat(e, e_t), ca.vertcat(*values)
    damping = ca.substitute(ca.jacobian(stress, e_t), *put)
    stiffness = ca.hessian(ca.substitute(U, *put), z)[0]
    J = _symmetric(cq * stiffness + cv * (B.T @ damping @ B) + c_a * ca.jacobian(momentum, z_t))

    k = strain[2:]
    balance = ca.vertcat(
        0.5 * Qa * strain[0] ** 2,
        Qs * strain[0] * strain[1],
        0.5 * Qd * strain[1] ** 2,
        0.5 * EI * ca.dot(k, k),
        0,
        K,
        0,
        ca.substitute(2 * D, *put),
        ca.substitute(P_n, *put),
    )
    return {
        "tangent": ca.Function("point_tangent", [z, z_t, z_tt, P, cq, cv, c_a], ca.cse([force, J])),
        "balance": ca.Function("point_balance", [z, z_t, P], ca.cse([balance])),
        "strains": ca.Function("point_strains", [z, P], [ca.vertcat(strain[:2], ca.dot(k, k), strain[1] ** 2)]),
    }


def _symmetric(A: ca.SX) -> ca.SX:
    """A symmetric matrix from its upper half: the lower need not be computed."""
    return ca.triu2symm(ca.triu(A))


def _energies(P: ca.SX, strain: ca.SX, rate: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """U, D and the non-conservative power, per reference length, from the strains (e, tau, k) and their rates."""
    _, _, Qa, Qs, Qk, Qd, EI, _, beta_K = ca.vertsplit(P)[:9]

    def quadratic(x: ca.SX) -> Any:
        return costello.strain_energy(Qa, Qs, Qd, x[0], x[1]) + 0.5 * EI * ca.dot(x[2:], x[2:])

    power = costello.nonconservative_power(Qk, strain[0], strain[1], rate[0], rate[1])
    return quadratic(strain), beta_K * quadratic(rate), power


def _relative() -> ca.DM:
    """(11, 14): r2 - r1, r1', r2', theta1, theta2 from the element's degrees of freedom."""
    T = ca.DM(11, 14)
    for i in range(3):
        T[i, i], T[i, 7 + i], T[3 + i, 3 + i], T[6 + i, 10 + i] = -1, 1, 1, 1
    T[9, 6], T[10, 13] = 1, 1
    return T


def _interpolation(xi: float, l: ca.SX) -> ca.SX:
    """(8, 11) sparse: (r', r'', theta', theta) at xi = x/l from the relative coordinates."""
    slope = (6 * xi - 6 * xi * xi) / l, 1 - 4 * xi + 3 * xi * xi, 3 * xi * xi - 2 * xi
    bend = (6 - 12 * xi) / l**2, (6 * xi - 4) / l, (6 * xi - 2) / l
    B = ca.SX(8, 11)
    for i in range(3):
        for block in range(3):
            B[i, 3 * block + i], B[3 + i, 3 * block + i] = slope[block], bend[block]
    B[6, 9], B[6, 10] = -1 / l, 1 / l
    B[7, 9], B[7, 10] = 1 - xi, xi
    return B


def _translational_mass(l: ca.SX, P: ca.SX) -> ca.SX:
    """(14, 14) consistent mass of the cubic Hermite interpolation, kg."""
    M = ca.SX(14, 14)
    for i in range(3):
        at = (i, 3 + i, 7 + i, 10 + i)
        for m in range(4):
            for n in range(4):
                M[at[m], at[n]] = P[0] * (PRODUCTS[m][n] / 420) * l ** (1 + m % 2 + n % 2)
    return M


def _weight(l: ca.SX, P: ca.SX) -> ca.SX:
    """(14,) work-equivalent weight, N and N m."""
    f = ca.SX(14, 1)
    f[1], f[4], f[8], f[11] = (-P[0] * P[1] * s for s in (l / 2, l**2 / 12, l / 2, -(l**2) / 12))
    return f
