"""One sample of the host in the state of an end's input filter: what it repeats, completes and reveals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from rope_model.boundary import quintic
from rope_model.boundary.end_paths import PATH, RESTS_BELOW, EndMotion
from rope_model.boundary.input_detectors import (
    GridDetector,
    TableDetector,
    grid_after,
    table_after,
)
from rope_model.boundary.input_filter import (
    MAX_LAG,
    MIN_AIM_TIME,
    MIN_MEAN_TIME,
    NOT_ESTIMATED,
    Axis,
    FilterSettings,
    Four,
    InputFilter,
    Repetitions,
)
from rope_model.physics.elementary import (
    Scalar,
    Vector,
    exp,
    logical_and,
    logical_or,
    maximum,
    where,
)

_Y = PATH.index("y")
_YAW = PATH.index("yaw")


def filter_sample(
    state: InputFilter, settings: FilterSettings, given_at: Scalar, h: Scalar, end: EndMotion
) -> InputFilter:
    """Add the host's sample of the instant ``given_at`` to ``state`` for a step ``h``, unless it is a repetition."""
    is_later = given_at > state.given_at
    since = where(is_later, given_at - state.given_at, h)
    repeated = _repeated(state, settings, is_later, since, end)
    motion = _motion(state, settings, since, end, repeated)
    latest = EndMotion(*state.given)
    grid = grid_after(state.grid, end.y, _moves(motion))
    slope = (end.y - latest.y) / since
    _, _, y_acceleration = motion[_Y]
    table = table_after(state.table, given_at, slope, abs(y_acceleration) * since)
    jumps = _jumps(state, settings, since, end)
    result: InputFilter = state._replace(
        given=tuple(vars(end).values()),
        position_jumps=tuple(where(repeated, 0.0 * x, x) for x in jumps.positions),
        speed_jumps=tuple(where(repeated, 0.0 * x, x) for x in jumps.speeds),
        given_at=where(repeated, state.given_at, given_at),
        motion=motion,
        recent_changes=_recent_changes(state, motion, exp(-settings.estimate * h)),
        repetitions=_repetitions(state.repetitions, repeated, is_later, since),
        grid=GridDetector(*_unless(repeated, state.grid, grid)),
        table=TableDetector(*_unless(repeated, state.table, table)),
        lean_rates=_lean_rates(state, since, end, repeated),
    )
    return result


def _motion(
    state: InputFilter, settings: FilterSettings, since: Scalar, end: EndMotion, repeated: Scalar
) -> tuple[Axis, Axis, Axis, Axis]:
    """Return position, speed and acceleration of each axis, completed from a sample that is no repetition."""
    _, yaw_rate, _ = state.motion[_YAW]
    # FMI gives no yaw acceleration: take the mean since the sample before
    yaw_acceleration = (end.yaw_rate - yaw_rate) / maximum(since, MIN_MEAN_TIME)
    samples = zip(
        (*end.position, end.yaw),
        (*end.velocity, end.yaw_rate),
        (*end.acceleration, yaw_acceleration),
        strict=True,
    )
    motion: list[Any] = []
    for old, sample in zip(state.motion, samples, strict=True):
        new = _completed(old, settings, since, sample)
        motion.append(tuple(_unless(repeated, old, new)))
    x, y, z, yaw = motion
    return x, y, z, yaw


def _moves(motion: Sequence[Axis]) -> Scalar:
    """Return whether an axis moves."""
    return logical_or(*(abs(speed) > RESTS_BELOW for _, speed, _ in motion))


def _recent_changes(state: InputFilter, motion: Sequence[Axis], fades: Scalar) -> Four:
    """Return the largest recent changes of the accelerations, of which earlier ones fade."""
    changes = []
    for axis, before, change in zip(
        motion, state.end_accelerations, state.recent_changes, strict=True
    ):
        _, _, acceleration = axis
        changes.append(maximum(abs(acceleration - before), fades * change))
    x, y, z, yaw = changes
    return x, y, z, yaw


def _repetitions(
    before: Repetitions, repeated: Scalar, is_later: Scalar, since: Scalar
) -> Repetitions:
    """Return the repetitions with the one of this sample."""
    sent_again = logical_and(before.held > 0, 1 - repeated)
    return Repetitions(
        number=before.number + where(logical_and(repeated, is_later), 1.0, 0.0),
        held=where(repeated, before.held + where(is_later, 1.0, 0.0), 0.0),
        sent_every=where(sent_again, since, before.sent_every),
    )


def _lean_rates(
    state: InputFilter, since: Scalar, end: EndMotion, repeated: Scalar
) -> tuple[float, float]:
    """Return the mean rates of the leans since the sample before."""
    latest = EndMotion(*state.given)
    means = (
        (end.lean - latest.lean) / since,
        (end.lean_z - latest.lean_z) / since,
    )
    keeps_rates = logical_or(repeated, since < MIN_AIM_TIME)
    lean, lean_z = _unless(keeps_rates, state.lean_rates, means)
    return lean, lean_z


def _unless(keeps_old: Scalar, old: Vector, new: Vector) -> Iterator[Scalar]:
    """Yield the numbers of ``new``, or of ``old`` where these are kept."""
    for x, y in zip(old, new, strict=True):
        yield where(keeps_old, x, y)


class _Jumps(NamedTuple):
    """Jumps of a sample by axis."""

    positions: Vector  # m (yaw: rad)
    speeds: Vector  # m/s (yaw: rad/s)


def _jumps(state: InputFilter, settings: FilterSettings, since: Scalar, end: EndMotion) -> _Jumps:
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
        _, speed, acceleration = axis
        known = settings.speed_trust > 0
        mean = where(known, 0.5 * (v_before + v), speed)
        slow = where(known, hardest * since, hardest * (since + MAX_LAG / settings.estimate))
        position_jump = maximum(abs(x - x_before - since * mean) - slow * since, 0.0)
        speed_jump = maximum(abs(v - v_before - since * acceleration) - 2.0 * hardest * since, 0.0)
        estimated = settings.acceleration_trust < 1
        position_jumps.append(
            where(estimated, where(settings.position_trust > 0, position_jump, 0.0), NOT_ESTIMATED)
        )
        speed_jumps.append(where(estimated, where(known, speed_jump, 0.0), NOT_ESTIMATED))
    return _Jumps(tuple(position_jumps), tuple(speed_jumps))


def _repeated(
    state: InputFilter,
    settings: FilterSettings,
    is_later: Scalar,
    since: Scalar,
    end: EndMotion,
) -> Scalar:
    """Return whether the trusted part of a sample repeats the latest one to the bit and cannot be a new one.

    A sample of the same instant is held through an event.  The position of a moving end cannot
    stay.  If positions alone are given, the end must be too fast to have stopped since: after a
    stop with a the estimated speed is off by up to 0.84 a / W.  A speed can be that of the latest
    sample.
    """
    moves = logical_or(*(abs(v) > RESTS_BELOW for v in (*end.velocity, end.yaw_rate)))
    stops_below = settings.max_deceleration * (since + 1.0 / settings.estimate)
    too_fast = logical_or(*(abs(v) > stops_below for _, v, _ in state.motion))
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
        for trust, a, b in zip(vars(trusted).values(), vars(end).values(), state.given, strict=True)
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
    sample_x, sample_v, sample_a = sample
    knows_speed = settings.speed_trust > 0
    # fraction of an old error: 1 - alpha = retained^2 or retained^3
    retained = exp(-settings.estimate * h)
    gain = 1.0 - retained
    x_end, v_end = quintic.extrapolate(x, v, a, h)
    speed_gap = sample_v - v_end
    position_gap = sample_x - x_end
    speed = v_end + (1.0 - retained * retained) * speed_gap
    acceleration = a + gain * gain / h * speed_gap
    integrated = x + 0.5 * h * (v + speed) + h * h / 12.0 * (a - acceleration)
    position = x_end + (1.0 - retained * retained * retained) * position_gap
    position_speed = v_end + 1.5 * gain * gain * (1.0 + retained) / h * position_gap
    position_acceleration = a + gain * gain * gain / (h * h) * position_gap
    return (
        where(settings.position_trust > 0, where(knows_speed, sample_x, position), integrated),
        where(settings.acceleration_trust > 0, sample_v, where(knows_speed, speed, position_speed)),
        where(
            settings.acceleration_trust > 0,
            sample_a,
            where(knows_speed, acceleration, position_acceleration),
        ),
    )
