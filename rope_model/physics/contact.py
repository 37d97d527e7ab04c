"""Contact force of a body in the shaft on the rope, per length of its centre line.

With the distance d of the centre line from the body's surface (physics.shaft), its unit normal n
and the velocity w of the rope relative to the body, a rope of radius r has the penetration depth
p = r - d.  The force consists of a spring of stiffness k with a soft onset of depth b, damping in
proportion to the spring force, and Coulomb friction regularised with the slip speed u0:

    s(p) = k min(p, b)^2 / (2 b) + k max(p - b, 0)         of p > 0, with the energy E(p): s = dE/dp
    N    = s max(1 - lambda n . w, 0)                       never draws the rope to the body
    f    = N n - mu N u / sqrt(|u|^2 + u0^2),               u = w - (n . w) n

The spring force is a gradient.  Damping and friction dissipate (N - s) (-n . w) + mu N
|u|^2 / sqrt(|u|^2 + u0^2), which is never negative; a moving body does the work f times its
velocity on the rope.

The tangent -df/dr, -df/dv is symmetric: it leaves out the effect of pressure on friction, and the
surface's curvature.  Works on numbers and CasADi expressions; vectors have their components first.
"""

from typing import NamedTuple

from rope_model.physics.elementary import (
    Scalar,
    Vector3,
    cross,
    dot,
    less,
    maximum,
    minimum,
    sqrt,
)
from rope_model.physics.node import PointRow
from rope_model.physics.shaft import Body, distance, normal
from rope_model.shaft_parameters import Contact

#: depth b of the soft onset, in rope diameters
ONSET = 0.05
#: m, length of rope below a conveyance that is not checked against it and its head ropes
UNCHECKED_LENGTH = 1.0
#: m, distance within which bodies take part in Newton's iterations from the first one on
CONTACT_MARGIN = 0.05
#: sums along the rope: energy stored, power dissipated, power of the moving body on the rope, force
#: on the rope, its moment about the origin, and pressure
SUMS = ("energy", "dissipated", "moved", "fx", "fy", "fz", "mx", "my", "mz", "pressure")


def largest_motion(longest: Scalar, q: PointRow, before: PointRow) -> Scalar:
    """Return a bound (m) of the change of the rope's distance from a body or itself: its maximum over all nodes.

    The node's row r, r' changes from ``before`` to ``q``.  No point of an element moves by more
    than half of the bound, as elements at the node are no longer than ``longest``, and neither does
    a body that moves with an end.
    """
    x, y, z, a, b, c = (abs(q[k] - before[k]) for k in range(6))
    return 2.0 * (x + y + z) + 0.75 * longest * (a + b + c)


def correction_motion(corrections: Scalar, longest: Scalar, shortest: Scalar) -> Scalar:
    """Return a bound of ``largest_motion`` from the sum of corrections in Newton's norm (m), r' times ``shortest``."""
    return 6.0 * corrections + 2.25 * longest / shortest * corrections


class ContactLaw(NamedTuple):
    """Parameters of the law."""

    stiffness: float  # N/m^2
    damping: float  # s/m
    friction: float
    slip_speed: float  # m/s


class ContactTerms(NamedTuple):
    """Contact at one point: force on the rope (3,), upper half of the symmetric tangent row by row (6,), SUMS."""

    force: tuple[float, float, float]
    tangent: tuple[float, float, float, float, float, float]
    sums: tuple[float, float, float, float, float, float, float, float, float, float]


def contact_law(
    contact: ContactLaw | Contact,
    diameter: Scalar,
    body: Body,
    body_velocity: Vector3,
    point: Vector3,
    velocity: Vector3,
    c_q: Scalar,
    c_v: Scalar,
) -> ContactTerms:
    """Return the contact of the centre line at ``point`` with a body, per length, for their velocities (m/s).

    The tangent is that with respect to (c_q, c_v) times position and velocity.
    """
    n = normal(point, body)
    onset = ONSET * diameter
    depth = maximum(0.5 * diameter - distance(point, body), 0.0)
    soft = minimum(depth, onset)
    hard = depth - soft
    spring = contact.stiffness * (soft * soft / (2.0 * onset) + hard)
    energy = contact.stiffness * (soft * soft * soft / (6.0 * onset) + 0.5 * hard * (onset + hard))

    w = tuple(velocity[i] - body_velocity[i] for i in range(3))
    normal_speed = dot(n, w)
    u = tuple(w[i] - normal_speed * n[i] for i in range(3))
    damped = maximum(1.0 - contact.damping * normal_speed, 0.0)
    pressure = spring * damped
    slip = sqrt(dot(u, u) + contact.slip_speed * contact.slip_speed)
    drag = contact.friction * pressure / slip
    force = (
        pressure * n[0] - drag * u[0],
        pressure * n[1] - drag * u[1],
        pressure * n[2] - drag * u[2],
    )

    normal_stiffness = c_q * damped * contact.stiffness * soft / onset
    normal_stiffness = normal_stiffness + c_v * (
        less(0.0, damped) * contact.damping * spring - drag
    )
    softening = c_v * drag / (slip * slip)
    viscous = c_v * drag
    pairs = ((i, j) for i in range(3) for j in range(i, 3))
    xx, xy, xz, yy, yz, zz = (
        normal_stiffness * n[i] * n[j] - softening * u[i] * u[j] for i, j in pairs
    )
    dissipated = (spring - pressure) * normal_speed + drag * dot(u, u)
    sums = energy, dissipated, dot(force, body_velocity), *force, *cross(point, force), pressure
    return ContactTerms(force, (xx + viscous, xy, xz, yy + viscous, yz, zz + viscous), sums)
