"""Audit of each communication step: balance of momentum and energy, independent of the integrator's error estimate.

Over each communication step H the change of the rope's momentum p and of its angular momentum L is
compared with the end forces and moments and the weight:

    p_1 - p_0 - int (F_l + F_r + W) dt = H f,      L_1 - L_0 - int (M_l + M_r + M_W) dt = H m

about a point midway between the ends.  Shorter communication steps are taken together until they
last JUDGED_INTERVAL:  the small impulse by which a transformation of the mesh corrects the motion
would be a large force over 10 ns.

f and m, mean missing force and moment, are zero for the exact motion.  The trapezoidal rule of the
end forces has the error h^2 F_tt / 12, 20 N in an emergency stop.  Forces need the same weights as
accelerations: with an auxiliary value b as in method.generalized_alpha, p balances to rounding, and
L, which is not linear in the motion, up to h^2.  The mean force of each end is its impulse in this
sense, so that a conveyance that takes it gets the momentum that the rope loses.

The audit also has the change of the energy balance, the fraction of the longer leg's axial period
that a step takes, and the turn of the tangent in an element.
"""

import math
from typing import Annotated, Any, NamedTuple

from rope_model.method.generalized_alpha import Coefficients, auxiliary_weights
from rope_model.parameters import Rope
from rope_model.physics.elementary import Scalar, atan2, cross, dot, maximum, sqrt, where
from rope_model.physics.estimates import axial_frequency
from rope_model.physics.frame import end_moment
from rope_model.physics.node import NodeRow

#: force and moment of all loads, then the vertical forces of the left and of the right end alone
Load = tuple[float, float, float, float, float, float, float, float]
#: momentum, angular momentum about the origin, first moment of the mass: physics.element.MOMENTUM
Sums = tuple[float, float, float, float, float, float, float, float, float]
END_LOADS = 6  #: index of the left end's vertical force in a load
LOADS = END_LOADS + 2  #: numbers of a load
NO_LOAD: Load = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

# bounds, ten times and more the values of windings, releases and emergency stops at the levels
# draft and standard
MISSING_FORCE = 1e-3  #: missing force over the largest end force
MISSING_MOMENT = 5e-3  #: missing moment over the largest end force times the spacing
#: s, time over which an impulse that is missing counts as a force: below the usual steps of 5 ms
#: and more, and with the correction of a transformation, some 1e-4 N m s, far below MISSING_MOMENT
JUDGED_INTERVAL = 4e-3
#: time steps in an axial period: in an emergency stop of the 120 m rope the error of end forces is
#: 4 % with 3.1, 8 % with 2.1
MIN_STEPS = 3.0
#: change of an end force in a step over the largest force, above which the number of steps in a
#: period matters
LARGE_CHANGE = 0.05
#: elements in half a turn of the sharpest bend, below which the error of the loop's position is
#: irregular
MIN_ELEMENTS = 3.0


class Audit(NamedTuple):
    """Reference of the next communication step's audit, and the worst values so far.

    Loads are forces and moments about the origin, of both ends together, and the vertical force of
    each end.
    """

    sums: Sums = (0.0,) * 9
    load: Load = NO_LOAD
    auxiliary: Load = NO_LOAD
    rate: Load = NO_LOAD
    impulse: Load = NO_LOAD  # integral since the last communication
    force: float = 0.0  # N, largest end force
    missing_force: float = 0.0  # N
    missing_moment: float = 0.0  # N m
    energy: float = 0.0  # J, largest change of the balance's residual
    force_change: float = 0.0  # N, largest change of an end force in one step
    period_fraction: float = 0.0  # largest fraction of an axial period that a step took
    bend: float = 0.0  # largest squared change of r' over an element
    # s, since the reference, of communication steps that were too short to judge
    interval: float = 0.0


class AuditedStep(NamedTuple):
    """Time step, as the audit sees it."""

    h: float  # s
    recentring: float  # s, time by which b is moved before the step
    load: Load  # at its end
    force: float  # N, largest vertical end force
    force_change: float  # N, largest change of one
    axial_share: float  # h over the longer leg's axial period


class AuditedInterval(NamedTuple):
    """Communication step, as the audit sees it."""

    h: float  # s
    sums: Sums  # at its end
    middle: tuple[float, float, float]  # m, point midway between the ends
    residual: float  # J, change of the energy balance's residual
    bend: float  # largest squared change of r' over an element


def end_load(q: NodeRow, f: NodeRow, torque: Scalar) -> Annotated[tuple[Scalar, ...], 6]:
    """Return force and moment about the origin (6,) on an end, from its coordinates and reaction (7,)."""
    x, y, z = cross(q, f)
    moment = end_moment(q[3:6], f[3:6], torque)
    return f[0], f[1], f[2], x + moment[0], y + moment[1], z + moment[2]


def axial_share(rope: Rope, bottom_s: Scalar, h: Scalar) -> Scalar:
    """Return ``h`` (s) over the longer leg's axial period."""
    return h * axial_frequency(rope, maximum(bottom_s, rope.length - bottom_s)) / (2.0 * math.pi)


def axial_step(rope: Rope) -> Scalar:
    """Return a sixth of the shortest axial period (s) of the longer leg, with the loop in the rope's middle."""
    return math.pi / (3.0 * axial_frequency(rope, 0.5 * rope.length))


def elements_per_bend(square: Scalar) -> Scalar:
    """Return the elements in half a turn whose tangents differ by the root of ``square`` from node to node."""
    quarter = 0.25 * square
    return 0.5 * math.pi / atan2(sqrt(quarter), sqrt(maximum(1.0 - quarter, 0.0)))


def signal_values(audit: Audit) -> Annotated[tuple[Scalar, ...], 6]:
    """Return the values of the signals audit.* in their order; 0 where nothing was computed yet."""
    fraction, bend = (where(x > 0, x, 1.0) for x in (audit.period_fraction, audit.bend))
    steps = where(audit.period_fraction > 0, 1.0 / fraction, 0.0)
    elements = where(audit.bend > 0, elements_per_bend(bend), 0.0)
    return (
        audit.missing_force,
        audit.missing_moment,
        audit.energy,
        audit.force_change,
        steps,
        elements,
    )


def after_step(audit: Audit, method: Coefficients, step: AuditedStep) -> Audit:
    """Return ``audit`` after a time step."""
    h = step.h
    load = step.load
    load_weight, auxiliary_weight, _, next_weight = auxiliary_weights(method, 0.0)
    gamma = method.gamma
    impulse: list[Any] = []
    auxiliary: list[Any] = []
    rate: list[Any] = []
    for k in range(LOADS):
        before = audit.auxiliary[k] + step.recentring * audit.rate[k]
        after = load_weight * audit.load[k] + auxiliary_weight * before + next_weight * load[k]
        impulse.append(audit.impulse[k] + h * ((1.0 - gamma) * before + gamma * after))
        auxiliary.append(after)
        rate.append((load[k] - audit.load[k]) / h)
    following: Audit = audit._replace(
        load=load,
        auxiliary=tuple(auxiliary),
        rate=tuple(rate),
        impulse=tuple(impulse),
        force=maximum(audit.force, step.force),
        force_change=maximum(audit.force_change, step.force_change),
        period_fraction=maximum(audit.period_fraction, step.axial_share),
    )
    return following


def after_interval(audit: Audit, interval: AuditedInterval, mass: Scalar, gravity: Scalar) -> Audit:
    """Return ``audit`` of a rope of this ``mass`` (kg) after a communication step."""
    before = audit.sums
    sums = interval.sums
    h = audit.interval + interval.h
    judged = h >= JUDGED_INTERVAL
    # the first moment is a cubic with p as its rate at both ends
    x, z = (
        0.5 * h * (before[6 + k] + sums[6 + k]) + h * h / 12.0 * (before[k] - sums[k])
        for k in (0, 2)
    )
    weight = (0.0, -mass * gravity * h, 0.0, gravity * z, 0.0, -gravity * x)
    missing = [(sums[k] - before[k] - audit.impulse[k] - weight[k]) / h for k in range(6)]
    moment = [
        m - shift for m, shift in zip(missing[3:], cross(interval.middle, missing), strict=True)
    ]
    missing_force = maximum(audit.missing_force, sqrt(dot(missing, missing)))
    missing_moment = maximum(audit.missing_moment, sqrt(dot(moment, moment)))
    following: Audit = audit._replace(
        sums=tuple(where(judged, sums[k], before[k]) for k in range(9)),
        impulse=tuple(where(judged, 0.0, impulse) for impulse in audit.impulse),
        interval=where(judged, 0.0, h),
        missing_force=where(judged, missing_force, audit.missing_force),
        missing_moment=where(judged, missing_moment, audit.missing_moment),
        energy=maximum(audit.energy, abs(interval.residual)),
        bend=maximum(audit.bend, interval.bend),
    )
    return following
