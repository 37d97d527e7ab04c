"""History of contact: impulses, and the error of its forces by mesh and steps.

A body that meets the rope sends waves along it.  The mesh follows those that are longer than two of its elements,
of length l where the body is near; with the wave number k and the tension half way up a leg of half the rope's length

    tau = 1 / (k c),    k = pi / l,    c^2 = (T + EI k^2) / rho,    T = rho g L / 4

A step of length h knows the pressure P in its middle.  Changes of P that are faster than either, with tau^2 + h^2 / 4
for tau^2, are not resolved: P minus its delay by tau, taken twice,

    d = P - s1,  s1' = d / tau,      r = d - s2,  s2' = (d - s2) / tau

falls with tau^2.  Its root mean square is about that of the error, to which those of the end forces and of the loop's
place are in proportion.

Works on numbers and CasADi expressions.
"""

import math
from typing import Any, NamedTuple

from rope_model.physics.elementary import hypot, larger, less, sqrt, where
from rope_model.physics.estimates import bending_length
from rope_model.physics.shaft import KINDS

#: of the end forces over that of the pressure, root mean squares; of the loop's place, over the length of rope that
#: weighs as much as the force that is not resolved while the loop swings once: evidence.contact.estimates fits them
AT_ENDS, OF_PLACE = 1.7, 0.16
TINY = 1e-300


class ContactSums(NamedTuple):
    """Since the start."""

    impulses: tuple[float, float, float, float, float, float] = (0.0,) * 6  # N s, of KINDS and of the rope on itself
    time: float = 0.0  # s, in which bodies pressed
    largest: float = 0.0  # N, of their pressure
    followed: tuple[float, float] = (0.0, 0.0)  # N, s1 and s2
    square: float = 0.0  # N^2 s, time integral of r^2


def add_contact(scene: Any, sums: Any, h: Any, pressures: Any, longest: Any) -> ContactSums:
    """``sums`` after a step ``h`` with these ``pressures`` (6,) in its middle, of KINDS and of the rope on itself.

    ``longest`` (m) is the longest element that a body is near, 0 for none.
    """
    part = h / (h + hypot(delay(scene, longest), 0.5 * h))
    pressure = sum(pressures[: len(KINDS)], start=0.0)
    first, second = sums.followed
    first = first + part * (pressure - first)
    second = second + part * (pressure - first - second)
    missed = pressure - first - second
    a, b, c, d, e, f = (before + h * now for before, now in zip(sums.impulses, pressures, strict=True))
    return ContactSums(
        (a, b, c, d, e, f),
        sums.time + where(less(0.0, pressure), h, 0.0),
        larger(sums.largest, pressure),
        (first, second),
        sums.square + h * (missed * missed),
    )


def delay(scene: Any, length: Any) -> Any:
    """tau (s) of elements of this ``length`` (m)."""
    rope, tension = scene.rope, _tension(scene)
    stiff = tension * (length * length) + rope.EI * math.pi**2
    return length * length / (math.pi * sqrt(larger(stiff / rope.mass_per_length, TINY)))


def length_for(scene: Any, tau: Any) -> Any:
    """Length (m) of the elements whose delay is ``tau`` (s)."""
    rope, tension = scene.rope, _tension(scene)
    bent = 4.0 * rope.EI * rope.mass_per_length / (tau * tau)
    return math.pi * tau * sqrt((tension + sqrt(tension * tension + bent)) / (2.0 * rope.mass_per_length))


def _tension(scene: Any) -> Any:
    return 0.25 * scene.rope.mass_per_length * scene.layout.gravity * scene.rope.length


def contact_error(sums: Any) -> Any:
    """Error of the bodies' pressure, root mean square while they press, relative to the largest."""
    return sqrt(sums.square / larger(sums.time, TINY)) / larger(sums.largest, TINY)


def with_contact_at_ends(error: Any, sums: Any, time: Any, force: Any) -> Any:
    """``error`` of the end forces, relative to the largest ``force`` in this ``time`` (s), with that by contact."""
    return hypot(error, AT_ENDS * sqrt(sums.square / larger(time, TINY)) / larger(force, TINY))


def with_contact_of_place(scene: Any, error: Any, sums: Any) -> Any:
    """``error`` of the loop's place, m, with that by contact."""
    rope, g, w = scene.rope, scene.layout.gravity, bending_length(scene)
    swing = 2.0 * math.pi * sqrt(w / g)
    return hypot(error, OF_PLACE * sqrt(sums.square / swing) / (rope.mass_per_length * g))
