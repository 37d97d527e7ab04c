"""Torsion-deformable spatial beam element with 14 degrees of freedom, written once in CasADi.

Per node: position r (3), its derivative r' (3) with respect to reference arc length, angle theta
(1).  Between the nodes r is the cubic Hermite interpolant and theta is linear.  With t = r'/|r'|

    e     = |r'| - 1                           axial strain
    k     = r' x r'' / |r'|^2                  curvature vector, per reference length
    tau   = theta' + mean of frame(r', r'')    torsional strain
    w     = theta_t + frame(r', r'_t)          spin about the tangent

    U = int Costello energy(e, tau) + 1/2 EI |k|^2 dx
    K = int 1/2 rho |r_t|^2 + 1/2 rhoJ w^2 + 1/2 rhoJ_x l^2 theta_t'^2 dx
    V = int rho g r_Y dx
    D = int beta_K U(e_t, sqrt(a) tau_t, sqrt(b) k_t) dx, without Qe                (dissipates 2 D)

The rate of k is the one seen by an observer who turns with the cross-section, so that rigid motion
dissipates nothing.  Lagrange's equation gives the residual; everything else is a derivative of it.
Three Gauss points: two leave an hourglass mode in the axial strain.

A torsional wave of wave number k would run too fast by (k l)^2 / 24, because theta is linear.
Coupling adds as much and more, because e is continuous and cannot follow a tau that is not.  In
Rayleigh's quotient with a wave that is exact at the nodes both are (k l)^2 (Qd / 12 - c^2 rhoJ_x),
c the wave's own speed: the inertia rhoJ_x = Qd / (12 c^2) of theta's slope takes them away, and
leaves an error of fourth order.  It is too much for the little torsion of a longitudinal wave,
which runs too slow by 8e-4 (k l)^2 with the default rope.

tau is uniform in the element: the turn of the angles from node to node, over its length.  So the
frame's reference (physics.frame) leaves energies and forces alone, but for the quadrature of that
mean.

The fidelities of the model are this one text with degrees of freedom left out:

    torsional   r, r', theta     complete
    spatial     r, r'            no torsion: tau = 0, w = 0, no torque
    planar      r, r' in X, Y    the same in the plane
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np

from rope_model.parameters import Rope
from rope_model.physics import costello
from rope_model.physics.elementary import Scalar, less, sqrt, where
from rope_model.physics.frame import FrameRate, smallest_rotation_rate
from rope_model.physics.hermite import PRODUCTS
from rope_model.physics.node import NODE_DOF

ElementFidelity = Literal["torsional", "spatial", "planar"]
#: the degrees of freedom of a node that a fidelity keeps
ELEMENT_DOF: dict[ElementFidelity, tuple[int, ...]] = {
    "torsional": (0, 1, 2, 3, 4, 5, 6),
    "spatial": (0, 1, 2, 3, 4, 5),
    "planar": (0, 1, 3, 4),
}


class ElementParameters(NamedTuple):
    """Entries of the parameter vector P."""

    rho: Any  # kg/m
    g: Any  # m/s^2
    Qa: Any  # N
    Qs: Any  # N m
    Qk: Any  # N m
    Qd: Any  # N m^2
    EI: Any  # N m^2
    rhoJ: Any  # kg m
    beta_K: Any  # s
    root_a: Any  # 1, root of the factor of beta_K for torsion
    root_b: Any  # 1, root of that for bending
    Qe: Any  # N m^2
    rhoJ_x: Any  # kg m, inertia of theta's slope over l^2


PARAMETERS = ElementParameters._fields


def parameters(rope: Rope, gravity: Scalar) -> ElementParameters:
    """Return the parameters of an element of the ``rope``."""
    elastic = rope.mass_per_length, gravity, rope.Qa, rope.Qs, rope.Qk, rope.Qd, rope.EI, rope.rhoJ
    damping = rope.beta_K, sqrt(rope.torsion_damping), sqrt(rope.bending_damping)
    return ElementParameters(*elastic, *damping, rope.Qe, rope.Qd / 12 * torsional_slowness(rope))


def parameters_from(P: ca.SX) -> ElementParameters:
    """Return the entries of P by name."""
    return ElementParameters._make(ca.vertsplit(P))


def torsional_slowness(rope: Rope) -> Scalar:
    """Return 1/c^2 (s^2/m^2) of torsional waves, a root of det [[Qa - rho c^2, Qs], [Qs, Qd - rhoJ c^2]] = 0."""
    axial = rope.Qa * rope.rhoJ
    torsional = rope.Qd * rope.mass_per_length
    slower = axial - torsional
    shared = rope.mass_per_length * rope.rhoJ * (rope.Qs * rope.Qs)
    root = sqrt(slower * slower + 4 * shared)
    return (
        0.5
        * (axial + torsional + where(less(0.0, slower), root, -root))
        / (rope.Qa * rope.Qd - rope.Qs * rope.Qs)
    )


#: energies of an element, in order
ENERGIES = (
    "axial",  # J, 1/2 Qa e^2
    "coupling",  # J, Qs e tau
    "torsion",  # J, 1/2 (Qd + Qe e) tau^2
    "bending",  # J, 1/2 EI k^2
    "kinetic",  # J, translation
    "spin",  # J, rotation about the tangent
    "gravity",  # J, zero at Y = 0
)
#: entries of an element's balance: its energies, then powers
BALANCE = (
    *ENERGIES,
    "damping_power",  # W, dissipated, never negative
    "nonconservative_power",  # W, taken up by the part of the Costello law that has no energy
)
#: entries of one element's momentum: linear, angular about the origin, and first moment of the mass
MOMENTUM = ("px", "py", "pz", "Lx", "Ly", "Lz", "Sx", "Sy", "Sz")
#: entries of one element's strains: means of e and tau over the element, root mean square of k,
#: rates of the means
STRAINS = ("e", "tau", "k_rms", "e_t", "tau_t")
#: number of entries of the reference of an element's frame
FRAME_SIZE = 21

_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(3)
#: Gauss points as element coordinates xi, and weights
POINTS = tuple((0.5 + 0.5 * _GAUSS_POINTS).tolist())
WEIGHTS = tuple((0.5 * _GAUSS_WEIGHTS).tolist())


#: entries of an element's q: angles of both nodes, and r' at the right one
THETAS = [6, NODE_DOF + 6]
RIGHT_SLOPE = slice(NODE_DOF + 3, NODE_DOF + 6)


@dataclass(frozen=True)
class ElementFunctions:
    """CasADi functions of an element; q, v, a are (2 m,) with m degrees of freedom of a node, 7 for ``torsional``.

    ``l`` is the reference length in m, ``P`` see PARAMETERS.  ``F`` describes the frame's
    reference: tangent p and p x p' at each Gauss point, then p at the right node; it has no entries
    without torsion.

    residual:  (q, v, a, l, F, P) -> R (2 m,): inertia + internal - gravity, which external loads must balance
    tangent:   (q, v, a, l, F, P, c_q, c_v, c_a, q_prestress) -> R, J (2 m, 2 m): J = c_q dR/dq + c_v dR/dv + c_a dR/da,
               exact and symmetric at rest if q_prestress is q.  In motion it leaves out how q and v change damping and
               spin inertia.  The axial strains of ``q_prestress`` stiffen the element sideways
    balance:   (q, v, l, F, P) -> BALANCE (9,)
    losses:    (q, v, l, F, P) -> the two powers of the balance (2,)
    strains:   (q, v, l, F) -> STRAINS (5,)
    momentum:  (q, v, l, P) -> MOMENTUM (9,); the angles' rates count as spin, as if q was the reference
    reference: (q, l) -> F
    transport: (q, v, a, l, F) -> increase of the angles when q becomes the reference (3,): of theta from node to node,
               of theta_t and theta_tt at the right node
    """

    residual: ca.Function
    tangent: ca.Function
    balance: ca.Function
    losses: ca.Function
    strains: ca.Function
    momentum: ca.Function
    reference: ca.Function
    transport: ca.Function

    def replaced(self, **terms: tuple[list[Any], list[Any]]) -> "ElementFunctions":
        """Return the element with other functions, each given by its inputs and outputs."""
        return replace(
            self, **{name: ca.Function(f"element_{name}", *x) for name, x in terms.items()}
        )


@cache
def element_functions(
    fidelity: ElementFidelity = "torsional", frame_rate: FrameRate = smallest_rotation_rate
) -> ElementFunctions:
    """Build the functions; a second call with the same arguments returns the same objects."""
    x = _arguments(fidelity)
    point = _point_functions(frame_rate, x.torsional)
    points = _points(x)
    means = _means(x, points, point["means"])
    mass = _translational_mass(x.l, x.P)
    balance = _balance(x, points, means, point["balance"], mass)
    R, J = _forces(x, points, means, point["tangent"], mass)
    strains = ca.vertcat(means.e, means.tau, ca.sqrt(means.k_square), means.e_t, means.tau_t)
    momentum = _momentum(x.q, x.v, mass, x.l, x.P)
    reference = _frame_reference(x, points)
    transport = _transport(x, means, frame_rate)

    def function(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
        return ca.Function(f"element_{name}", inputs, ca.cse(outputs))

    l = x.l
    P = x.P
    F = x.F
    c = [x.c_q, x.c_v, x.c_a]
    q, v, a, q_prestress = x.symbols
    return ElementFunctions(
        residual=function("residual", [q, v, a, l, F, P], [R]),
        tangent=function("tangent", [q, v, a, l, F, P, *c, q_prestress], [R, J]),
        balance=function("balance", [q, v, l, F, P], [balance]),
        losses=function("losses", [q, v, l, F, P], [balance[len(ENERGIES) :]]),
        strains=function("strains", [q, v, l, F], [strains]),
        momentum=function("momentum", [q, v, l, P], [momentum]),
        reference=function("reference", [q, l], [reference]),
        transport=function("transport", [q, v, a, l, F], [transport]),
    )


class _Arguments(NamedTuple):
    """Arguments of an element's functions; q, v, a and q_prestress have zeros where the fidelity has no symbols."""

    torsional: bool
    dofs: list[int]  # entries of q that have symbols
    symbols: list[ca.SX]  # of q, v, a and q_prestress
    q: ca.SX  # (14,)
    v: ca.SX
    a: ca.SX
    q_prestress: ca.SX
    l: ca.SX
    P: ca.SX
    F: ca.SX
    c_q: ca.SX
    c_v: ca.SX
    c_a: ca.SX


class _Point(NamedTuple):
    """Gauss point of an element: weight, interpolation, z = (r', r'', theta) with its rates, and frame's reference."""

    weight: float
    B: ca.SX
    z: ca.SX
    z_t: ca.SX
    z_tt: ca.SX
    F: ca.SX


class _Means(NamedTuple):
    """Strains that an element has as means, with their rates, and the torque that follows."""

    e: ca.SX
    turning: ca.SX  # of the frame, per length
    k_square: ca.SX
    e_t: ca.SX
    tau: ca.SX
    tau_t: ca.SX
    theta_x: ca.SX  # (2,), derivative of theta' with respect to the angles of both nodes
    torque: ca.SX
    elastic: ca.SX  # torque without damping


def _arguments(fidelity: ElementFidelity) -> _Arguments:
    torsional = fidelity == "torsional"
    dofs = [*ELEMENT_DOF[fidelity], *(NODE_DOF + i for i in ELEMENT_DOF[fidelity])]
    symbols = [ca.SX.sym(name, len(dofs)) for name in ("q", "v", "a", "q_prestress")]
    q, v, a, q_prestress = (ca.SX.zeros(2 * NODE_DOF) for _ in symbols)
    for x, symbol in zip((q, v, a, q_prestress), symbols, strict=True):
        x[dofs] = symbol
    return _Arguments(
        torsional=torsional,
        dofs=dofs,
        symbols=symbols,
        q=q,
        v=v,
        a=a,
        q_prestress=q_prestress,
        l=ca.SX.sym("l"),
        P=ca.SX.sym("P", len(PARAMETERS)),
        F=ca.SX.sym("F", FRAME_SIZE if torsional else 0),
        c_q=ca.SX.sym("c_q"),
        c_v=ca.SX.sym("c_v"),
        c_a=ca.SX.sym("c_a"),
    )


def _points(x: _Arguments) -> list[_Point]:
    """Return the Gauss points.

    All terms but weight and translation depend on the 11 relative coordinates r2 - r1, r', theta
    only.
    """
    relative = relative_coordinates()
    B = [interpolation(xi, x.l) for xi in POINTS]
    z, z_t, z_tt = ([B_p @ relative @ y for B_p in B] for y in (x.q, x.v, x.a))
    frames = ca.vertsplit(x.F[:-3], 6) if x.torsional else [x.F] * len(B)
    return [_Point(*point) for point in zip(WEIGHTS, B, z, z_t, z_tt, frames, strict=True)]


def _means(x: _Arguments, points: list[_Point], of_point: ca.Function) -> _Means:
    """Return the means over the element: axial and torsional strain, their rates, the torque that follows."""
    means = sum(
        (point.weight * of_point(point.z, point.z_t, point.F) for point in points),
        start=ca.SX.zeros(5),
    )
    theta_x = ca.vertcat(-1 / x.l, 1 / x.l) if x.torsional else ca.SX.zeros(2)
    tau = means[1] + ca.dot(theta_x, x.q[THETAS])
    tau_t = means[4] + ca.dot(theta_x, x.v[THETAS])
    torque, elastic = _torque(x.P, ca.vertcat(means[0], tau), ca.vertcat(means[3], tau_t))
    return _Means(
        e=means[0],
        turning=means[1],
        k_square=means[2],
        e_t=means[3],
        tau=tau,
        tau_t=tau_t,
        theta_x=theta_x,
        torque=torque,
        elastic=elastic,
    )


def _balance(
    x: _Arguments, points: list[_Point], means: _Means, of_point: ca.Function, mass: ca.SX
) -> ca.SX:
    """Return BALANCE (9,)."""
    balance = ca.SX.zeros(len(BALANCE))
    balance[BALANCE.index("kinetic")] = 0.5 * ca.dot(x.v, mass @ x.v)
    balance[BALANCE.index("gravity")] = -ca.dot(_weight(x.l, x.P), x.q)
    for point in points:
        terms = of_point(point.z, point.z_t, point.F, means.tau, means.tau_t, x.P)
        balance += point.weight * x.l * terms
    if x.torsional:
        slope_rate = ca.dot(means.theta_x, x.v[THETAS])
        balance[BALANCE.index("spin")] += 0.5 * _slope_inertia(x) * slope_rate**2
    return balance


def _forces(
    x: _Arguments, points: list[_Point], means: _Means, of_point: ca.Function, mass: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """Return the residual R (2 m,) and its tangent J (2 m, 2 m)."""
    relative = relative_coordinates()
    l = x.l
    theta_x = means.theta_x
    R_r = ca.SX.zeros(11)
    J_r = ca.SX.zeros(11, 11)
    e_z = ca.SX.zeros(11)
    tau_z = ca.SX.zeros(11)
    tau_z[9:] = theta_x
    shared = (means.tau, means.tau_t, means.torque, means.elastic, x.P, x.c_q, x.c_v, x.c_a)
    for w, B, z, z_t, z_tt, F in points:
        shift = ca.norm_2((B @ relative @ x.q_prestress)[:3]) - ca.norm_2(z[:3])
        R_p, J_p, strains_z = of_point(z, z_t, z_tt, F, *shared, shift)
        R_r += B.T @ (w * l * R_p)
        J_r += B.T @ (w * l * J_p) @ B
        e_z += w * B.T @ strains_z[0, :].T
        tau_z += w * B.T @ strains_z[1, :].T
    R_r[9:] += means.torque * l * theta_x
    if x.torsional:
        slope_inertia = _slope_inertia(x)
        R_r[9:] += slope_inertia * ca.dot(theta_x, x.a[THETAS]) * theta_x
        J_r[9:, 9:] += x.c_a * slope_inertia * (theta_x @ theta_x.T)
    J_r += _tangent_through_means(x, means, e_z, tau_z)
    R = mass @ x.a - _weight(l, x.P) + relative.T @ R_r
    J = symmetric(x.c_a * mass + relative.T @ symmetric(J_r) @ relative)
    return R[x.dofs], J[x.dofs, x.dofs]


def _tangent_through_means(x: _Arguments, means: _Means, e_z: ca.SX, tau_z: ca.SX) -> ca.SX:
    """Return the tangent (11, 11) of the torque through the means, whose gradients are ``e_z`` and ``tau_z``."""
    p = parameters_from(x.P)
    damped = x.c_v * p.beta_K
    root = p.root_a
    growth = x.c_q * p.Qe
    coupling = (x.c_q + damped * root) * p.Qs + growth * means.tau
    torsion = (x.c_q + damped * root * root) * p.Qd + growth * means.e
    shared = coupling * e_z + 0.5 * torsion * tau_z
    tangent: ca.SX = x.l * (shared @ tau_z.T + tau_z @ shared.T)
    return tangent


def _slope_inertia(x: _Arguments) -> ca.SX:
    """Return the inertia of theta's slope, kg m^3."""
    inertia: ca.SX = parameters_from(x.P).rhoJ_x * x.l**3
    return inertia


def _frame_reference(x: _Arguments, points: list[_Point]) -> ca.SX:
    """Return the reference F of a frame whose shape is q."""
    if not x.torsional:
        return x.F
    slope = x.q[RIGHT_SLOPE]
    return ca.vertcat(*(_frame(point.z) for point in points), slope / ca.norm_2(slope))


def _transport(x: _Arguments, means: _Means, frame_rate: FrameRate) -> ca.SX:
    """Return the increase of the angles (3,) when q becomes the reference."""
    if not x.torsional:
        return ca.SX.zeros(3)
    motion = (y[RIGHT_SLOPE] for y in (x.q, x.v, x.a))
    return ca.vertcat(x.l * means.turning, *_spin(frame_rate, x.F[-3:], *motion))


def _point_functions(frame_rate: FrameRate, torsional: bool) -> dict[str, ca.Function]:
    """Build the functions of the continuum at one point z = (r', r'', theta) with work-conjugate forces (7,).

    means:   (z, z_t, F) -> e, turning of the frame, |k|^2, rates of the first two: terms of the element's means
    tangent: forces, their derivatives without the part through tau, and the gradients of e and of the frame's turning;
             ``shift`` is added to the strain e in the tension of the derivative
    """
    z = ca.SX.sym("z", 7)
    z_t = ca.SX.sym("z_t", 7)
    z_tt = ca.SX.sym("z_tt", 7)
    P = ca.SX.sym("P", len(PARAMETERS))
    F = ca.SX.sym("F", 6 if torsional else 0)
    c_q = ca.SX.sym("c_q")
    c_v = ca.SX.sym("c_v")
    c_a = ca.SX.sym("c_a")
    tau, tau_t, torque, elastic, shift = (
        ca.SX.sym(name) for name in ("tau", "tau_t", "torque", "elastic", "shift")
    )
    p = parameters_from(P)

    # strains, and the spin of the section
    d = z[0:3]
    c = z[3:6]
    turning = frame_rate(F[:3], F[3:], d, c) if torsional else ca.SX(0)
    strain = ca.vertcat(ca.norm_2(d) - 1, turning, ca.cross(d, c) / ca.dot(d, d))
    if torsional:
        w = z_t[6] + frame_rate(F[:3], ca.SX.zeros(3), d, z_t[0:3])
    else:
        w = ca.SX(0)

    # strain rates; that of the curvature as seen from the section
    spin = ca.cross(d, z_t[0:3]) / ca.dot(d, d) + w * d / ca.norm_2(d)
    rate = ca.jtimes(strain, z, z_t) - ca.vertcat(0, 0, ca.cross(spin, strain[2:]))

    # energies, and the stresses that are work-conjugate to the strains; the torque is the element's
    e = ca.SX.sym("e", 5)
    e_t = ca.SX.sym("e_t", 5)
    U, D, P_n = _energies(P, e, e_t)
    K = 0.5 * p.rhoJ * w * w
    stress = ca.gradient(U, e) + ca.gradient(D + P_n, e_t)
    stress[1] = torque

    # Lagrange's equation: internal forces B^T stress (the spin does no work on EI k), inertia of
    # the spin
    B = ca.jacobian(rate, z_t)
    momentum = ca.gradient(K, z_t)
    inertia = ca.jtimes(momentum, z_t, z_tt) + ca.jtimes(momentum, z, z_t) - ca.gradient(K, z)
    values = ca.vertcat(e, e_t), ca.vertcat(strain[0], tau, strain[2:], rate[0], tau_t, rate[2:])
    force = B.T @ ca.substitute(stress, *values) + inertia

    # its derivative along (c_q, c_v, c_a), exact at rest; how motion changes damping and spin inertia
    # is left out
    damping = ca.substitute(ca.jacobian(stress, e_t), *values)
    damping[:, 1] = 0
    # potential of the torque, and of the tension without energy, as they bend
    work = (p.Qk * tau + p.Qa * shift) * strain[0] + elastic * turning
    stiffness = ca.hessian(ca.substitute(U, *values) + work, z)[0]
    J = symmetric(c_q * stiffness + c_v * (B.T @ damping @ B) + c_a * ca.jacobian(momentum, z_t))

    k = strain[2:]
    balance = ca.vertcat(
        0.5 * p.Qa * strain[0] ** 2,
        p.Qs * strain[0] * tau,
        0.5 * p.Qd * tau**2 + costello.stiffening_energy(p.Qe, strain[0], tau),
        0.5 * p.EI * ca.dot(k, k),
        0,
        K,
        0,
        ca.substitute(2 * D, *values),
        ca.substitute(P_n, *values),
    )

    def function(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
        return ca.Function(f"point_{name}", inputs, ca.cse(outputs))

    shared = [tau, tau_t, torque, elastic, P, c_q, c_v, c_a]
    return {
        "means": function("means", [z, z_t, F], [ca.vertcat(strain[:2], ca.dot(k, k), rate[:2])]),
        "tangent": function(
            "tangent", [z, z_t, z_tt, F, *shared, shift], [force, J, ca.jacobian(strain[:2], z)]
        ),
        "balance": function("balance", [z, z_t, F, tau, tau_t, P], [balance]),
    }


def _frame(z: ca.SX) -> ca.SX:
    """Return the tangent p and p x p' (6,) at a point z."""
    d = z[0:3]
    c = z[3:6]
    return ca.vertcat(d / ca.norm_2(d), ca.cross(d, c) / ca.dot(d, d))


def _spin(
    frame_rate: FrameRate, p: ca.SX, d: ca.SX, d_t: ca.SX, d_tt: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """Return the spin of the frame where r' is ``d``, and its rate."""
    spin = frame_rate(p, ca.SX.zeros(3), d, d_t)
    return spin, ca.jtimes(spin, d, d_t) + ca.jtimes(spin, d_t, d_tt)


def symmetric(A: ca.SX) -> ca.SX:
    """Return a symmetric matrix from its upper half: the lower half need not be computed."""
    return ca.triu2symm(ca.triu(A))


def _energies(P: ca.SX, strain: ca.SX, rate: ca.SX) -> tuple[Any, Any, Any]:
    """Return U, D and the non-conservative power per reference length, from the strains (e, tau, k) and their rates."""
    p = parameters_from(P)

    def quadratic(x: ca.SX) -> Scalar:
        return costello.strain_energy(p.Qa, p.Qs, p.Qd, x[0], x[1]) + 0.5 * p.EI * ca.dot(
            x[2:], x[2:]
        )

    power = costello.nonconservative_power(p.Qk, strain[0], strain[1], rate[0], rate[1])
    U = quadratic(strain) + costello.stiffening_energy(p.Qe, strain[0], strain[1])
    return (
        U,
        p.beta_K * quadratic(ca.vertcat(rate[0], p.root_a * rate[1], p.root_b * rate[2:])),
        power,
    )


def _torque(P: ca.SX, strain: ca.SX, rate: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the moment conjugate to tau, with and without damping, from the means of e and tau and of their rates."""
    e = ca.SX.sym("e", 5)
    e_t = ca.SX.sym("e_t", 5)
    U, D, P_n = _energies(P, e, e_t)
    elastic = ca.gradient(U, e)[1] + ca.gradient(P_n, e_t)[1]
    no_bending = ca.SX.zeros(3)
    values = ca.vertcat(e, e_t), ca.vertcat(strain, no_bending, rate, no_bending)
    torque, elastic = (
        ca.substitute(x, *values) for x in (elastic + ca.gradient(D, e_t)[1], elastic)
    )
    return torque, elastic


def relative_coordinates() -> ca.DM:
    """Return the matrix (11, 14) from the element's degrees of freedom to r2 - r1, r1', r2', theta1, theta2."""
    T = ca.DM(11, 14)
    for i in range(3):
        T[i, i] = -1
        T[i, 7 + i] = 1
        T[3 + i, 3 + i] = 1
        T[6 + i, 10 + i] = 1
    T[9, 6] = 1
    T[10, 13] = 1
    return T


def interpolation(xi: float, l: ca.SX) -> ca.SX:
    """Return the sparse matrix (7, 11) from the relative coordinates to (r', r'', theta) at ``xi``."""
    slope = (6 * xi - 6 * xi * xi) / l, 1 - 4 * xi + 3 * xi * xi, 3 * xi * xi - 2 * xi
    bend = (6 - 12 * xi) / l**2, (6 * xi - 4) / l, (6 * xi - 2) / l
    B = ca.SX(7, 11)
    for i in range(3):
        for block in range(3):
            B[i, 3 * block + i] = slope[block]
            B[3 + i, 3 * block + i] = bend[block]
    B[6, 9] = 1 - xi
    B[6, 10] = xi
    return B


def _translational_mass(l: ca.SX, P: ca.SX) -> ca.SX:
    """Return the consistent mass matrix (14, 14) of the cubic Hermite interpolation, kg."""
    M = ca.SX(14, 14)
    for i in range(3):
        dofs = (i, 3 + i, 7 + i, 10 + i)
        for m in range(4):
            for n in range(4):
                M[dofs[m], dofs[n]] = (
                    parameters_from(P).rho * (PRODUCTS[m][n] / 420) * l ** (1 + m % 2 + n % 2)
                )
    return M


def _momentum(q: ca.SX, v: ca.SX, mass: ca.SX, l: ca.SX, P: ca.SX) -> ca.SX:
    """Return MOMENTUM (9,), with the spin rhoJ w t, w and t linear in the element, and that of theta's slope."""
    u = mass @ v
    s = mass @ q
    angular = sum(
        (ca.cross(q[k : k + 3], u[k : k + 3]) for k in (0, 3, 7, 10)), start=ca.SX.zeros(3)
    )
    left, right = (d / ca.norm_2(d) for d in (q[3:6], q[10:13]))
    w1 = v[6]
    w2 = v[13]
    p = parameters_from(P)
    angular += p.rhoJ * l / 6 * ((2 * w1 + w2) * left + (w1 + 2 * w2) * right)
    angular += p.rhoJ_x * l * (w2 - w1) * (right - left)
    return ca.vertcat(u[0:3] + u[7:10], angular, s[0:3] + s[7:10])


def _weight(l: ca.SX, P: ca.SX) -> ca.SX:
    """Return the work-equivalent weight (14,), N and N m."""
    f = ca.SX(14, 1)
    p = parameters_from(P)
    f[1], f[4], f[8], f[11] = (-p.rho * p.g * s for s in (l / 2, l**2 / 12, l / 2, -(l**2) / 12))
    return f
