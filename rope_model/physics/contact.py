"""Force of a body in the shaft on the rope, per length of its centre line.

With the distance d of the centre line from the body's surface (physics.shaft), its unit normal n and the speed w of the
rope against the body, the rope of radius r is pressed in by p = r - d.  A spring of stiffness k that begins softly,
within a depth b, damping that grows with the spring's force, and Coulomb friction that needs a slip speed u0:

    s(p) = k min(p, b)^2 / (2 b) + k max(p - b, 0)         of p > 0, with the energy E(p): s = dE/dp
    N    = s max(1 - lambda n . w, 0)                       never draws the rope to the body
    f    = N n - mu N u / sqrt(|u|^2 + u0^2),               u = w - (n . w) n

The spring's force is a gradient; damping and friction dissipate (N - s) (-n . w) + mu N |u|^2 / sqrt(|u|^2 + u0^2),
which is never negative; a moving body works on the rope by f times its speed.

The tangent -df/dr, -df/dv is symmetric: it leaves out the effect of pressure on friction, and the surface's curvature.

Works on numbers and CasADi expressions; vectors have their components first.
"""

from typing import Any, NamedTuple

from rope_model.physics.elementary import cross, dot, larger, less, smaller, sqrt
from rope_model.physics.shaft import distance, normal

#: depth b in which the spring begins, in rope diameters
ONSET = 0.05
#: m of rope below a conveyance within which it and its head ropes are not looked at: they carry that rope
OWN_LENGTH = 1.0
#: m: bodies that come so near in Newton's iterations are checked from the start
LOOK_AHEAD = 0.05
#: sums along the rope: energy stored, power dissipated, power of a moving body on the rope, force on the rope and its
#: moment about the origin, and last the pressure
SUMS = ("energy", "dissipated", "moved", "fx", "fy", "fz", "mx", "my", "mz", "pressure")


def largest_motion(longest: Any, q: Any, before: Any) -> Any:
    """Largest change (m) of the rope's distance from a body or itself: the largest of all nodes' counts.

    The node had the row r, r' ``before`` and has ``q``.  No place of an element moves by more than half of it, the
    node's elements being no longer than ``longest``, and no end with what it holds.
    """
    x, y, z, a, b, c = (abs(q[k] - before[k]) for k in range(6))
    return 2.0 * (x + y + z) + 0.75 * longest * (a + b + c)


def correction_motion(corrections: Any, longest: Any, shortest: Any) -> Any:
    """Bound of ``largest_motion`` by the sum of corrections in Newton's norm (m): r' counts in 1 / ``shortest``."""
    return 6.0 * corrections + 2.25 * longest / shortest * corrections


class Touch(NamedTuple):
    """Contact at one place: force on the rope (3,), symmetric tangent (6,) from the diagonal row by row, SUMS."""

    force: tuple[float, float, float]
    tangent: tuple[float, float, float, float, float, float]
    sums: tuple[float, float, float, float, float, float, float, float, float, float]


def touch(contact: Any, diameter: Any, body: Any, moves: Any, point: Any, speed: Any, cq: Any, cv: Any) -> Touch:
    """Contact, per length, of the centre line at ``point`` with ``speed`` and a body that ``moves`` so.

    The tangent is that along (cq, cv) of place and speed.
    """
    n, onset = normal(point, body), ONSET * diameter
    pressed = larger(0.5 * diameter - distance(point, body), 0.0)
    soft = smaller(pressed, onset)
    hard = pressed - soft
    spring = contact.stiffness * (soft * soft / (2.0 * onset) + hard)
    energy = contact.stiffness * (soft * soft * soft / (6.0 * onset) + 0.5 * hard * (onset + hard))

    w = tuple(speed[i] - moves[i] for i in range(3))
    away = dot(n, w)
    u = tuple(w[i] - away * n[i] for i in range(3))
    damped = larger(1.0 - contact.damping * away, 0.0)
    pressure = spring * damped
    slip = sqrt(dot(u, u) + contact.slip_speed * contact.slip_speed)
    grip = contact.friction * pressure / slip
    force = pressure * n[0] - grip * u[0], pressure * n[1] - grip * u[1], pressure * n[2] - grip * u[2]

    across = cq * damped * contact.stiffness * soft / onset
    across = across + cv * (less(0.0, damped) * contact.damping * spring - grip)
    turned, held = cv * grip / (slip * slip), cv * grip
    xx, xy, xz, yy, yz, zz = (across * n[i] * n[j] - turned * u[i] * u[j] for i in range(3) for j in range(i, 3))
    dissipated = (spring - pressure) * away + grip * dot(u, u)
    sums = energy, dissipated, dot(force, moves), *force, *cross(point, force), pressure
    return Touch(force, (xx + held, xy, xz, yy + held, yz, zz + held), sums)
