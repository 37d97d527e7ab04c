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
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np

from . import costello
from .frame import FrameRate, smallest_rotation_rate

NODE_DOF = 7
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
    """The element as CasADi functions; q, v, a are (14,), ``l`` the reference length in m, ``P`` see PARAMETERS.

    residual: (q, v, a, l, P) -> R (14,): inertia + internal - gravity, what external loads must balance
    tangent:  (q, v, a, l, P, cq, cv, ca) -> R, J (14, 14): J = cq dR/dq + cv dR/dv + ca dR/da
    balance:  (q, v, l, P) -> (9,), see BALANCE
    strains:  (q, l, P) -> (4,), see STRAINS
    """

    residual: ca.Function
    tangent: ca.Function
    balance: ca.Function
    strains: ca.Function


@cache
def element_functions(frame_rate: FrameRate = smallest_rotation_rate) -> ElementFunctions:
    """Build the four functions; a second call with the same frame returns the same objects."""
    q, v, a = ca.SX.sym("q", 14), ca.SX.sym("v", 14), ca.SX.sym("a", 14)
    l, P = ca.SX.sym("l"), ca.SX.sym("P", len(PARAMETERS))
    cq, cv, c_a = ca.SX.sym("cq"), ca.SX.sym("cv"), ca.SX.sym("ca")

    point = _point_functions(frame_rate)
    mass, weight = _translational_mass(l, P), _weight(l, P)
    R = mass @ a - weight
    J = c_a * mass
    balance = ca.SX.zeros(len(BALANCE))
    balance[4] = 0.5 * ca.dot(v, mass @ v)
    balance[6] = -ca.dot(weight, q)
    strains = ca.SX.zeros(len(STRAINS))
    for xi, weight_xi in zip(0.5 * (1 + _GAUSS_POINTS), 0.5 * _GAUSS_WEIGHTS, strict=True):
        B = _interpolation(xi, l)
        dx = weight_xi * l
        R_p, J_p = point["tangent"](B @ q, B @ v, B @ a, P, cq, cv, c_a)
        R += dx * (B.T @ R_p)
        J += dx * (B.T @ J_p @ B)
        balance += dx * point["balance"](B @ q, B @ v, P)
        strains += weight_xi * point["strains"](B @ q, P)
    strains[2:] = ca.sqrt(strains[2:])

    def function(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
        return ca.Function(name, inputs, ca.cse(outputs))

    return ElementFunctions(
        residual=function("element_residual", [q, v, a, l, P], [R]),
        tangent=function("element_tangent", [q, v, a, l, P, cq, cv, c_a], [R, J]),
        balance=function("element_balance", [q, v, l, P], [balance]),
        strains=function("element_strains", [q, l, P], [strains]),
    )


def _point_functions(frame_rate: FrameRate) -> dict[str, ca.Function]:
    """The continuum at one point: z = (r', r'', theta', theta), its rates, and the work-conjugate forces (8,)."""
    z, z_t, z_tt = ca.SX.sym("z", 8), ca.SX.sym("z_t", 8), ca.SX.sym("z_tt", 8)
    P = ca.SX.sym("P", len(PARAMETERS))
    cq, cv, c_a = ca.SX.sym("cq"), ca.SX.sym("cv"), ca.SX.sym("ca")
    _, _, Qa, Qs, Qk, Qd, EI, rhoJ, beta_K = ca.vertsplit(P)[:9]
    pole = P[9:12]

    # strains, and the spin of the section
    d, c, theta_x = z[0:3], z[3:6], z[6]
    e = ca.norm_2(d) - 1
    tau = theta_x + frame_rate(pole, d, c)
    k = ca.cross(d, c) / ca.dot(d, d)
    w = z_t[7] + frame_rate(pole, d, z_t[0:3])

    # their rates; the curvature's as seen from the section
    e_t, tau_t, k_t = (ca.jtimes(strain, z, z_t) for strain in (e, tau, k))
    turning = ca.cross(d, z_t[0:3]) / ca.dot(d, d) + w * d / ca.norm_2(d)
    k_t -= ca.cross(turning, k)

    # energies, and Lagrange's equation
    U = costello.strain_energy(Qa, Qs, Qd, e, tau) + 0.5 * EI * ca.dot(k, k)
    D = beta_K * (costello.strain_energy(Qa, Qs, Qd, e_t, tau_t) + 0.5 * EI * ca.dot(k_t, k_t))
    K = 0.5 * rhoJ * w * w
    momentum = ca.gradient(K, z_t)
    inertia = ca.jtimes(momentum, z_t, z_tt) + ca.jtimes(momentum, z, z_t) - ca.gradient(K, z)
    remainder = ca.gradient(costello.nonconservative_power(Qk, e, tau, e_t, tau_t), z_t)
    force = ca.gradient(U, z) + ca.gradient(D, z_t) + remainder + inertia

    # one jacobian for the combination of stiffness, damping and mass that the integrator asks for
    s = ca.SX.sym("s", 8)
    along = ca.substitute(force, ca.vertcat(z, z_t, z_tt), ca.vertcat(z + cq * s, z_t + cv * s, z_tt + c_a * s))
    J = ca.substitute(ca.jacobian(along, s), s, ca.SX.zeros(8))

    balance = ca.vertcat(
        0.5 * Qa * e * e,
        Qs * e * tau,
        0.5 * Qd * tau * tau,
        0.5 * EI * ca.dot(k, k),
        0,
        K,
        0,
        2 * D,
        costello.nonconservative_power(Qk, e, tau, e_t, tau_t),
    )
    return {
        "tangent": ca.Function("point_tangent", [z, z_t, z_tt, P, cq, cv, c_a], ca.cse([force, J])),
        "balance": ca.Function("point_balance", [z, z_t, P], ca.cse([balance])),
        "strains": ca.Function("point_strains", [z, P], [ca.vertcat(e, tau, ca.dot(k, k), tau * tau)]),
    }


def _interpolation(xi: float, l: ca.SX) -> ca.SX:
    """(8, 14) sparse: (r', r'', theta', theta) at xi = x/l from the element's degrees of freedom."""
    slope = ((6 * xi * xi - 6 * xi) / l, 1 - 4 * xi + 3 * xi * xi, (6 * xi - 6 * xi * xi) / l, 3 * xi * xi - 2 * xi)
    bend = ((12 * xi - 6) / l**2, (6 * xi - 4) / l, (6 - 12 * xi) / l**2, (6 * xi - 2) / l)
    B = ca.SX(8, 14)
    for i in range(3):
        for column, s, b in zip((i, 3 + i, 7 + i, 10 + i), slope, bend, strict=True):
            B[i, column], B[3 + i, column] = s, b
    B[6, 6], B[6, 13] = -1 / l, 1 / l
    B[7, 6], B[7, 13] = 1 - xi, xi
    return B


def _translational_mass(l: ca.SX, P: ca.SX) -> ca.SX:
    """(14, 14) consistent mass of the cubic Hermite interpolation, kg."""
    hermite = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420
    power = np.array([[1, 2, 1, 2], [2, 3, 2, 3], [1, 2, 1, 2], [2, 3, 2, 3]])
    M = ca.SX(14, 14)
    for i in range(3):
        at = (i, 3 + i, 7 + i, 10 + i)
        for m in range(4):
            for n in range(4):
                M[at[m], at[n]] = P[0] * hermite[m, n] * l ** int(power[m, n])
    return M


def _weight(l: ca.SX, P: ca.SX) -> ca.SX:
    """(14,) work-equivalent weight, N and N m."""
    f = ca.SX(14, 1)
    f[1], f[4], f[8], f[11] = (-P[0] * P[1] * s for s in (l / 2, l**2 / 12, l / 2, -(l**2) / 12))
    return f
