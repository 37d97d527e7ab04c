"""One sample of the host in the state of an end's input filter: what it repeats, completes and reveals."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rope_model.boundary import quintic
from rope_model.boundary.end_paths import RESTS_BELOW, EndMotion
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
    FilterSettings,
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
    grid = grid_after(state.grid, end.y, moves)
    latest = EndMotion(*state.given)
    slope = (end.y - latest.y) / since
    table = table_after(state.table, given_at, slope, abs(motion[1][2]) * since)
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
