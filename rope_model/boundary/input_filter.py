"""Input filter: from the motions that a host gives to smooth motions of the rope's ends.

Position, speed and acceleration of a host need not be consistent: tables are interpolated, encoders
round, slower components repeat.  A rope is stiff along its axis, 1 kN per mm and more, so its end
must not jump after every sample.  The end's motion x is therefore a state of its own.  It
integrates the given acceleration A and approaches the given position X and speed V slowly, as a
critically damped observer of second order:

    x_tt = A + 2 w (V - x_t) + w^2 (X - x).

Its bandwidth w follows from the required accuracy: a misfit as large as the error of the loop's
position, e_L, must not disturb the end forces by more than their error, e_F.  The disturbance is
w^2 e_L / g, so w = sqrt(e_F g / e_L).

A smooth motion leaves a remainder too: the quintic path between two samples knows only the
accelerations at its ends.  The part that a change of the acceleration within a step explains is
therefore met within the step, and only the rest is left to the observer.  A consistent motion is
followed exactly.

Inputs that a host does not give are estimated by fading-memory filters: E. Brookner, Tracking and
Kalman Filtering Made Easy, 1998, chapter 7.  A filter of n-th order with the bandwidth W lags
behind an acceleration of the rate J by n J / W.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, NamedTuple

from rope_model.boundary import quintic
from rope_model.boundary.end_paths import LEANS, PATH, RESTS_BELOW, EndMotion, EndPath
from rope_model.boundary.quintic import Quintic
from rope_model.parameters import CHOICES, Scene
from rope_model.physics.elementary import (
    Scalar,
    Vector,
    exp,
    floor,
    logical_and,
    logical_or,
    maximum,
    minimum,
    sqrt,
    where,
)
from rope_model.physics.estimates import axial_frequency

#: m/s^3, jerk that a consistent motion may have at any instant.  To follow it within a step h the
#: path needs an additional acceleration of at most 5.8 h times the jerk: 0.1 % of g where h = 20 ms
ALLOWED_JERK = 0.1
#: rad/s^3, the same for a yaw, which only twists the rope; FMI gives no yaw acceleration.  3
#: degrees at 2 Hz have it
ALLOWED_YAW_JERK = 100.0
JERKS = (*(ALLOWED_JERK,) * 3, ALLOWED_YAW_JERK)
#: bandwidth of estimates over the frequency of the rope's slowest axial wave: 1/10 of a motion at
#: that frequency passes (order 2), or 1/32 (order 3)
ESTIMATE_FRACTION = 1.0 / 3.0
#: m, grids of rounded positions that are recognised
GRIDS = (1e-2, 1e-3, 1e-4)
#: tolerance in multiples of a grid: doubles round 1e4 m by 1e-8 of the finest
ON_GRID = 1e-6
#: s, time below which the mean acceleration from a rate of six decimals is off by more than
#: 1e-3 rad/s^2
MIN_MEAN_TIME = 1e-3
#: s, time in which the rounding of positions of 1e4 m, 2e-12 m, takes some 0.1 m/s^2; in 1e-8 s it
#: takes 1e5
MIN_AIM_TIME = 1e-5
#: m/s, least change of speed between samples that reveals a broken line: twice the error of six
#: decimals in 10 ms
MIN_CHANGE = 2e-4
# change of the speed over that by the acceleration: 1 in a smooth motion, n at a break of a table
# of n steps
STRAIGHT = 0.2  #: upper bound on a straight line; the jerk makes up a fifth
BROKEN = 1.8  #: lower bound at a break
#: breaks after pieces of equal length that reveal a table: random pieces of 2 or 3 steps are alike
#: so once in 2^7
MIN_BREAKS = 8.0
#: relative difference of such lengths: less than a step of a table of a hundred
TABLE_TOLERANCE = 0.01

#: a jump where the acceleration is given: its sample is compared with the path instead
NOT_ESTIMATED = -1.0
#: largest lag of an estimate in times of its bandwidth: that of the highest order
MAX_LAG = 3.0

#: codes of the trusted inputs
ALL, POSITION_SPEED, POSITION, SPEED = range(len(CHOICES["inputs.given"]))

Four = tuple[float, float, float, float]
Axis = tuple[float, float, float]
Sample = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float, float
]


class Misfits(NamedTuple):
    """Sums of the misfits between given and followed motion, and of their effects."""

    time: float = 0.0  # s
    position: float = 0.0  # m, largest so far
    speed: float = 0.0  # m/s, largest
    acceleration: float = 0.0  # m/s^2, largest
    squares: Axis = (0.0, 0.0, 0.0)  # time integrals of the squares of the three
    # m/s^2, slowest axial wave of the leg, now and a quarter period later
    wave: tuple[float, float] = (0.0, 0.0)
    lag: float = 0.0  # m/s^2, lag of an estimated acceleration of y
    force_error_square: float = 0.0  # N^2 s, time integral of the square of the end force's error
    drift: float = 0.0  # m, slow part of the misfit of y
    max_drift: float = 0.0  # m, largest size of the drift


class Repetitions(NamedTuple):
    """Repetitions of samples by a slower component."""

    number: float = 0.0  # of steps with the sample of an earlier one
    held: float = 0.0  # number of steps since the latest sample
    sent_every: float = 0.0  # s, time between the latest samples with repetitions between them


class GridDetector(NamedTuple):
    """Grid to which the positions of a moving end may be rounded."""

    size: float = 1.0  # m, coarsest of GRIDS with all positions; 1 before the first, 0: none
    samples: float = 0.0  # number of samples of an end that moves


class TableDetector(NamedTuple):
    """Breaks of y, which may come from a table that is interpolated linearly."""

    slope: float = 0.0  # m/s, slope of y between the latest two samples
    straight_samples: float = 0.0  # number of samples since the last break of y's line
    broken_at: float = 0.0  # s, instant of that break
    breaks: float = 0.0  # number of breaks after straight pieces as long as the one before
    piece: float = 0.0  # s, time between the latest two


class InputFilter(NamedTuple):
    """State of an end's filter: latest input, filtered motion, misfits so far, and signs of their cause in y."""

    given: Sample = (0.0,) * 13
    given_at: float = 0.0  # s, instant of the latest sample that is no repetition
    # PATH at that instant, with estimates
    motion: tuple[Axis, Axis, Axis, Axis] = ((0.0, 0.0, 0.0),) * 4
    end_accelerations: Four = (0.0,) * 4  # accelerations of the samples at the path's end
    recent_changes: Four = (0.0,) * 4  # largest recent changes of these between two steps
    misfits: Misfits = Misfits()
    repetitions: Repetitions = Repetitions()
    grid: GridDetector = GridDetector()
    table: TableDetector = TableDetector()
    # m (yaw: rad), by which the latest sample is off any expected motion
    position_jumps: Four = (NOT_ESTIMATED,) * 4
    speed_jumps: Four = (NOT_ESTIMATED,) * 4  # m/s (yaw: rad/s), the same of its speed
    # rad/s, mean rates of the leans between the latest two samples
    lean_rates: tuple[float, float] = (0.0, 0.0)

    @staticmethod
    def at_rest(t: float, motion: EndMotion) -> InputFilter:
        """Return the state before anything moves."""
        x, y, z, yaw = ((x0, 0.0, 0.0) for x0 in (*motion.position, motion.yaw))
        table = TableDetector(broken_at=t)
        return InputFilter(tuple(vars(motion).values()), t, (x, y, z, yaw), table=table)


class FilterSettings(NamedTuple):
    """Settings of an end's filter: bandwidths (rad/s) of the observer and of the estimates, trust, and a bound."""

    observer: float
    estimate: float
    position_trust: float  # 1 if it is trusted, else 0
    speed_trust: float
    acceleration_trust: float
    max_deceleration: float  # m/s^2, of a conveyance: beyond it head ropes of a rising one go slack


def filter_settings(scene: Scene, trusted: Scalar) -> FilterSettings:
    """Return the settings as chosen, or as they follow from the required accuracy and from the rope.

    ``trusted`` is the code of inputs.given.
    """
    chosen = scene.inputs
    accuracy = scene.accuracy
    derived = sqrt(accuracy.end_force * scene.layout.gravity / accuracy.loop)
    slowest = ESTIMATE_FRACTION * axial_frequency(scene.rope, scene.rope.length)
    return FilterSettings(
        where(chosen.bandwidth > 0, chosen.bandwidth, derived),
        where(chosen.estimate_bandwidth > 0, chosen.estimate_bandwidth, slowest),
        where(trusted <= POSITION, 1.0, 0.0),
        where(abs(trusted - POSITION) < 0.5, 0.0, 1.0),
        where(trusted <= ALL, 1.0, 0.0),
        scene.layout.gravity,
    )


def settings_of(scene: Scene) -> FilterSettings:
    """Return the settings of the ends' filters in ``scene``."""
    return filter_settings(scene, [*CHOICES["inputs.given"]].index(scene.inputs.given))


def filter_sample(
    state: InputFilter, settings: FilterSettings, given_at: Scalar, h: Scalar, end: EndMotion
) -> InputFilter:
    """Add the host's sample of the instant ``given_at`` to ``state`` for a step ``h``, unless it is a repetition."""
    values = tuple(vars(end).values())
    speeds = (*end.velocity, end.yaw_rate)
    is_later = given_at > state.given_at
    since = where(is_later, given_at - state.given_at, h)
    repeated = _repeated(state, settings, is_later, since, values, speeds)
    motion: list[Any] = []
    # FMI gives no yaw acceleration: take the mean since the sample before
    accelerations = (
        *end.acceleration,
        (end.yaw_rate - state.motion[3][1]) / maximum(since, MIN_MEAN_TIME),
    )
    for old_axis, x, v, a in zip(
        state.motion, (*end.position, end.yaw), speeds, accelerations, strict=True
    ):
        new = _completed(old_axis, settings, since, (x, v, a))
        motion.append(
            tuple(where(repeated, old, value) for old, value in zip(old_axis, new, strict=True))
        )
    fades = exp(-settings.estimate * h)
    recent_changes = tuple(
        maximum(abs(axis[2] - acceleration), fades * before)
        for axis, acceleration, before in zip(
            motion, state.end_accelerations, state.recent_changes, strict=True
        )
    )
    moves = logical_or(*(abs(axis[1]) > RESTS_BELOW for axis in motion))
    grid = _grid_after(state.grid, end.y, moves)
    latest = EndMotion(*state.given)
    slope = (end.y - latest.y) / since
    table = _table_after(state.table, given_at, slope, abs(motion[1][2]) * since)
    repetitions = state.repetitions
    keeps_rates = logical_or(repeated, since < MIN_AIM_TIME)
    means = (
        (end.lean - latest.lean) / since,
        (end.lean_z - latest.lean_z) / since,
    )
    position_jumps, speed_jumps = _jumps(state, settings, since, end)
    result: InputFilter = state._replace(
        given=values,
        position_jumps=tuple(where(repeated, 0.0 * x, x) for x in position_jumps),
        speed_jumps=tuple(where(repeated, 0.0 * x, x) for x in speed_jumps),
        given_at=where(repeated, state.given_at, given_at),
        motion=tuple(motion),
        recent_changes=recent_changes,
        repetitions=Repetitions(
            number=repetitions.number + where(logical_and(repeated, is_later), 1.0, 0.0),
            held=where(repeated, repetitions.held + where(is_later, 1.0, 0.0), 0.0),
            sent_every=where(
                logical_and(repetitions.held > 0, 1 - repeated), since, repetitions.sent_every
            ),
        ),
        grid=GridDetector(*_unless(repeated, state.grid, grid)),
        table=TableDetector(*_unless(repeated, state.table, table)),
        lean_rates=tuple(
            where(keeps_rates, old, mean) for old, mean in zip(state.lean_rates, means, strict=True)
        ),
    )
    return result


def _unless(repeated: Scalar, old: Vector, new: Vector) -> Iterator[Scalar]:
    """Yield the numbers of ``new``, or of ``old`` where the sample is repeated."""
    for x, y in zip(old, new, strict=True):
        yield where(repeated, x, y)


def _jumps(
    state: InputFilter, settings: FilterSettings, since: Scalar, end: EndMotion
) -> tuple[Vector, Vector]:
    """Return by how much a sample's positions and speeds are off any motion that the samples before let expect.

    Estimated inputs follow a wrong sample so smoothly that no misfit is left, and a right one late:
    after a stop with g by MAX_LAG g / W in speed.  So trusted positions and speeds are compared
    with the samples before, and what that lag explains is no jump.  NOT_ESTIMATED where the
    acceleration is given.
    """
    hardest = settings.max_deceleration
    latest = EndMotion(*state.given)
    position_jumps = []
    speed_jumps = []
    for axis, x, x_before, v, v_before in zip(
        state.motion,
        (*end.position, end.yaw),
        (*latest.position, latest.yaw),
        (*end.velocity, end.yaw_rate),
        (*latest.velocity, latest.yaw_rate),
        strict=True,
    ):
        known = settings.speed_trust > 0
        mean = where(known, 0.5 * (v_before + v), axis[1])
        slow = where(known, hardest * since, hardest * (since + MAX_LAG / settings.estimate))
        position_jump = maximum(abs(x - x_before - since * mean) - slow * since, 0.0)
        speed_jump = maximum(abs(v - v_before - since * axis[2]) - 2.0 * hardest * since, 0.0)
        estimated = settings.acceleration_trust < 1
        position_jumps.append(
            where(estimated, where(settings.position_trust > 0, position_jump, 0.0), NOT_ESTIMATED)
        )
        speed_jumps.append(where(estimated, where(known, speed_jump, 0.0), NOT_ESTIMATED))
    return tuple(position_jumps), tuple(speed_jumps)


def _repeated(
    state: InputFilter,
    settings: FilterSettings,
    is_later: Scalar,
    since: Scalar,
    values: Vector,
    speeds: Vector,
) -> Scalar:
    """Return whether the trusted part of a sample repeats the latest one to the bit and cannot be a new one.

    A sample of the same instant is held through an event.  The position of a moving end cannot
    stay.  If positions alone are given, the end must be too fast to have stopped since: after a
    stop with a the estimated speed is off by up to 0.84 a / W.  A speed can be that of the latest
    sample.
    """
    moves = logical_or(*(abs(speed) > RESTS_BELOW for speed in speeds))
    stops_below = settings.max_deceleration * (since + 1.0 / settings.estimate)
    too_fast = logical_or(*(abs(axis[1]) > stops_below for axis in state.motion))
    position = settings.position_trust
    speed = settings.speed_trust
    acceleration = settings.acceleration_trust
    trusted = EndMotion(
        x=position,
        y=position,
        z=position,
        vx=speed,
        vy=speed,
        vz=speed,
        ax=acceleration,
        ay=acceleration,
        az=acceleration,
        yaw=position,
        yaw_rate=speed,
        lean=position,
        lean_z=position,
    )
    same = (
        logical_or(trust < 1, a == b)
        for trust, a, b in zip(vars(trusted).values(), values, state.given, strict=True)
    )
    cannot_stay = logical_and(
        settings.position_trust > 0, where(settings.speed_trust > 0, moves, too_fast)
    )
    # the first sample is of the instant of the start
    return logical_and(where(is_later, cannot_stay, state.misfits.time > 0), *same)


def _completed(
    old: Vector, settings: FilterSettings, h: Scalar, sample: Vector
) -> tuple[Scalar, Scalar, Scalar]:
    """Return position, speed and acceleration ``h`` after ``old``, from the trusted part of a ``sample``."""
    x, v, a = old
    knows_speed = settings.speed_trust > 0
    # fraction of an old error: 1 - alpha = retained^2 or retained^3
    retained = exp(-settings.estimate * h)
    gain = 1.0 - retained
    x_end, v_end = quintic.extrapolate(x, v, a, h)
    speed_gap = sample[1] - v_end
    position_gap = sample[0] - x_end
    speed = v_end + (1.0 - retained * retained) * speed_gap
    acceleration = a + gain * gain / h * speed_gap
    integrated = x + 0.5 * h * (v + speed) + h * h / 12.0 * (a - acceleration)
    position = x_end + (1.0 - retained * retained * retained) * position_gap
    position_speed = v_end + 1.5 * gain * gain * (1.0 + retained) / h * position_gap
    position_acceleration = a + gain * gain * gain / (h * h) * position_gap
    return (
        where(settings.position_trust > 0, where(knows_speed, sample[0], position), integrated),
        where(
            settings.acceleration_trust > 0, sample[1], where(knows_speed, speed, position_speed)
        ),
        where(
            settings.acceleration_trust > 0,
            sample[2],
            where(knows_speed, acceleration, position_acceleration),
        ),
    )


def _grid_after(grid: GridDetector, y: Scalar, moves: Scalar) -> GridDetector:
    """Return the detector after a sample ``y`` (m) of an end, which counts if the end ``moves``."""
    finest: Any = 0.0
    for size in reversed(GRIDS):
        multiple = y / size
        finest = where(abs(multiple - floor(multiple + 0.5)) < ON_GRID, size, finest)
    return GridDetector(
        size=where(moves, minimum(grid.size, finest), grid.size),
        samples=grid.samples + where(moves, 1.0, 0.0),
    )


def _table_after(
    table: TableDetector, given_at: Scalar, slope: Scalar, expected: Scalar
) -> TableDetector:
    """Return the detector after a sample with this ``slope``, where the acceleration explains a change ``expected``."""
    change = abs(slope - table.slope)
    visible = expected > MIN_CHANGE
    breaks = logical_and(visible, change > BROKEN * expected)
    straight = logical_and(visible, change < STRAIGHT * expected)
    counts = logical_and(breaks, table.straight_samples > 0)
    piece = given_at - table.broken_at
    is_table = table.breaks >= MIN_BREAKS
    alike = logical_or(is_table, abs(piece - table.piece) < TABLE_TOLERANCE * piece)
    return TableDetector(
        slope=slope,
        straight_samples=where(straight, table.straight_samples + 1.0, 0.0),
        broken_at=where(breaks, given_at, table.broken_at),
        breaks=where(counts, where(alike, table.breaks + 1.0, 1.0), table.breaks),
        piece=where(logical_and(counts, 1 - is_table), piece, table.piece),
    )


def filter_path(path: EndPath, state: InputFilter, stop: Scalar, bandwidth: Scalar) -> EndPath:
    """Return the path from the end of ``path`` to ``stop`` that follows the inputs; a very short one leads beyond."""
    start = path.stop
    h = maximum(stop - start, MIN_AIM_TIME)
    horizon = stop - state.given_at + (h - (stop - start))
    samples = map(
        _AxisSample,
        JERKS,
        state.motion,
        state.end_accelerations,
        state.recent_changes,
    )
    starts = zip(*path.motion(start), strict=True)
    x, y, z, yaw = (
        _axis_quintic(bandwidth, horizon, h, axis_start, sample)
        for axis_start, sample in zip(starts, samples, strict=True)
    )
    given = EndMotion(*state.given)
    given_leans = (given.lean, given.lean_z)
    latest = zip(path.lean_motion(start), given_leans, state.lean_rates, strict=True)
    lean, lean_z = (_lean_quintic(h, horizon, *axis) for axis in latest)
    return EndPath(start, stop, (x, y, z, yaw), (lean, lean_z))


class _AxisSample(NamedTuple):
    """Latest sample of one coordinate, and what bounds its expected changes."""

    jerk: float  # m/s^3 (yaw: rad/s^3)
    motion: Axis  # position, speed and acceleration
    last_acceleration: Scalar  # m/s^2, of the sample before
    recent_change: Scalar  # m/s^2, largest recent change of the acceleration


def _lean_quintic(
    h: Scalar, horizon: Scalar, start: Vector, sample: Scalar, mean: Scalar
) -> Quintic:
    """Return the quintic of a lean over the step ``h``, ``horizon`` (s) after the sample; a short one leads beyond.

    Its rate, which is not given, lags by a sixth of the step; ``mean`` is that between the latest
    samples.
    """
    x, v, a = start
    aim = maximum(h, MIN_MEAN_TIME)
    target = sample + (horizon + (aim - h)) * mean
    rate = 1.5 * (target - x) / aim - 0.5 * v
    return quintic.coefficients(aim, (x, v, a), (target, rate, (rate - v) / aim))


def _axis_quintic(
    w: Scalar, horizon: Scalar, h: Scalar, start: Vector, sample: _AxisSample
) -> Quintic:
    """Return the quintic of one coordinate over the step ``h``, from ``start`` (x, v, a) to the observer's state."""
    x, v, _ = start
    sample_position, sample_speed, acceleration = sample.motion
    position, speed = quintic.extrapolate(sample_position, sample_speed, acceleration, horizon)
    misfit = sample_misfit(
        h,
        (x, v),
        (sample.last_acceleration, acceleration),
        (position, speed),
        sample.recent_change,
        sample.jerk,
    )
    rest_speed = misfit.speed_misfit - misfit.speed_misfit * misfit.speed_fits
    rest_position = misfit.position_misfit - misfit.position_misfit * misfit.position_fits
    stop = _observed(w, h, (rest_position, rest_speed), (position, speed, acceleration))
    return quintic.coefficients(h, start, stop)


def _observed(
    w: Scalar, h: Scalar, rest: tuple[Scalar, Scalar], sample: tuple[Scalar, Scalar, Scalar]
) -> tuple[Scalar, Scalar, Scalar]:
    """Return the motion after a step ``h`` in which the observer reduces the ``rest`` of a ``sample`` (x, v, a)."""
    rest_position, rest_speed = rest
    position, speed, acceleration = sample
    at_start = rest_position - h * rest_speed
    rate = rest_speed + w * at_start
    fades = exp(-w * h)
    left = (at_start + rate * h) * fades
    left_speed = (rest_speed - w * rate * h) * fades
    return position - left, speed - left_speed, acceleration + w * (2.0 * left_speed + w * left)


class SampleMisfit(NamedTuple):
    """Misfit of a sample against linear acceleration, and the fractions of it that a consistent motion explains."""

    position_misfit: Any
    speed_misfit: Any
    position_fits: Any
    speed_fits: Any


def sample_misfit(
    h: Scalar,
    start: tuple[Scalar, Scalar],
    accelerations: tuple[Scalar, Scalar],
    sample: tuple[Scalar, Scalar],
    recent_change: Scalar,
    jerk: float,
) -> SampleMisfit:
    """Compare position and speed of a ``sample`` with linear acceleration over the step ``h`` from ``start`` on.

    A change of the acceleration within the step explains a part of the misfit; ``jerk`` bounds its
    rate.
    """
    x, v = start
    before, after = accelerations
    position, speed = sample
    change = abs(after - before)
    speed_misfit = speed - v - 0.5 * h * (before + after)
    position_misfit = position - x - h * v - h * h / 6.0 * (2.0 * before + after)
    return SampleMisfit(
        position_misfit,
        speed_misfit,
        _explained_fraction(position_misfit, h * h * (change + 0.125 * recent_change + jerk * h)),
        _explained_fraction(speed_misfit, h * (change + 0.5 * recent_change + jerk * h)),
    )


def _explained_fraction(misfit: Scalar, limit: Scalar) -> Scalar:
    """Return the fraction of a misfit that a consistent motion explains: 1 up to ``limit``, 0 from twice that on.

    It is continuous, since masters that look for events vary the step.
    """
    return minimum(maximum(2.0 - abs(misfit) / limit, 0.0), 1.0)


class PathMeasures(NamedTuple):
    """Measures of an end's path: largest sampled accelerations, by PATH and LEANS; misfits at its end, by PATH.

    Where inputs are estimated, the misfits are the jumps of the sample instead.
    """

    peaks: Annotated[tuple[float, ...], len(PATH) + len(LEANS)]
    position_misfits: Four
    speed_misfits: Four


def end_misfits(path: EndPath, state: InputFilter) -> list[Axis]:
    """Return the misfits of position, speed and acceleration at the path's end, by PATH."""
    misfits = []
    horizon = path.stop - state.given_at
    for (position, speed, acceleration), x, v, a in zip(
        state.motion, *path.motion(path.stop), strict=True
    ):
        x_end, v_end = quintic.extrapolate(position, speed, acceleration, horizon)
        misfits.append((x_end - x, v_end - v, acceleration - a))
    return misfits


def path_measures(path: EndPath, state: InputFilter) -> PathMeasures:
    """Return the measures that decide whether the path can be followed; NaN where a coordinate is."""
    position, speed, _ = (
        tuple(map(abs, sizes)) for sizes in zip(*end_misfits(path, state), strict=True)
    )
    jumps = state.position_jumps, state.speed_jumps
    x, v = (
        tuple(where(jump < 0, size, jump) for size, jump in zip(sizes, of, strict=True))
        for sizes, of in zip((position, speed), jumps, strict=True)
    )
    return PathMeasures(path.peak_accelerations(), x, v)
