"""Error that a step may make for a run within the accuracy asked for, and estimates of the error made.

Steps let the end forces err by the phase of longitudinal waves.  One of frequency omega and amplitude A (N) gains

    C (omega h)^3 A     in a step, C of the method, seen as the local error of the strain at the ends times Qa

and the errors add up until the wave has faded out, for 2 / (beta_K omega^2).  The slowest wave, that of the longer leg,
omega = pi c / (2 leg) with c = sqrt(Qa / rho), lasts longest.  So that its error stays below a share of the leg's
weight a step may leave that share of it times h / memory.  A step resolves all waves well enough if it does so with one
as large as braking makes.

The loop's place has the errors of the nodes' places in a step: it moves on, and forgets them.  Where the rope flows
through it with speed v, each node turns by x = v h / w in a step, w the length of a bend.  The relative error of the
acceleration in the bend goes with x^2.  Like rho v^2 that part is a false tension, and the loop is off by some x^2 v^2
/ g, held against its weight.
"""

from typing import Any, NamedTuple

from rope_model.physics.elementary import both, ceil, cos, either, larger, less, sin, smaller, sqrt, where
from rope_model.physics.estimates import axial_frequency, bending_length

#: share of the error asked for that a step may leave: tuned on seeded ropes of 60 to 1200 m, judged by `make promise`
FORCE_SHARE, PLACE_SHARE = 22.0, 0.01
#: a step's error of the rate turns the wave's phase as much as that of the strain, which alone is seen
RATE_ERROR_FACTOR = 2.0
#: the loop hangs too high by LOOP_HEIGHT w x^2 N / (1 + N), N = LOCKING x^4 EA w^2 / EI: evidence.mesh_rule.laws
LOOP_HEIGHT, LOCKING = 0.0214, 0.0028
#: a loop of elements of x w and more slips aside and turns, by which node comes to hang lowest: it is off by up to
#: 1 + SLIPPED times as much beyond x = SLIPS_FROM, and yawed by up to TURNED x (rad) beyond TURNS_FROM; the change goes
#: with the power SLIP_EXPONENT (evidence.mesh_rule.coarse)
SLIPPED, SLIPS_FROM, TURNED, TURNS_FROM, SLIP_EXPONENT = 1.8, 0.87, 0.033, 1.2, 12
#: error of the loop's place by joined elements of the legs over grading_length times length, and by steps over the
#: largest error of a node's place
LEG_MESH_ERROR, STEPS = 4e-7, 12.0
#: error of the loop's place over x^2 v^2 / g, and the share of it that a step may take: tuned on the same ropes
FLOW, FLOW_SHARE = 0.13, 0.6
#: wires that begin to slide or stick change the acceleration at once, whatever the step: errors of place and strain
#: over the allowed ones go with h^2 and h
RUBBED_PLACE, RUBBED_STRAIN = 2.0, 4.0
#: s, and steps: after so much of small errors steps grow.  The loop's place errs by a part that goes with the step's
#: length, and every change of that sends a wave along the rope, which is the smaller the shorter the step
GROWTH_DELAY, GROWTH_DELAY_STEPS = 0.2, 100.0
#: a step with more than the allowed error makes the next one half as long, and this many times that is rejected
ACCEPT_BELOW = 2.0
#: the step grows after errors below this part of the allowed one for the time of growth_delay
GROW_BELOW = 0.05
TINY = 1e-300
#: Newton iterations that a step is reckoned to take where they are bounded: the most that steps of trips took
STEP_WORK = 12
#: m and rad: errors that Newton's method may leave in a step, and on a new mesh, where work is bounded to one step
BOUNDED_STEP_ERROR, BOUNDED_MESH_ERROR = 1e-4, 2e-3
#: part of the share that is left when all is used up
LEAST_LEFT = 0.1
#: amplitude of the largest wave over the leg's weight: an emergency stop at 5 m/s^2
BRAKED = 0.5
#: without material damping waves last as long as a trip, s, or as many radians: those of the longest ropes with damping
LONGEST_MEMORY, MOST_TURNED = 60.0, 400.0


class StepLimits(NamedTuple):
    """Allowed errors of a step."""

    place: float  # m, of a node's place
    strain_rate: float  # 1/s, of the strain at an end, over the step
    shortest: float  # s: a shorter step is short enough for the strain
    longest: float  # s, for the flow through the loop
    place_power: float
    strain_power: float


class ErrorSums(NamedTuple):
    """Errors of the steps since the start.

    ``waves``: of the slowest wave of the left and of the right leg, the error of the strain at its end, and the same a
    quarter of a period later.  ``paces``: mean accelerations of these strains in the latest step.
    """

    time: float = 0.0  # s
    place: float = 0.0  # m, largest of a step
    flow: float = 0.0  # m, largest of the loop's place, by the flow through it
    force: float = 0.0  # N, largest end force
    waves: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    squares: tuple[float, float] = (0.0, 0.0)  # s, time integrals of the squares of the strains' errors
    paces: tuple[float, float] = (0.0, 0.0)  # 1/s^2


def memory(rope: Any, omega: Any) -> Any:
    """Duration (s) of a wave of a frequency."""
    least = larger(omega / MOST_TURNED, 1.0 / LONGEST_MEMORY)
    return 2.0 / larger(rope.beta_K * (omega * omega), 2.0 * least)


def step_limits(scene: Any, sums: Any, bottom: Any, apart: Any, error_constant: Any) -> StepLimits:
    """Limits for a rope whose loop hangs at arc length ``bottom`` and whose ends move ``apart`` vertically, m/s.

    The method errs by ``error_constant`` h^2 per change of a.

    The allowance shrinks as it is used up.
    """
    rope, accuracy = scene.rope, scene.accuracy
    leg = larger(bottom, rope.length - bottom)
    omega = axial_frequency(rope, leg)
    lasts = memory(rope, omega)
    used = end_force_error(rope, sums) / accuracy.end_force
    share = FORCE_SHARE * larger(1.0 - used, LEAST_LEFT) * accuracy.end_force / lasts
    strain = rope.mass_per_length * scene.layout.gravity * leg / rope.Qa
    shortest = sqrt(share / (BRAKED * error_constant * (omega * omega * omega)))
    flows = FLOW_SHARE * accuracy.loop / larger(flow_error(scene, apart, 1.0), TINY)
    rubs = less(rope.EI, rope.EI_stick)
    powers = where(rubs, RUBBED_PLACE, 1.0), where(rubs, RUBBED_STRAIN, 1.0)
    return StepLimits(PLACE_SHARE * accuracy.loop, share * strain, shortest, sqrt(flows), *powers)


def add_errors(
    scene: Any, sums: Any, bottom: Any, apart: Any, h: Any, constant: Any, paces: Any, place: Any, force: Any
) -> ErrorSums:
    """``sums`` after a step ``h`` that left ``place``, with end forces of up to ``force`` now.

    ``paces`` are the mean accelerations of the strains at the ends in the step, by their rates: unlike the
    accelerations at its end they have none of what stiff waves leave there and no longer move.  The method errs by
    ``constant`` h^2 per change of them; of a stiff wave, which follows the forces, by at most the change over omega^2.
    """
    rope = scene.rope
    waves, squares = [], []
    for side, leg in enumerate((bottom, rope.length - bottom)):
        omega = axial_frequency(rope, leg)
        lasts = memory(rope, omega)
        fades, turns = lasts / (lasts + h), omega * h
        cosine, sine = fades * cos(turns), fades * sin(turns)
        now, later = sums.waves[2 * side], sums.waves[2 * side + 1]
        left = constant * (h * h) / (1.0 + constant * (turns * turns)) * (paces[side] - sums.paces[side])
        waves += [cosine * now + sine * later + left, cosine * later - sine * now]
        squares.append(sums.squares[side] + h * (waves[-2] * waves[-2]))
    largest = larger(sums.place, place), larger(sums.flow, flow_error(scene, apart, h)), larger(sums.force, force)
    of_waves = (waves[0], waves[1], waves[2], waves[3]), (squares[0], squares[1])
    return ErrorSums(sums.time + h, *largest, *of_waves, (paces[0], paces[1]))


def end_force_error(rope: Any, sums: Any) -> Any:
    """Error of the end forces, root mean square since the start, relative to the largest."""
    squares = larger(sums.squares[0], sums.squares[1])
    return RATE_ERROR_FACTOR * rope.Qa * sqrt(squares / larger(sums.time, TINY)) / larger(sums.force, TINY)


def locking_error(scene: Any, fine: Any) -> Any:
    """Height (m) by which the loop hangs too high on elements of length ``fine``."""
    w, rope = bending_length(scene), scene.rope
    x = fine / w
    locked = LOCKING * (rope.Qa * (w * w) / rope.EI) * (x * x * x * x)
    return LOOP_HEIGHT * w * (x * x) * (locked / (1.0 + locked))


def mesh_error(scene: Any, fine: Any, grading_length: Any) -> Any:
    """Error (m) of the loop's place on elements of length ``fine``, with ``grading_length`` in the legs."""
    slips = 1.0 + SLIPPED * _slips(scene, fine, SLIPS_FROM)
    return locking_error(scene, fine) * slips + LEG_MESH_ERROR * grading_length * scene.rope.length


def turned_by_mesh(scene: Any, fine: Any) -> Any:
    """Angle (rad) by which elements of length ``fine`` turn the loop about the vertical."""
    return TURNED * fine / bending_length(scene) * _slips(scene, fine, TURNS_FROM)


def _slips(scene: Any, fine: Any, beyond: float) -> Any:
    """Share, 0 to 1, of the loop's change over so many w ``beyond``."""
    power = smaller(fine / (beyond * bending_length(scene)), 10.0) ** SLIP_EXPONENT
    return power / (1.0 + power)


def length_for(scene: Any, error: Any) -> Any:
    """Length of elements with at most that ``locking_error``, and at least half of it."""
    w, rope = bending_length(scene), scene.rope
    part = error / (LOOP_HEIGHT * w)
    return w * larger(sqrt(part), (part / (LOCKING * (rope.Qa * (w * w) / rope.EI))) ** (1 / 6))


def flow_error(scene: Any, apart: Any, h: Any) -> Any:
    """Error (m) of the loop's place by steps ``h`` while its ends move ``apart`` (m/s) and the rope flows."""
    flow = 0.5 * apart
    turned = flow * h / bending_length(scene)
    return FLOW * (turned * turned) * (flow * flow) / scene.layout.gravity


def step_error(limits: Any, h: Any, place: Any, strain: Any) -> Any:
    """Error of a step ``h`` that left ``place`` and ``strain``, over the error allowed, and error by the flow.

    By the flow, and where wires rub, to powers for which twice the step is allowed where errors are small.
    """
    turned = h / limits.longest
    of_place = larger((place / limits.place) ** limits.place_power, turned * turned * (turned * turned))
    of_strain = (strain / (h * limits.strain_rate)) ** limits.strain_power
    return where(less(limits.shortest, h), larger(of_place, of_strain), of_place)


def loop_error(scene: Any, sums: Any, fine: Any, grading_length: Any) -> Any:
    """Largest error of the loop's place since the start, m: of elements, legs and steps."""
    mesh = mesh_error(scene, fine, grading_length)
    swung = STEPS * sums.place
    return sqrt(mesh * mesh + swung * swung + sums.flow * sums.flow)  # at other places and instants


def growth_delay(h: Any, step_next: Any) -> Any:
    """Time (s) for which errors must be small before a step ``h`` may grow to ``step_next``."""
    # half a step early: where a whole number of steps takes as long, rounding would decide
    return smaller(GROWTH_DELAY_STEPS * step_next, GROWTH_DELAY) - 0.5 * h


class NextStep(NamedTuple):
    """Length (s) of the step to try next, since when (s) errors are small, and 1 where accuracy was given up."""

    length: float
    calm_since: float
    given_up: float


def next_step(solver: Any, h: Any, step_next: Any, error: Any, rejected: Any, t: Any, calm_since: Any) -> NextStep:
    """Choose the step after one of length ``h`` to ``t`` with this ``error`` over the allowed one.

    Work ran out where it is too large.  ``rejected``: whether longer steps failed.  An error above the tolerance halves
    the next step; small ones for the time growth_delay double it.
    """
    calm_since = where(either(rejected, error > GROW_BELOW * solver.tolerance), t, calm_since)
    given_up = error > ACCEPT_BELOW * solver.tolerance
    as_asked = either(given_up, error <= solver.tolerance)
    grows = both(as_asked, t - calm_since > growth_delay(h, step_next), step_next < solver.step_max)
    longer = where(grows, smaller(2.0 * step_next, solver.step_max), step_next)
    return NextStep(
        where(as_asked, longer, larger(0.5 * h, solver.step_min)),
        where(grows, t, calm_since),
        where(either(given_up, h > solver.step_max * (1.0 + 1e-9)), 1.0, 0.0),
    )


def substeps(way: Any, step_next: Any, left: Any) -> Any:
    """Number of steps into which the ``way`` (s) is divided where the work that is left allows for so many.

    It may take longer ones than ``step_next``, but Newton's method need not converge in much longer ones.
    """
    parts = larger(ceil(way / step_next - 1e-9), 1.0)
    return smaller(parts, larger(left, ceil(0.5 * parts)))


def newton_may_leave(newton_tolerance: Any, work_max: Any, hasty: Any) -> Any:
    """Error (m and rad) that Newton's method may leave, ``hasty`` where work is bounded to one step."""
    bounded = both(work_max > 0.0, work_max < 2.0 * STEP_WORK)
    return where(bounded, larger(newton_tolerance, hasty), newton_tolerance)
