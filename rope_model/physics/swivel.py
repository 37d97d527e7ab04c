"""Friction of the swivel's bearing, the balance rope suspension rotor (BRSR).

The law is set-valued, not regularised, for the relative angle b and the moment M of the conveyance
on the rope:

    stick: b_t = 0 and |M| <= M_static        slip: M = -M_dynamic sgn(b_t)
    M_static = 1/2 mu_s d_m T + M_seal        M_dynamic = 1/2 mu_k d_m T + M_seal

with the tension T at the rope's end, the force along the tangent there.  T counts from zero: a rope
that pushes does not reduce the seal's friction.
"""

from typing import NamedTuple

from rope_model.physics.elementary import Scalar, Vector3, dot, maximum, sqrt


class Friction(NamedTuple):
    """Moment that a bearing transmits as a function of the tension: constant + per_tension T."""

    constant: Scalar  # N m
    per_tension: Scalar  # N m over N


def tension_along(sense: Scalar, d: Vector3, force: Vector3) -> Scalar:
    """Return the tension (N) at an end from the conveyance's ``force`` (3,) on it and its r' = ``d`` (3,).

    ``sense`` is -1 at the left end, where the tangent leads away from the conveyance, and +1 at the
    right one.
    """
    return sense * (dot(d, force) / sqrt(dot(d, d)))


def friction_law(mu: Scalar, mean_diameter: Scalar, seal_moment: Scalar) -> Friction:
    """Return the largest moment that friction with coefficient ``mu`` transmits."""
    return Friction(constant=seal_moment, per_tension=0.5 * mu * mean_diameter)


def pressing_tension(tension: Scalar) -> Scalar:
    """Return the part of the ``tension`` (N) that presses the bearing: none of a rope that pushes."""
    return maximum(tension, 0.0)


def friction_moment(friction: Friction, tension: Scalar) -> Scalar:
    """Return the moment (N m) at ``tension`` (N)."""
    return friction.per_tension * pressing_tension(tension) + friction.constant
