"""Contact impulses since the start of the run, and the error of contact forces by mesh and time steps.

A body that meets the rope sends waves along it.  The mesh resolves those that are longer than two
of its elements, of length l where the body is near.  With the wave number k and the tension at
mid-height of a leg of half the rope's length

    tau = 1 / (k c),    k = pi / l,    c^2 = (T + EI k^2) / rho,    T = rho g L / 4

A step of length h knows the pressure P in its middle.  Changes of P that are faster than tau or
h / 2 (the squares of both add up) are not resolved.  What two low-pass filters leave of P,

    d = P - s1,  s1' = d / tau,      r = d - s2,  s2' = (d - s2) / tau

falls with tau^2.  Its root mean square is about that of the error, and the errors of the end forces
and of the loop's position are proportional to it.  Works on numbers and CasADi expressions.
"""

import math
from typing import Annotated, NamedTuple

from rope_model.parameters import Scene
from rope_model.physics.elementary import (
    SMALLEST_DIVISOR,
    Scalar,
    Vector,
    hypot,
    less,
    maximum,
    sqrt,
    sum_of,
    where,
)
from rope_model.physics.estimates import bending_length
from rope_model.physics.shaft import KINDS

# proportionality factors of errors by contact, fitted by evidence.contact.estimates
TO_END_FORCES = 1.7  #: root mean square error of the end forces over that of the pressure
#: error of the loop's position over the length of rope that weighs as much as the unresolved force
#: of one swing
TO_LOOP = 0.16


class ContactSums(NamedTuple):
    """Contact impulses and error integrals since the start of the run."""

    # N s, of KINDS and of the rope on itself
    impulses: tuple[float, float, float, float, float, float] = (0.0,) * 6
    time: float = 0.0  # s, duration of the contact with bodies
    largest: float = 0.0  # N, largest pressure of the bodies
    followed: tuple[float, float] = (0.0, 0.0)  # N, filtered pressures s1 and s2
    square: float = 0.0  # N^2 s, time integral of r^2


def add_contact(
    scene: Scene,
    sums: ContactSums,
    h: Scalar,
    pressures: Annotated[Vector, len(KINDS) + 1],
    longest: Scalar,
) -> ContactSums:
    """Return ``sums`` after a step ``h`` with the ``pressures`` (6,) of KINDS and of the rope on itself in its middle.

    ``longest`` (m) is the length of the longest element near a body, 0 for none.
    """
    fraction = h / (h + hypot(delay(scene, longest), 0.5 * h))
    pressure = sum_of(pressures[: len(KINDS)])
    first, second = sums.followed
    first = first + fraction * (pressure - first)
    second = second + fraction * (pressure - first - second)
    unresolved = pressure - first - second
    a, b, c, d, e, f = (
        before + h * pressure_k for before, pressure_k in zip(sums.impulses, pressures, strict=True)
    )
    return ContactSums(
        (a, b, c, d, e, f),
        sums.time + where(less(0.0, pressure), h, 0.0),
        maximum(sums.largest, pressure),
        (first, second),
        sums.square + h * (unresolved * unresolved),
    )


def delay(scene: Scene, length: Scalar) -> Scalar:
    """Return tau (s) of elements of this ``length`` (m)."""
    rope = scene.rope
    tension = _tension(scene)
    stiff = tension * (length * length) + rope.EI * math.pi**2
    return (
        length * length / (math.pi * sqrt(maximum(stiff / rope.mass_per_length, SMALLEST_DIVISOR)))
    )


def length_for(scene: Scene, tau: Scalar) -> Scalar:
    """Return the length (m) of the elements whose delay is ``tau`` (s)."""
    rope = scene.rope
    tension = _tension(scene)
    bent = 4.0 * rope.EI * rope.mass_per_length / (tau * tau)
    return (
        math.pi
        * tau
        * sqrt((tension + sqrt(tension * tension + bent)) / (2.0 * rope.mass_per_length))
    )


def _tension(scene: Scene) -> Scalar:
    return 0.25 * scene.rope.mass_per_length * scene.layout.gravity * scene.rope.length


def contact_error(sums: ContactSums) -> Scalar:
    """Return the error of the bodies' pressure, root mean square during contact, relative to the largest pressure."""
    return sqrt(sums.square / maximum(sums.time, SMALLEST_DIVISOR)) / maximum(
        sums.largest, SMALLEST_DIVISOR
    )


def add_contact_end_error(error: Scalar, sums: ContactSums, time: Scalar, force: Scalar) -> Scalar:
    """Add the error by contact in ``time`` (s) to the ``error`` of the end forces over the largest ``force`` (N)."""
    return hypot(
        error,
        TO_END_FORCES
        * sqrt(sums.square / maximum(time, SMALLEST_DIVISOR))
        / maximum(force, SMALLEST_DIVISOR),
    )


def add_contact_loop_error(scene: Scene, error: Scalar, sums: ContactSums) -> Scalar:
    """Add the error by contact to ``error`` (m) of the loop's position."""
    rope = scene.rope
    g = scene.layout.gravity
    w = bending_length(scene)
    return hypot(
        error,
        TO_LOOP * sqrt(sums.square / (2.0 * math.pi * sqrt(w / g))) / (rope.mass_per_length * g),
    )
