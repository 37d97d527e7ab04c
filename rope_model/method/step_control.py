"""Step-size control: the allowed error of a step, its error over that, and the next step.

Time steps disturb the end forces by the phase error of longitudinal waves.  In one step a wave of
frequency omega and amplitude A (N) gains the error

    C (omega h)^3 A     with C of the method: the local error of the strain at the ends times Qa

and these errors add up until the wave has faded out, for 2 / (beta_K omega^2).  The slowest wave,
that of the longer leg, omega = pi c / (2 leg) with c = sqrt(Qa / rho), lasts longest.  Its error
stays below a fraction of the leg's weight if a step leaves no more than that fraction times
h / wave_duration.  A step resolves all waves well enough if this holds for a wave as large as
braking makes.
"""

import math
from typing import NamedTuple

from rope_model.method import leg_waves
from rope_model.method.step_errors import ErrorSums, end_force_error, flow_error, wave_duration
from rope_model.parameters import Scene
from rope_model.physics.elementary import (
    SMALLEST_DIVISOR,
    Scalar,
    ceil,
    less,
    logical_and,
    logical_or,
    maximum,
    minimum,
    sqrt,
    where,
)
from rope_model.physics.estimates import axial_frequency
from rope_model.solver_parameters import Solver

# fractions of allowed errors that a step may leave, tuned on seeded ropes of 60 to 1200 m (`make
# promise`)
FORCE_FRACTION = 22.0  #: fraction of the end force error
LOOP_FRACTION = 0.01  #: fraction of the loop's error, for the position of a node
FLOW_FRACTION = 0.6  #: fraction of the loop's error, for the flow through it
#: rad, lag of waves of mesh.lateral_frequency on their way down, over the allowed end force error
LAG_FRACTION = 50.0
MIN_LEFT = 0.1  #: fraction of the allowance that remains when all is used up
BRAKED = 0.5  #: amplitude of the largest wave over the leg's weight: an emergency stop at 5 m/s^2
# wires that begin to slide or stick make the acceleration jump: position and strain errors grow
# with h^2 and h only
RUBBING_POSITION_POWER = 2.0
RUBBING_STRAIN_POWER = 4.0
# small errors for so long let the step grow.  Every change of its length shifts the loop a little
# and so sends a wave along the rope, which is the smaller the shorter the step.  An absolute time:
# some periods of the legs' axial waves of ropes of 30 to 500 m, which last 0.015 to 0.26 s; it
# affects the number of steps, not what is allowed as error
GROWTH_DELAY = 0.2  #: s
GROWTH_DELAY_STEPS = 100.0  #: steps, where these take less
#: a step above the tolerance halves the next one; above this many times the tolerance it is
#: rejected
ACCEPT_BELOW = 2.0
GROW_BELOW = 0.05  #: fraction of the tolerance below which an error is small


class StepLimits(NamedTuple):
    """Allowed errors of a step."""

    position: float  # m, of a node
    strain_rate: float  # 1/s, error of the strain at an end over the step
    shortest: float  # s, step below which the strain is not checked
    longest: float  # s, step allowed by the flow through the loop, and by ends that shake sideways
    position_power: float
    strain_power: float


def step_limits(
    scene: Scene, sums: ErrorSums, s: Scalar, end_speed: Scalar, error_constant: Scalar
) -> StepLimits:
    """Return the limits of a step while the loop hangs at arc length ``s`` (m).

    ``end_speed`` (m/s) is the vertical speed of one end against the other; ``error_constant`` h^2
    is the local error per change of the acceleration.  The allowance shrinks as it is used up.
    """
    rope = scene.rope
    accuracy = scene.accuracy
    leg = maximum(s, rope.length - s)
    omega = axial_frequency(rope, leg)
    duration = wave_duration(rope, omega)
    used = end_force_error(rope, sums) / accuracy.end_force
    allowed = FORCE_FRACTION * maximum(1.0 - used, MIN_LEFT) * accuracy.end_force / duration
    strain = rope.mass_per_length * scene.layout.gravity * leg / rope.Qa
    shortest = sqrt(allowed / (BRAKED * error_constant * (omega * omega * omega)))
    longest_squared = (
        FLOW_FRACTION * accuracy.loop / maximum(flow_error(scene, end_speed, 1.0), SMALLEST_DIVISOR)
    )
    lag = leg_waves.lag_rate(scene, 2.0 * math.pi * scene.mesh.lateral_frequency)
    lag_squared = (
        LAG_FRACTION * accuracy.end_force / maximum(error_constant * lag, SMALLEST_DIVISOR)
    )
    longest_squared = minimum(longest_squared, lag_squared)
    rubs = less(rope.EI, rope.EI_stick)
    powers = where(rubs, RUBBING_POSITION_POWER, 1.0), where(rubs, RUBBING_STRAIN_POWER, 1.0)
    return StepLimits(
        LOOP_FRACTION * accuracy.loop, allowed * strain, shortest, sqrt(longest_squared), *powers
    )


def step_error(
    limits: StepLimits, h: Scalar, position_error: Scalar, strain_error: Scalar
) -> Scalar:
    """Return the step's error over the allowed one.

    It is the largest of position error^position_power, end strain error^strain_power (only if
    h > shortest), each over its limit, and (h / longest)^4 for the flow through the loop and shaking ends.
    """
    flow = h / limits.longest
    position = maximum(
        (position_error / limits.position) ** limits.position_power, flow * flow * (flow * flow)
    )
    strain = (strain_error / (h * limits.strain_rate)) ** limits.strain_power
    return where(less(limits.shortest, h), maximum(position, strain), position)


def growth_delay(h: Scalar, step_next: Scalar) -> Scalar:
    """Return the time (s) for which errors must be small before a step ``h`` may grow to ``step_next``."""
    # the limit lies between two steps: on a whole number of steps rounding would decide
    return minimum(GROWTH_DELAY_STEPS * step_next, GROWTH_DELAY) - 0.5 * h


class AcceptedStep(NamedTuple):
    """Accepted step, as the choice of the next one sees it."""

    h: float  # s
    t: float  # s, its end
    error: float  # over the allowed one
    rejected: float  # not 0 if longer steps failed


class NextStep(NamedTuple):
    """Length (s) of the next step, instant (s) since which errors are small, and 1 if accuracy was given up."""

    length: float
    calm_since: float
    given_up: float


def next_step(
    solver: Solver, accepted: AcceptedStep, step_next: Scalar, calm_since: Scalar
) -> NextStep:
    """Choose the step after the one ``accepted``; ``step_next`` (s) was the choice before it.

    An error above the tolerance halves the next step; small errors for the time growth_delay double
    it.  A larger error than ACCEPT_BELOW is accepted only when the Newton budget is used up.
    """
    h, t, error, rejected = accepted
    calm_since = where(logical_or(rejected, error > GROW_BELOW * solver.tolerance), t, calm_since)
    given_up = error > ACCEPT_BELOW * solver.tolerance
    keeps = logical_or(given_up, error <= solver.tolerance)
    grows = logical_and(
        keeps, t - calm_since > growth_delay(h, step_next), step_next < solver.step_max
    )
    longer = where(grows, minimum(2.0 * step_next, solver.step_max), step_next)
    return NextStep(
        where(keeps, longer, maximum(0.5 * h, solver.step_min)),
        where(grows, t, calm_since),
        where(logical_or(given_up, h > solver.step_max * (1.0 + 1e-9)), 1.0, 0.0),
    )


def substeps(interval: Scalar, step_next: Scalar, steps_left: Scalar) -> Scalar:
    """Return the number of steps for an ``interval`` (s), at most as many as the Newton budget allows.

    Steps may be longer than ``step_next``, but no more than twice as long: Newton's method need not
    converge then.
    """
    parts = maximum(ceil(interval / step_next - 1e-9), 1.0)
    return minimum(parts, maximum(steps_left, ceil(0.5 * parts)))
