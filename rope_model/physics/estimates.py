"""Error estimates in closed form for models without torsion, waves and bending.

An error is that of the vertical end forces (root mean square over a winding, relative to the
largest).  With W the width of the loop, l the length of a leg, kappa = Qs^2 / (Qa Qd), F = rho g
l_long

    longitudinal  a leg answers a step of jerk J by swinging at omega = pi c / (2 l): (8/pi^2) rho l J / (omega F)
    lean          the loop bulges sideways by X, a leg is longer by X^2 / (2 l_short): rho g X^2 / (4 l_short F)
    whip          the flow u carries the loop sideways once rho u^2 exceeds its weight: WHIP (u^2 / g W)^2
    yaw           the uniform torque M turns the loop by psi = 4 M ln(L / 2W) / (rho g W^2); the lean shrinks by psi^2

    release       releasing the torque M sends off a torsional wave, which carries the tension Qs M rho / (Qa rhoJ)

    planar or spatial on a rope with torque:   kappa longitudinal + psi^2 lean + whip + release
    rigid against planar:                      longitudinal + lean

Constants that no theory gives are measured; ``python -m evidence --measure choice:estimates``
compares estimate and error.  ``scene`` gives rope and layout; works on numbers and CasADi
expressions.
"""

import math
from typing import NamedTuple

from rope_model.parameters import Rope, Scene
from rope_model.physics.elementary import Scalar, log, maximum, sqrt
from rope_model.physics.inextensible import left_leg_length
from rope_model.physics.initial_curvature import max_curvature

#: sideways displacement of the loop's bottom over its natural width: 0.25 to 0.33 measured at
#: 4 m/s, EI 50 to 1000
LEAN = 1 / 3
#: growth of the lean with acceleration / g: 6 to 11 measured at 4 m/s^2 and 16 m/s, none at
#: 0.75 m/s^2
LEAN_GROWTH = 10.0
#: factor of the whip: 1.7e-5 to 2.5e-5 measured on the 120 m rope at u^2 / (g W) = 4 to 12
WHIP = 3e-5
#: natural width of a free loop over (EI / rho g)^(1/3)
NATURAL_WIDTH = 2.54307
#: rad, yaw beyond which the loop may turn over; the estimate is 1.2 to 5 times the yaw measured
MAX_YAW = 1.0


class Travel(NamedTuple):
    """Largest values of a winding's motion."""

    height_difference: float  # m
    speed: float  # m/s
    acceleration: float  # m/s^2
    jerk: float  # m/s^3


#: least motion to expect; inputs have no jerk, so it is taken to grow with the acceleration
ASSUMED = Travel(0.0, 10.0, 1.0, 1.0)


def travel_estimate(height_difference: Scalar, speed: Scalar, acceleration: Scalar) -> Travel:
    """Return the motion to expect of ends that move like this: at least ASSUMED."""
    growth = maximum(acceleration / ASSUMED.acceleration, 1.0)
    speed = maximum(speed, ASSUMED.speed)
    return Travel(height_difference, speed, growth * ASSUMED.acceleration, growth * ASSUMED.jerk)


def longitudinal_error(scene: Scene, travel: Travel) -> Scalar:
    """Return the first longitudinal mode of the longer leg after a step of the jerk, over the leg's weight."""
    omega = axial_frequency(scene.rope, _long_leg(scene, travel))
    return 8 / math.pi**2 * travel.jerk / (omega * scene.layout.gravity)


def axial_frequency(rope: Rope, leg: Scalar) -> Scalar:
    """Return the frequency (rad/s) of the slowest longitudinal wave of a leg."""
    return 0.5 * math.pi * sqrt(rope.Qa / rope.mass_per_length) / leg


def lean_error(scene: Scene, travel: Travel) -> Scalar:
    """Return the error by the length that a leaning leg takes from the other, over the longer leg."""
    # the shorter leg is at least as long as the loop is wide
    short_leg = maximum(
        left_leg_length(scene.rope.length, 0.0, travel.height_difference), scene.layout.spacing
    )
    width = maximum(natural_width(scene), scene.layout.spacing)
    lean = LEAN * width * (1 + LEAN_GROWTH * travel.acceleration / scene.layout.gravity)
    return lean * lean / (4 * short_leg * _long_leg(scene, travel))


def held_error(scene: Scene, travel: Travel) -> Scalar:
    """Return the error of a model without torsion for a rope with torque while its swivels hold."""
    rope = scene.rope
    psi = loop_yaw(scene)
    flow = travel.speed * travel.speed / (scene.layout.gravity * natural_width(scene))
    kappa = rope.Qs * rope.Qs / (rope.Qa * rope.Qd)
    return (
        kappa * longitudinal_error(scene, travel)
        + psi * psi * lean_error(scene, travel)
        + WHIP * (flow * flow)
    )


def release_error(scene: Scene, travel: Travel) -> Scalar:
    """Return the tension of the torsional wave that a released swivel sends off, over the longer leg's weight."""
    rope = scene.rope
    g = scene.layout.gravity
    return (
        abs(rope.Qs) * held_torque(rope, g) / (rope.Qa * rope.rhoJ * g * _long_leg(scene, travel))
    )


def loop_yaw(scene: Scene) -> Scalar:
    """Return the yaw (rad) of the loop under the torque of a held rope; legs are strings under their own weight."""
    rope = scene.rope
    g = scene.layout.gravity
    # mean of the widths at both ends of the legs
    width = 0.5 * (scene.layout.spacing + natural_width(scene))
    height = maximum(0.5 * rope.length / width, 1.0)
    return (
        4 * abs(held_torque(rope, g)) * log(height) / (rope.mass_per_length * g * (width * width))
    )


def held_torque(rope: Rope, gravity: Scalar) -> Scalar:
    """Return the torque (N m) of a hanging rope whose ends were fastened unloaded."""
    return coupling_torque(rope, gravity) + twist_torque(rope, rope.installed_twist)


def coupling_torque(rope: Rope, gravity: Scalar) -> Scalar:
    """Return the size of the torque (N m) that the weight of half the rope causes by coupling."""
    return abs(rope.Qc / rope.Qa * rope.mass_per_length * gravity * 0.5 * rope.length)


def twist_torque(rope: Rope, angle: Scalar) -> Scalar:
    """Return the size of the torque (N m) of a rope twisted by ``angle`` (rad) from end to end, at constant tension."""
    return abs((rope.Qd - rope.Qb * rope.Qc / rope.Qa) * angle / rope.length)


def curvature_torque(rope: Rope) -> Scalar:
    """Return the largest torque (N m) that permanent curvature causes in the loop, over half a turn of it."""
    return math.pi * rope.EI * max_curvature(rope)


def natural_width(scene: Scene) -> Scalar:
    """Return the width (m) of the loop between legs that hang freely."""
    return NATURAL_WIDTH * bending_length(scene)


def loop_width(scene: Scene) -> Scalar:
    """Return a lower bound (m) of the loop's width: the natural width, or half the spacing of ends farther apart."""
    return maximum(natural_width(scene), 0.5 * scene.layout.spacing)


def bending_length(scene: Scene) -> Scalar:
    """Return (EI / rho g)^(1/3) (m), the length over which bending stiffness and weight balance."""
    return (scene.rope.EI / (scene.rope.mass_per_length * scene.layout.gravity)) ** (1 / 3)


def _long_leg(scene: Scene, travel: Travel) -> Scalar:
    return left_leg_length(scene.rope.length, travel.height_difference, 0.0)
