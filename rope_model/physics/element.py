"""Torsion-deformable spatial beam element with 14 degrees of freedom, written once in CasADi.

Per node: position r (3), its derivative r' (3) with respect to reference arc length, angle theta
(1).  Between the nodes r is the cubic Hermite interpolant and theta is linear.  With t = r'/|r'|

    e     = |r'| - 1                           axial strain
    k     = r' x r'' / |r'|^2                  curvature vector, per reference length
    tau   = theta' + mean of frame(r', r'')    torsional strain
    w     = theta_t + frame(r', r'_t)          spin about the tangent

    U = int Costello energy(e, tau) + 1/2 EI |k|^2 dx         e in the element: see below
    K = int 1/2 rho |r_t|^2 + 1/2 rhoJ w^2 + 1/2 rhoJ_x l^2 theta_t'^2 dx
    V = int rho g r_Y dx
    D = int beta_K U(e_t, sqrt(a) tau_t, sqrt(b) k_t) dx, without Qe                (dissipates 2 D)

The rate of k is the one seen by an observer who turns with the cross-section, so that rigid motion
dissipates nothing.  Lagrange's equation gives the residual; everything else is a derivative of it.
Three Gauss points.

The axial strain in U and D is assumed, because a bent cubic cannot keep its length at each of its
points: energy by Gauss points locks in bending.  It is the parabola that has the mean of |r'| - 1
over the Gauss points, and its values at both nodes (AxialStrain).  These are one condition for a
node and one for an element; an inextensible curve that interpolates between nodes has as many to
fulfil.  On a straight element the parabola is |r'| - 1 itself, so no motion goes without energy.

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


#: entries of an element's q: angles of both nodes, and r' there
THETAS = [6, NODE_DOF + 6]
SLOPES = slice(3, 6), slice(NODE_DOF + 3, NODE_DOF + 6)
RIGHT_SLOPE = SLOPES[1]
#: the same of its relative coordinates
RELATIVE_THETAS = slice(9, 11)
RELATIVE_SLOPES = slice(3, 6), slice(6, 9)


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
    strain = _strains(x, points, point["strains"])
    mass = _translational_mass(x.l, x.P)
    balance = _balance(x, points, strain, point["balance"], mass)
    R, J = _forces(x, points, strain, point["tangent"], mass)
    strains = ca.vertcat(
        strain.axial.mean,
        strain.tau,
        ca.sqrt(strain.k_square),
        strain.axial_t.mean,
        strain.tau_t,
    )
    momentum = _momentum(x.q, x.v, mass, x.l, x.P)
    reference = _frame_reference(x, points)
    transport = _transport(x, strain, frame_rate)

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


class AxialStrain(NamedTuple):
    """Assumed axial strain mean + linear P1 + quadratic P2, with Legendre's polynomials P1 and P2 of the element.

    It has the mean of the Gauss points and the values at both nodes.  Rates, gradients and
    work-conjugate forces have the same three parts.
    """

    mean: Any
    linear: Any
    quadratic: Any

    @classmethod
    def of(cls, mean: Any, left: Any, right: Any) -> "AxialStrain":
        """Return the strain with this mean and these values at the nodes."""
        return cls(mean, 0.5 * (right - left), 0.5 * (left + right) - mean)


#: means of the squares of Legendre's polynomials
LEGENDRE_SQUARES = AxialStrain(1.0, 1 / 3, 1 / 5)


class _Point(NamedTuple):
    """Gauss point of an element: weight, interpolation, z = (r', r'', theta) with its rates, and frame's reference."""

    weight: float
    B: ca.SX
    z: ca.SX
    z_t: ca.SX
    z_tt: ca.SX
    F: ca.SX


class _Strains(NamedTuple):
    """Strains of an element but for its curvature, with their rates."""

    axial: AxialStrain
    axial_t: AxialStrain
    tau: ca.SX
    tau_t: ca.SX
    turning: ca.SX  # of the frame, per length
    theta_x: ca.SX  # (2,), derivative of theta' with respect to the angles of both nodes
    k_square: ca.SX  # mean


class _Stresses(NamedTuple):
    """Forces per length that do work on the rates of AxialStrain and of tau."""

    axial: AxialStrain  # N
    torque: Any  # N m


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


def _strains(x: _Arguments, points: list[_Point], of_point: ca.Function) -> _Strains:
    """Return the strains of the element, with their rates."""
    means = sum(
        (point.weight * of_point(point.z, point.z_t, point.F) for point in points),
        start=ca.SX.zeros(5),
    )
    e, turning, k_square, e_t, turning_t = ca.vertsplit(means)
    slopes = [x.q[place] for place in SLOPES]
    rates = [x.v[place] for place in SLOPES]
    at_nodes_t = [ca.dot(_unit(slope), rate) for slope, rate in zip(slopes, rates, strict=True)]
    theta_x = ca.vertcat(-1 / x.l, 1 / x.l) if x.torsional else ca.SX.zeros(2)
    return _Strains(
        axial=AxialStrain.of(e, *strains_at_nodes(x.q)),
        axial_t=AxialStrain.of(e_t, *at_nodes_t),
        tau=turning + ca.dot(theta_x, x.q[THETAS]),
        tau_t=turning_t + ca.dot(theta_x, x.v[THETAS]),
        turning=turning,
        theta_x=theta_x,
        k_square=k_square,
    )


def _strain_energy(p: ElementParameters, axial: AxialStrain, tau: ca.SX) -> Any:
    """Return the mean energy (J/m) of the conservative part of the Costello law without Qe."""
    varying = mean_square(axial) - axial.mean**2
    return costello.strain_energy(p.Qa, p.Qs, p.Qd, axial.mean, tau) + 0.5 * p.Qa * varying


def _elastic_stresses(p: ElementParameters, strains: _Strains) -> _Stresses:
    """Return the stresses without damping."""
    e = strains.axial
    tension = costello.tension(p.Qa, p.Qs, p.Qk, p.Qe, e.mean, strains.tau)
    torque = costello.torque(p.Qs, p.Qk, p.Qd, p.Qe, e.mean, strains.tau)
    return _Stresses(_axial_forces(p, tension, e), torque)


def _damped(p: ElementParameters, elastic: _Stresses, strains: _Strains) -> _Stresses:
    """Return the stresses with damping."""
    e_t = strains.axial_t
    tau_t = p.root_a * strains.tau_t
    tension = costello.tension(p.Qa, p.Qs, 0, 0, e_t.mean, tau_t)
    torque = p.root_a * costello.torque(p.Qs, 0, p.Qd, 0, e_t.mean, tau_t)
    viscous = _axial_forces(p, tension, e_t)
    return _Stresses(
        AxialStrain(*(N + p.beta_K * D for N, D in zip(elastic.axial, viscous, strict=True))),
        elastic.torque + p.beta_K * torque,
    )


def _axial_forces(p: ElementParameters, tension: Any, e: AxialStrain) -> AxialStrain:
    """Return the forces on an axial strain ``e`` from that on its mean."""
    return AxialStrain(
        tension,
        LEGENDRE_SQUARES.linear * p.Qa * e.linear,
        LEGENDRE_SQUARES.quadratic * p.Qa * e.quadratic,
    )


def _balance(
    x: _Arguments, points: list[_Point], strains: _Strains, of_point: ca.Function, mass: ca.SX
) -> ca.SX:
    """Return BALANCE (9,)."""
    p = parameters_from(x.P)
    e = strains.axial.mean
    tau = strains.tau
    balance = ca.SX.zeros(len(BALANCE))

    def add(name: str, value: Any) -> None:
        balance[BALANCE.index(name)] += value

    add("axial", x.l * 0.5 * p.Qa * mean_square(strains.axial))
    add("coupling", x.l * p.Qs * e * tau)
    add("torsion", x.l * (0.5 * p.Qd * tau**2 + costello.stiffening_energy(p.Qe, e, tau)))
    add("kinetic", 0.5 * ca.dot(x.v, mass @ x.v))
    add("gravity", -ca.dot(_weight(x.l, x.P), x.q))
    damping = p.beta_K * _strain_energy(p, strains.axial_t, p.root_a * strains.tau_t)
    add("damping_power", 2 * x.l * damping)
    add(
        "nonconservative_power",
        x.l * costello.nonconservative_power(p.Qk, e, tau, strains.axial_t.mean, strains.tau_t),
    )
    for point in points:
        bending, spin, damping = ca.vertsplit(of_point(point.z, point.z_t, point.F, x.P))
        weight = point.weight * x.l
        add("bending", weight * bending)
        add("spin", weight * spin)
        add("damping_power", weight * damping)
    if x.torsional:
        slope_rate = ca.dot(strains.theta_x, x.v[THETAS])
        add("spin", 0.5 * _slope_inertia(x) * slope_rate**2)
    return balance


def _forces(
    x: _Arguments, points: list[_Point], strains: _Strains, of_point: ca.Function, mass: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """Return the residual R (2 m,) and its tangent J (2 m, 2 m)."""
    relative = relative_coordinates()
    l = x.l
    theta_x = strains.theta_x
    p = parameters_from(x.P)
    elastic = _elastic_stresses(p, strains)
    stresses = _damped(p, elastic, strains)
    prestress = _of_prestress(x, points, strains, elastic)
    R_r = ca.SX.zeros(11)
    J_r = ca.SX.zeros(11, 11)
    e_z = ca.SX.zeros(11)
    tau_z = ca.SX.zeros(11)
    tau_z[RELATIVE_THETAS] = theta_x
    at_points = (
        _at_points(stresses.axial),
        stresses.torque,
        _at_points(prestress),
        elastic.torque,
        x.P,
        x.c_q,
        x.c_v,
        x.c_a,
    )
    for w, B, z, z_t, z_tt, F in points:
        R_p, J_p, strains_z = of_point(z, z_t, z_tt, F, *at_points)
        R_r += B.T @ (w * l * R_p)
        J_r += B.T @ (w * l * J_p) @ B
        e_z += w * B.T @ strains_z[0, :].T
        tau_z += w * B.T @ strains_z[1, :].T
    R_r[RELATIVE_THETAS] += stresses.torque * l * theta_x
    tangents = [ca.SX.zeros(11), ca.SX.zeros(11)]  # derivatives of the strains at both nodes
    forces = zip(_at_nodes(stresses.axial), _at_nodes(prestress), strict=True)
    for side, (tension, held) in enumerate(forces):
        place = RELATIVE_SLOPES[side]
        slope = x.q[SLOPES[side]]
        t = _unit(slope)
        tangents[side][place] = t
        R_r[place] += l * tension * t
        across = (ca.SX.eye(3) - t @ t.T) / ca.norm_2(slope)
        J_r[place, place] += x.c_q * l * held * across
    if x.torsional:
        slope_inertia = _slope_inertia(x)
        R_r[RELATIVE_THETAS] += slope_inertia * ca.dot(theta_x, x.a[THETAS]) * theta_x
        J_r[RELATIVE_THETAS, RELATIVE_THETAS] += x.c_a * slope_inertia * (theta_x @ theta_x.T)
    J_r += _tangent_through_strains(x, strains, AxialStrain.of(e_z, *tangents), tau_z)
    R = mass @ x.a - _weight(l, x.P) + relative.T @ R_r
    J = symmetric(x.c_a * mass + relative.T @ symmetric(J_r) @ relative)
    return R[x.dofs], J[x.dofs, x.dofs]


def _tangent_through_strains(
    x: _Arguments, strains: _Strains, axial_z: AxialStrain, tau_z: ca.SX
) -> ca.SX:
    """Return the tangent (11, 11) through the strains, whose gradients are ``axial_z`` and ``tau_z``."""
    p = parameters_from(x.P)
    damped = x.c_v * p.beta_K
    root = p.root_a
    growth = x.c_q * p.Qe
    axial = (x.c_q + damped) * p.Qa
    coupling = (x.c_q + damped * root) * p.Qs + growth * strains.tau
    torsion = (x.c_q + damped * root * root) * p.Qd + growth * strains.axial.mean
    shared = coupling * axial_z.mean + 0.5 * torsion * tau_z
    tangent = shared @ tau_z.T + tau_z @ shared.T
    for gradient, factor in zip(axial_z, LEGENDRE_SQUARES, strict=True):
        tangent += (factor * axial * gradient) @ gradient.T
    stretched: ca.SX = x.l * tangent
    return stretched


def _of_prestress(
    x: _Arguments, points: list[_Point], strains: _Strains, elastic: _Stresses
) -> AxialStrain:
    """Return the axial forces without damping with the axial strain of q_prestress in the place of that of q."""
    relative = relative_coordinates()
    Qa = parameters_from(x.P).Qa
    mean = sum(
        (p.weight * ca.norm_2((p.B @ relative @ x.q_prestress)[:3]) for p in points),
        start=ca.SX(0),
    )
    before = AxialStrain.of(mean - 1, *strains_at_nodes(x.q_prestress))
    changes = zip(elastic.axial, LEGENDRE_SQUARES, before, strains.axial, strict=True)
    return AxialStrain(*(N + Qa * factor * (e_p - e) for N, factor, e_p, e in changes))


def strains_at_nodes(q: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return |r'| - 1 at both nodes."""
    left, right = (ca.norm_2(q[place]) - 1 for place in SLOPES)
    return left, right


def mean_square(e: AxialStrain) -> Any:
    """Return the mean of the square of an axial strain over the element."""
    return sum(factor * part**2 for part, factor in zip(e, LEGENDRE_SQUARES, strict=True))


def _at_points(N: AxialStrain) -> Any:
    """Return the force on the strain at each Gauss point, over its weight, of forces ``N`` on an AxialStrain."""
    return N.mean - N.quadratic


def _at_nodes(N: AxialStrain) -> tuple[Any, Any]:
    """Return the forces on the strains at both nodes of forces ``N`` on an AxialStrain."""
    return 0.5 * (N.quadratic - N.linear), 0.5 * (N.quadratic + N.linear)


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


def _transport(x: _Arguments, strains: _Strains, frame_rate: FrameRate) -> ca.SX:
    """Return the increase of the angles (3,) when q becomes the reference."""
    if not x.torsional:
        return ca.SX.zeros(3)
    motion = (y[RIGHT_SLOPE] for y in (x.q, x.v, x.a))
    return ca.vertcat(x.l * strains.turning, *_spin(frame_rate, x.F[-3:], *motion))


def _point_functions(frame_rate: FrameRate, torsional: bool) -> dict[str, ca.Function]:
    """Build the functions of the continuum at one point z = (r', r'', theta) with work-conjugate forces (7,).

    strains: (z, z_t, F) -> e, turning of the frame, |k|^2, rates of the first two: terms of the element's means
    tangent: forces, their derivatives without the part through the element's strains, and the gradients of e and of
             the frame's turning; ``tension`` and ``torque`` are the forces on e and tau, ``bent_tension`` and
             ``bent_torque`` those of the derivatives
    balance: (z, z_t, F, P) -> energies of bending and spin, power of damping of the bending
    """
    z = ca.SX.sym("z", 7)
    z_t = ca.SX.sym("z_t", 7)
    z_tt = ca.SX.sym("z_tt", 7)
    P = ca.SX.sym("P", len(PARAMETERS))
    F = ca.SX.sym("F", 6 if torsional else 0)
    c_q = ca.SX.sym("c_q")
    c_v = ca.SX.sym("c_v")
    c_a = ca.SX.sym("c_a")
    tension, torque, bent_tension, bent_torque = (
        ca.SX.sym(name) for name in ("tension", "torque", "bent_tension", "bent_torque")
    )
    p = parameters_from(P)

    # strains, and the spin of the section
    d = z[0:3]
    c = z[3:6]
    e = ca.norm_2(d) - 1
    turning = frame_rate(F[:3], F[3:], d, c) if torsional else ca.SX(0)
    k = ca.cross(d, c) / ca.dot(d, d)
    strains = ca.vertcat(e, turning)
    if torsional:
        w = z_t[6] + frame_rate(F[:3], ca.SX.zeros(3), d, z_t[0:3])
    else:
        w = ca.SX(0)

    # strain rates; that of the curvature as seen from the section
    strains_t = ca.jtimes(strains, z, z_t)
    spin = ca.cross(d, z_t[0:3]) / ca.dot(d, d) + w * d / ca.norm_2(d)
    k_t = ca.jtimes(k, z, z_t) - ca.cross(spin, k)

    # Lagrange's equation: internal forces (the spin does no work on EI k), inertia of the spin
    K = 0.5 * p.rhoJ * w * w
    momentum = ca.gradient(K, z_t)
    inertia = ca.jtimes(momentum, z_t, z_tt) + ca.jtimes(momentum, z, z_t) - ca.gradient(K, z)
    bending_damping = p.beta_K * p.EI * p.root_b**2
    strains_z = ca.jacobian(strains, z)
    k_z = ca.jacobian(k_t, z_t)
    force = strains_z.T @ ca.vertcat(tension, torque) + inertia
    force += k_z.T @ (p.EI * k + bending_damping * k_t)

    # its derivative along (c_q, c_v, c_a), exact at rest; how motion changes damping and spin inertia
    # is left out
    U = 0.5 * p.EI * ca.dot(k, k)
    stiffness = ca.hessian(U + bent_tension * e + bent_torque * turning, z)[0]
    damping = bending_damping * (k_z.T @ k_z)
    J = symmetric(c_q * stiffness + c_v * damping + c_a * ca.jacobian(momentum, z_t))

    balance = ca.vertcat(U, K, bending_damping * ca.dot(k_t, k_t))

    def function(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
        return ca.Function(f"point_{name}", inputs, ca.cse(outputs))

    forces = [tension, torque, bent_tension, bent_torque]
    return {
        "strains": function("strains", [z, z_t, F], [ca.vertcat(strains, ca.dot(k, k), strains_t)]),
        "tangent": function(
            "tangent", [z, z_t, z_tt, F, *forces, P, c_q, c_v, c_a], [force, J, strains_z]
        ),
        "balance": function("balance", [z, z_t, F, P], [balance]),
    }


def _unit(d: ca.SX) -> ca.SX:
    """Return the unit vector along ``d``."""
    return d / ca.norm_2(d)


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
