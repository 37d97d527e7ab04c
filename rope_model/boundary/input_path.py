"""Path of an end through one step, which the observer leads to the host's motion, and its measures."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from rope_model.boundary import quintic
from rope_model.boundary.end_paths import LEANS, PATH, EndMotion, EndPath
from rope_model.boundary.input_filter import (
    MIN_AIM_TIME,
    MIN_MEAN_TIME,
    Axis,
    Four,
    InputFilter,
)
from rope_model.boundary.quintic import Quintic
from rope_model.physics.elementary import Scalar, Vector, exp, maximum, minimum, where

#: m/s^3, jerk that a consistent motion may have at any instant.  To follow it within a step h the
#: path needs an additional acceleration of at most 5.8 h times the jerk: 0.1 % of g where h = 20 ms
ALLOWED_JERK = 0.1
#: rad/s^3, the same for a yaw, which only twists the rope; FMI gives no yaw acceleration.  3
#: degrees at 2 Hz have it
ALLOWED_YAW_JERK = 100.0
JERKS = (*(ALLOWED_JERK,) * 3, ALLOWED_YAW_JERK)


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
