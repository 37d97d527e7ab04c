"""Step-size control: allowed error of a step, and estimates of a run's errors by time steps and mesh.

Time steps disturb the end forces by the phase error of longitudinal waves.  In one step a wave of
frequency omega and amplitude A (N) gains the error

    C (omega h)^3 A     with C of the method: the local error of the strain at the ends times Qa

and these errors add up until the wave has faded out, for 2 / (beta_K omega^2).  The slowest wave,
that of the longer leg, omega = pi c / (2 leg) with c = sqrt(Qa / rho), lasts longest.  Its error
stays below a fraction of the leg's weight if a step leaves no more than that fraction times
h / wave_duration.  A step resolves all waves well enough if this holds for a wave as large as
braking makes.

The loop's position has the position errors of the nodes in a step: it moves on, and forgets them.
Where the rope flows through it with speed v, each node turns by x = v h / w in a step, w the length
of a bend.  The relative error of the acceleration in the bend grows with x^2.  Like rho v^2 it acts
as a false tension, which shifts the loop by some x^2 v^2 / g against its weight.
"""

from typing import NamedTuple

from rope_model.parameters import Rope, Scene
from rope_model.physics.elementary import (
    Scalar,
    ceil,
    cos,
    less,
    logical_and,
    logical_or,
    maximum,
    minimum,
    sin,
    sqrt,
    where,
)
from rope_model.physics.estimates import axial_frequency, bending_length
from rope_model.solver_parameters import Solver

# fractions of allowed errors that a step may leave, tuned on seeded ropes of 60 to 1200 m (`make
# promise`)
FORCE_FRACTION = 22.0  #: fraction of the end force error
LOOP_FRACTION = 0.01  #: fraction of the loop's error, for the position of a node
FLOW_FRACTION = 0.6  #: fraction of the loop's error, for the flow through it
#: total phase error of a wave over that by the strain alone: its rate is not measured
RATE_ERROR_FACTOR = 2.0
# the loop hangs too high by LOOP_HEIGHT w x^2 N / (1 + N), N = LOCKING x^4 EA w^2 / EI:
# evidence.mesh_rule.laws
LOOP_HEIGHT = 0.0214
LOCKING = 0.0028
# a loop of long elements (x w) slips aside and turns until another node is lowest:
# evidence.mesh_rule.coarse
SLIPPED = 1.8  #: growth of the loop's position error
SLIPS_FROM = 0.87  #: x at which half of that growth is reached
TURNED = 0.033  #: rad, yaw of the loop over x
TURNS_FROM = 1.2  #: x at which half of that yaw is reached
SLIP_EXPONENT = 12  #: power of x with which both set in
# errors of the loop's position
LEG_MESH_ERROR = 4e-7  #: part by joined elements of the legs, over grading_length times length
STEP_ERROR_TO_LOOP = 12.0  #: part by time steps, over the largest position error of a node
FLOW_ERROR = 0.13  #: part by the flow, over x^2 v^2 / g
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
TINY = 1e-300
#: Newton iterations of a step where they are bounded: the largest number in recorded trips
STEP_ITERATIONS = 12
# errors (m and rad) that Newton's method may leave where work is bounded to one step
BOUNDED_STEP_ERROR = 1e-4
BOUNDED_MESH_ERROR = 2e-3  #: on a new mesh
MIN_LEFT = 0.1  #: fraction of the allowance that remains when all is used up
BRAKED = 0.5  #: amplitude of the largest wave over the leg's weight: an emergency stop at 5 m/s^2
# bounds of a wave's duration with little material damping
MAX_WAVE = 60.0  #: s, a trip
MAX_PHASE = 400.0  #: rad, as of the longest ropes with damping


class StepLimits(NamedTuple):
    """Allowed errors of a step."""

    position: float  # m, of a node
    strain_rate: float  # 1/s, error of the strain at an end over the step
    shortest: float  # s, step below which the strain is not checked
    longest: float  # s, step allowed by the flow through the loop
    position_power: float
    strain_power: float


class ErrorSums(NamedTuple):
    """Errors of the steps since the start.

    ``waves``: strain error at the end by the slowest wave of each leg, now and a quarter of a
    period later, left and right.  ``strain_tt``: mean accelerations of these strains in the latest
    step.
    """

    time: float = 0.0  # s
    position: float = 0.0  # m, largest position error of a step
    flow: float = 0.0  # m, largest error of the loop's position by the flow through it
    force: float = 0.0  # N, largest end force
    waves: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    squares: tuple[float, float] = (0.0, 0.0)  # s, time integrals of the squared strain errors
    strain_tt: tuple[float, float] = (0.0, 0.0)  # 1/s^2


class MeasuredStep(NamedTuple):
    """Accepted step, as the error sums see it.

    ``strain_tt`` are means over the step, from the strain rates at its ends: the accelerations at
    its end contain what stiff waves leave there.
    """

    h: float  # s
    bottom_s: float  # m, arc length of the loop's lowest point
    end_speed: float  # m/s, vertical speed of one end against the other
    strain_tt: tuple[float, float]  # 1/s^2, mean accelerations of the end strains
    position: float  # m, local error of the positions
    force: float  # N, largest end force


def wave_duration(rope: Rope, omega: Scalar) -> Scalar:
    """Return the duration (s) of a wave of frequency ``omega`` (rad/s)."""
    return 2.0 / maximum(
        rope.beta_K * (omega * omega), 2.0 * maximum(omega / MAX_PHASE, 1.0 / MAX_WAVE)
    )


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
        FLOW_FRACTION * accuracy.loop / maximum(flow_error(scene, end_speed, 1.0), TINY)
    )
    rubs = less(rope.EI, rope.EI_stick)
    powers = where(rubs, RUBBING_POSITION_POWER, 1.0), where(rubs, RUBBING_STRAIN_POWER, 1.0)
    return StepLimits(
        LOOP_FRACTION * accuracy.loop, allowed * strain, shortest, sqrt(longest_squared), *powers
    )


def add_errors(
    scene: Scene, sums: ErrorSums, step: MeasuredStep, error_constant: Scalar
) -> ErrorSums:
    """Return ``sums`` after a step.

    The local error is ``error_constant`` h^2 per change of the strains' mean accelerations, but for
    a stiff wave, which follows the forces, at most the change over omega^2.
    """
    rope = scene.rope
    h = step.h
    waves = []
    squares = []
    for side, leg in enumerate((step.bottom_s, rope.length - step.bottom_s)):
        omega = axial_frequency(rope, leg)
        duration = wave_duration(rope, omega)
        decay = duration / (duration + h)
        phase = omega * h
        cosine = decay * cos(phase)
        sine = decay * sin(phase)
        present = sums.waves[2 * side]
        later = sums.waves[2 * side + 1]
        local = (
            error_constant
            * (h * h)
            / (1.0 + error_constant * (phase * phase))
            * (step.strain_tt[side] - sums.strain_tt[side])
        )
        waves += [cosine * present + sine * later + local, cosine * later - sine * present]
        squares.append(sums.squares[side] + h * (waves[-2] * waves[-2]))
    return ErrorSums(
        time=sums.time + h,
        position=maximum(sums.position, step.position),
        flow=maximum(sums.flow, flow_error(scene, step.end_speed, h)),
        force=maximum(sums.force, step.force),
        waves=(waves[0], waves[1], waves[2], waves[3]),
        squares=(squares[0], squares[1]),
        strain_tt=step.strain_tt,
    )


def end_force_error(rope: Rope, sums: ErrorSums) -> Scalar:
    """Return the error of the end forces, root mean square since the start, relative to the largest force."""
    squares = maximum(sums.squares[0], sums.squares[1])
    return (
        RATE_ERROR_FACTOR
        * rope.Qa
        * sqrt(squares / maximum(sums.time, TINY))
        / maximum(sums.force, TINY)
    )


def locking_error(scene: Scene, l: Scalar) -> Scalar:
    """Return the height (m) by which the loop hangs too high on elements of length ``l``."""
    w = bending_length(scene)
    rope = scene.rope
    x = l / w
    locking = LOCKING * (rope.Qa * (w * w) / rope.EI) * (x * x * x * x)
    return LOOP_HEIGHT * w * (x * x) * (locking / (1.0 + locking))


def mesh_error(scene: Scene, l: Scalar, grading_length: Scalar) -> Scalar:
    """Return the loop's position error (m) on elements of length ``l``, with ``grading_length`` in the legs."""
    slip_factor = 1.0 + SLIPPED * _slip_fraction(scene, l, SLIPS_FROM)
    return (
        locking_error(scene, l) * slip_factor + LEG_MESH_ERROR * grading_length * scene.rope.length
    )


def turned_by_mesh(scene: Scene, l: Scalar) -> Scalar:
    """Return the angle (rad) by which elements of length ``l`` turn the loop about the vertical."""
    return TURNED * l / bending_length(scene) * _slip_fraction(scene, l, TURNS_FROM)


def _slip_fraction(scene: Scene, l: Scalar, threshold: float) -> Scalar:
    """Return the fraction, 0 to 1, of a change that sets in where elements are ``threshold`` w long."""
    power = minimum(l / (threshold * bending_length(scene)), 10.0) ** SLIP_EXPONENT
    return power / (1.0 + power)


def length_for(scene: Scene, error: Scalar) -> Scalar:
    """Return the length (m) of elements whose ``locking_error`` is between half of ``error`` (m) and ``error``."""
    w = bending_length(scene)
    rope = scene.rope
    ratio = error / (LOOP_HEIGHT * w)
    return w * maximum(sqrt(ratio), (ratio / (LOCKING * (rope.Qa * (w * w) / rope.EI))) ** (1 / 6))


def flow_error(scene: Scene, end_speed: Scalar, h: Scalar) -> Scalar:
    """Return the loop's position error (m) by steps ``h`` as the rope flows at half of ``end_speed`` (m/s)."""
    flow = 0.5 * end_speed
    angle = flow * h / bending_length(scene)
    return FLOW_ERROR * (angle * angle) * (flow * flow) / scene.layout.gravity


def step_error(
    limits: StepLimits, h: Scalar, position_error: Scalar, strain_error: Scalar
) -> Scalar:
    """Return the step's error over the allowed one.

    It is the largest of position error^position_power, end strain error^strain_power (only if
    h > shortest), each over its limit, and (h / longest)^4 for the flow through the loop.
    """
    flow = h / limits.longest
    position = maximum(
        (position_error / limits.position) ** limits.position_power, flow * flow * (flow * flow)
    )
    strain = (strain_error / (h * limits.strain_rate)) ** limits.strain_power
    return where(less(limits.shortest, h), maximum(position, strain), position)


def loop_error(scene: Scene, sums: ErrorSums, l: Scalar, grading_length: Scalar) -> Scalar:
    """Return the largest error (m) of the loop's position since the start, by elements, legs and steps."""
    mesh = mesh_error(scene, l, grading_length)
    steps = STEP_ERROR_TO_LOOP * sums.position
    return sqrt(
        mesh * mesh + steps * steps + sums.flow * sums.flow
    )  # the three occur at different instants


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


def effective_tolerance(
    newton_tolerance: Scalar, work_max: Scalar, bounded_tolerance: Scalar
) -> Scalar:
    """Return Newton's tolerance (m and rad), at least ``bounded_tolerance`` where work is bounded to one step."""
    bounded = logical_and(work_max > 0.0, work_max < 2.0 * STEP_ITERATIONS)
    return where(bounded, maximum(newton_tolerance, bounded_tolerance), newton_tolerance)
