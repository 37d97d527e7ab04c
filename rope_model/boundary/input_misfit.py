"""Effect of inconsistent input motions on the results: sums for each end, and part of the error estimates.

The misfit's effect on the end force is that of the acceleration c by which the followed motion
exceeds the given one.  It acts on the leg's mass at once, and on the part of it that swings in the
slowest axial wave by that wave's response.  A change of position within a step sends off a wave of
the force sqrt(Qa rho) times its speed.  The part that changes of the given acceleration within a
step explain is no misfit: the path ends with the position and the speed of that motion, and differs
in speed only in between.
"""

import math
from functools import reduce
from typing import Any, NamedTuple

from rope_model.boundary import quintic
from rope_model.boundary.end_paths import EndPath
from rope_model.boundary.input_filter import FilterSettings, InputFilter, Misfits
from rope_model.boundary.input_path import JERKS, end_misfits, sample_misfit
from rope_model.method.step_errors import ErrorSums, wave_duration
from rope_model.parameters import Rope
from rope_model.physics.elementary import (
    SMALLEST_DIVISOR,
    Scalar,
    Vector,
    cos,
    exp,
    maximum,
    minimum,
    sin,
    sqrt,
    where,
)
from rope_model.physics.estimates import axial_frequency

#: fraction of a leg's mass that swings in its slowest axial wave
SWINGING = 8.0 / math.pi**2
#: root mean square speed within a step that moves the end by d in h, over d / h: sqrt(900 / 630) of
#: the quintic
STEP_SPEED = math.sqrt(900.0 / 630.0)
#: largest distance from the middle of a step h, over h, at which an acceleration with one change of
#: rate gains its speed
ONE_CHANGE = 1.0 / 6.0
#: root mean square deviation of the path's speed within a step over the speed gained so: 0.022 of
#: the quintic, and more because its waves last longer (seed 60 of evidence.promise)
WITHIN = 0.055

_Y = 1  #: place of the vertical coordinate in a motion and in a path

#: m/s^2, slowest axial wave of a leg, now and a quarter of a period later
Wave = tuple[float, float]


def add_misfit(
    state: InputFilter, path: EndPath, settings: FilterSettings, rope: Rope, leg: Scalar
) -> InputFilter:
    """Return ``state`` at the end of the ``path``; ``leg`` is the length (m) of the rope from this end to the loop."""
    h = path.stop - path.start
    sums = state.misfits
    misfit = end_misfits(path, state)
    position, speed, acceleration = (
        reduce(maximum, map(abs, sizes)) for sizes in zip(*misfit[:3], strict=True)
    )
    grows = (state.motion[_Y][2] - state.end_accelerations[_Y]) / h
    lag = _lag_after(sums.lag, settings, grows, h)
    explained = _explained_in_step(path, state)
    added = _added_acceleration(path, state, grows, lag, explained)
    wave, leg_force = _leg_response(sums.wave, added, rope, leg, h)
    impedance = sqrt(rope.Qa * rope.mass_per_length)
    shift = _unexplained_shift(path, explained)
    wave_force = STEP_SPEED * impedance * shift / h
    within_force = WITHIN * impedance * explained.speed
    drift = sums.drift + (1.0 - exp(-settings.observer * h)) * (misfit[_Y][0] - sums.drift)
    x, y, z, yaw = state.motion
    result: InputFilter = state._replace(
        end_accelerations=(x[2], y[2], z[2], yaw[2]),
        misfits=Misfits(
            time=sums.time + h,
            position=maximum(sums.position, position),
            speed=maximum(sums.speed, speed),
            acceleration=maximum(sums.acceleration, acceleration),
            squares=(
                sums.squares[0] + h * (position * position),
                sums.squares[1] + h * (speed * speed),
                sums.squares[2] + h * (acceleration * acceleration),
            ),
            wave=wave,
            lag=lag,
            force_error_square=sums.force_error_square
            + h * (leg_force * leg_force + wave_force * wave_force + within_force * within_force),
            drift=drift,
            max_drift=maximum(sums.max_drift, abs(drift)),
        ),
    )
    return result


def _lag_after(lag: Scalar, settings: FilterSettings, grows: Scalar, h: Scalar) -> Scalar:
    """Return the lag (m/s^2) of the estimated acceleration of y after a step in which it ``grows`` (m/s^3)."""
    order = where(settings.acceleration_trust > 0, 0.0, where(settings.speed_trust > 0, 2.0, 3.0))
    steady = order * grows / settings.estimate
    return lag + (1.0 - exp(-settings.estimate * h)) * (steady - lag)


class _Explained(NamedTuple):
    """Part of a sample's misfit of y that one change of the acceleration's rate in the step explains."""

    speed: Scalar  # m/s, gained in the step
    aside: Scalar  # m, gained beside that of a constant acceleration


def _explained_in_step(path: EndPath, state: InputFilter) -> _Explained:
    """Return the part of the latest sample's misfit that the path meets within its step."""
    h = path.stop - path.start
    since = path.stop - state.given_at
    sample = sample_misfit(
        h,
        path.coefficients[_Y][:2],
        (state.end_accelerations[_Y], state.motion[_Y][2]),
        quintic.extrapolate(*state.motion[_Y], since),
        state.recent_changes[_Y],
        JERKS[_Y],
    )
    fits = maximum(1.0 - since / h, 0.0) * sample.position_fits * sample.speed_fits
    speed = sample.speed_misfit * fits
    bound = ONE_CHANGE * h * abs(speed)
    beside = sample.position_misfit * fits - 0.5 * h * speed
    return _Explained(speed, minimum(maximum(beside, -bound), bound))


def _added_acceleration(
    path: EndPath, state: InputFilter, grows: Scalar, lag: Scalar, explained: _Explained
) -> Vector:
    """Return the acceleration of y beyond the given one (m/s^2), and its three rates, at the step's start."""
    h = path.stop - path.start
    gained = 0.5 * h * explained.speed + explained.aside
    *_, b3, b4, b5 = quintic.coefficients(h, (0.0, 0.0, 0.0), (gained, explained.speed, 0.0))
    _, _, c2, c3, c4, c5 = path.coefficients[_Y]
    given = state.motion[_Y][2] + grows * (path.start - state.given_at) + lag
    return (
        2.0 * c2 - given,
        6.0 * (c3 - b3) - grows,
        24.0 * (c4 - b4),
        120.0 * (c5 - b5),
    )


def _unexplained_shift(path: EndPath, explained: _Explained) -> Scalar:
    """Return the shift of y (m) within the step that neither its accelerations nor the sample explain."""
    h = path.stop - path.start
    c0, c1, c2, *_ = path.coefficients[_Y]
    positions, speeds, accelerations = path.motion(path.stop)
    acceleration = accelerations[_Y]
    bent = speeds[_Y] - c1 - 0.5 * h * (2.0 * c2 + acceleration)
    steady = h * h / 6.0 * (4.0 * c2 + acceleration)
    return positions[_Y] - c0 - h * c1 - steady - 0.5 * h * bent - explained.aside


def _leg_response(
    wave: Vector, added: Vector, rope: Rope, leg: Scalar, h: Scalar
) -> tuple[Wave, Scalar]:
    """Return the leg's slowest axial wave (m/s^2) after a step with an additional acceleration, and the end force (N).

    ``added`` are the acceleration and its three rates at the step's start.  The forced wave is this
    cubic minus its second rate over omega^2; the difference from the wave at the start oscillates
    freely.
    """
    omega = axial_frequency(rope, leg)
    duration = wave_duration(rope, omega)
    decay = duration / (duration + h)
    c = cos(omega * h)
    s = sin(omega * h)
    a, b, d, e = added
    x = a - d / omega**2
    x_t = (b - e / omega**2) / omega
    y = a + h * (b + 0.5 * h * (d + h * e / 3.0)) - (d + h * e) / omega**2
    y_t = (b + h * (d + 0.5 * h * e) - e / omega**2) / omega
    free: Any = decay * (c * wave[0] + s * wave[1])
    free_t: Any = decay * (c * wave[1] - s * wave[0])
    total = (free + (y - c * x - s * x_t), free_t + (y_t - c * x_t + s * x))
    mean = a + 0.5 * h * (b + h * (d / 3.0 + h * e / 12.0))
    return total, rope.mass_per_length * leg * (SWINGING * total[0] + (1.0 - SWINGING) * mean)


def add_misfit_error(
    error: Scalar, sums: ErrorSums, left: InputFilter, right: InputFilter
) -> Scalar:
    """Add the error by inconsistent motions to ``error`` of the end forces, root mean square over the largest."""
    squares = maximum(left.misfits.force_error_square, right.misfits.force_error_square) / maximum(
        sums.time, SMALLEST_DIVISOR
    )
    return sqrt(error * error + squares / maximum(sums.force * sums.force, SMALLEST_DIVISOR))


def add_drift_error(error: Scalar, left: InputFilter, right: InputFilter) -> Scalar:
    """Add the drift of the ends to ``error`` (m) of the loop's position."""
    drift = 0.5 * (left.misfits.max_drift + right.misfits.max_drift)
    return sqrt(error * error + drift * drift)
