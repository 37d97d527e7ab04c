"""Hysteretic bending: friction between the wires of a bent rope.

    M = EI k + C z,   C = EI_stick - EI,     z_t = k_t - (k_t . z)+ z / k0^2,     (x)+ = max(x, 0)

M and k are the vectors of bending moment and curvature seen from the cross-section: z belongs to
the wires and turns with the section.  While no wire slides M follows k with EI_stick.  Once all
slide, C z is the friction moment C k0 = M0 + M1 T+, which grows with the tension T, and M follows k
with EI.  It is the model of Bouc and Wen with n = 2 and beta = gamma; |z| replaces |z_x|, so that
no direction across the rope is preferred.

The energy is 1/2 C z^2, the dissipation C (k_t . z)+ z^2 / k0^2, which is never negative, however
k0 changes.

Over a step the curvature changes along a straight line, by dk = k0 s u with |u| = 1.  While
z . u < 0 the wires stick.  From there on the exact solution is, in units of k0,

    z . u = tanh(c + s),   z x u falls with 1 / cosh(c + s),      c = artanh(z . u) at the start

with k0 as at the start of the step.  sinh s is taken by its series up to s^5 and the other
functions follow from it:  for s > 3, where this is inaccurate, sliding is complete in any case.
Works on numbers, numpy arrays and CasADi expressions; vectors have their components first.

Sources: R. Bouc, 1967; Y.-K. Wen, J. Eng. Mech. Div. 102 (1976); Y. J. Park, Y.-K. Wen, A. H.-S.
Ang, Earthquake Eng. Struct. Dyn. 14 (1986) for two directions; K. O. Papailiou, IEEE Trans. Power
Delivery 12 (1997), and F. Foti, L. Martinelli, Appl. Math. Modelling 40 (2016), for stiffness and
friction moment of strands.
"""

from typing import Annotated, NamedTuple

from rope_model.parameters import Rope
from rope_model.physics import hermite
from rope_model.physics.costello import tension
from rope_model.physics.elementary import Scalar, Vector, cross, dot, exp, log, maximum, sqrt
from rope_model.physics.frame import parallel_transport, rational_cos_sin, rotate_about_tangent
from rope_model.physics.node import ElementRows

#: number of entries of a section: tangent, curvature vector, angle
SECTION_SIZE = 7
#: number of entries of a section with its z behind it
POINT_STATE_SIZE = SECTION_SIZE + 3
#: square in units of k0^2 that counts as 0, so that there is a derivative where nothing moves
REGULARIZATION = 1e-26
#: square of z in these units that is too small for a quotient
_SMALL = 1e-12


class BoucWenStep(NamedTuple):
    """State z at the end of a step, dissipation over C per length of the rope, and a slope.

    ``secant`` is |z| over its value if all wires stuck.
    """

    z: tuple[float, float, float]
    dissipated: float
    secant: float


def wire_stiffness(rope: Rope) -> Scalar:
    """Return C (N m^2); 0 without friction, where EI_stick = 0."""
    return maximum(rope.EI_stick - rope.EI, 0.0)


def slip_curvature(rope: Rope, stiffness: Scalar, e: Scalar, tau: Scalar) -> Scalar:
    """Return k0 (1/m) of a rope with friction at its axial and torsional strain; ``stiffness`` is C."""
    pull = tension(rope.Qa, rope.Qs, rope.Qk, rope.Qe, e, tau)
    return (rope.slip_moment + rope.slip_factor * rope.diameter * maximum(pull, 0.0)) / stiffness


def section_at(
    xi: Scalar, l: Scalar, nodes: ElementRows
) -> Annotated[tuple[Scalar, ...], SECTION_SIZE]:
    """Return the section (7,) at ``xi`` of an element with the nodes (14,)."""
    ends = [(nodes[k], nodes[3 + k], nodes[7 + k], nodes[10 + k]) for k in range(3)]
    d = [hermite.interpolate(xi, l, *values)[1] for values in ends]
    c = [hermite.bend(xi, l, *values) for values in ends]
    return section(d, c, (1 - xi) * nodes[6] + xi * nodes[13])


def section(d: Vector, c: Vector, angle: Scalar) -> tuple[Scalar, ...]:
    """Return the section (7,) where r' is ``d``, r'' is ``c`` and theta ``angle``."""
    square = dot(d, d)
    length = sqrt(square)
    turn = cross(d, c)
    return (*(d[i] / length for i in range(3)), *(turn[i] / square for i in range(3)), angle)


def bouc_wen_step(
    before: Annotated[Vector, POINT_STATE_SIZE], after: Annotated[Vector, SECTION_SIZE], k0: Scalar
) -> BoucWenStep:
    """Advance the hysteresis from the section ``before``, with its z (10,), to the section ``after`` (7,)."""
    z = _carried(before, after, before[7:10])
    old_curvature = _carried(before, after, before[3:6])
    z = [x / k0 for x in z]
    step = [(after[3 + i] - old_curvature[i]) / k0 for i in range(3)]
    stuck = [z[i] + step[i] for i in range(3)]
    # fraction of the step over which the wires stick, while the moment falls
    square = dot(step, step)
    along = dot(z, step)
    back = _positive(-along)
    back = back - _positive(back - square)
    fraction = back / (square + REGULARIZATION)
    z = [z[i] + fraction * step[i] for i in range(3)]
    step = [(1.0 - fraction) * x for x in step]
    # remaining part of the step, over which they slide
    s2 = dot(step, step)
    a = dot(z, step)
    h = 1.0 + s2 / 6 * (1.0 + s2 / 20)  # sinh(s) / s
    cosh = sqrt(1.0 + s2 * h * h)
    growth = cosh + a * h
    gained = h + a * h * h / (cosh + 1.0)
    z_end = [(z[i] + gained * step[i]) / growth for i in range(3)]
    # work along the step, int z . dk, minus the energy stored
    s = sqrt(s2 + REGULARIZATION)
    work = s + log(0.5 * (1.0 + exp(-2.0 * s))) + log(growth / cosh)
    dissipated = k0 * k0 * maximum(work - 0.5 * (dot(z_end, z_end) - dot(z, z)), 0.0)
    secant = sqrt((dot(z_end, z_end) + _SMALL) / (dot(stuck, stuck) + _SMALL))
    return BoucWenStep((k0 * z_end[0], k0 * z_end[1], k0 * z_end[2]), dissipated, secant)


def _carried(before: Vector, after: Vector, x: Vector) -> list[Scalar]:
    """Return the vector ``x`` across the rope, turned as the section is from ``before`` to ``after``."""
    p = before[0:3]
    t = after[0:3]
    return rotate_about_tangent(
        t, parallel_transport(p, t, x), *rational_cos_sin(after[6] - before[6])
    )


def within(x: Scalar) -> Scalar:
    """Return ``x``, or 0 below and 1 above."""
    return _positive(x) - _positive(x - 1.0)


def _positive(x: Scalar) -> Scalar:
    """Return (x)+ by operations that the element code supports."""
    return 0.5 * (x + sqrt(x * x + (1e-3 * REGULARIZATION) ** 2))
