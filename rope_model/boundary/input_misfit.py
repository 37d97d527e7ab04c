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
from typing import Any

from rope_model.boundary import quintic
from rope_model.boundary.end_paths import EndPath
from rope_model.boundary.input_filter import (
    JERKS,
    FilterSettings,
    InputFilter,
    Misfits,
    end_misfits,
    sample_misfit,
)
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

#: m/s^2, slowest axial wave of a leg, now and a quarter of a period later
Wave = tuple[float, float]


def add_misfit(
    state: InputFilter, path: EndPath, settings: FilterSettings, rope: Rope, leg: Scalar
) -> InputFilter:
    """Return ``state`` at the end of the ``path``; ``leg`` is the length (m) of the rope from this end to the loop."""
    h = path.stop - path.start
    (_, position, _, _), (_, speed, _, _), (_, acceleration, _, _) = path.motion(path.stop)
    misfit = end_misfits(path, state)
    misfits = [reduce(maximum, map(abs, sizes)) for sizes in zip(*misfit[:3], strict=True)]
    c0, c1, c2, c3, c4, c5 = path.coefficients[1]
    # growth and lag of the acceleration, which is linear through the latest two samples
    grows = (state.motion[1][2] - state.end_accelerations[1]) / h
    order = where(settings.acceleration_trust > 0, 0.0, where(settings.speed_trust > 0, 2.0, 3.0))
    sums = state.misfits
    lag = sums.lag + (1.0 - exp(-settings.estimate * h)) * (
        order * grows / settings.estimate - sums.lag
    )
    # part of the sample's misfit that one change of the acceleration's rate within the step
    # explains
    axes = zip(
        path.coefficients,
        state.end_accelerations,
        state.motion,
        state.recent_changes,
        JERKS,
        strict=True,
    )
    samples = [
        sample_misfit(
            h,
            c[:2],
            (before, a),
            quintic.extrapolate(x, v, a, path.stop - state.given_at),
            change,
            jerk,
        )
        for c, before, (x, v, a), change, jerk in axes
    ]
    sample = samples[1]
    fits = (
        maximum(1.0 - (path.stop - state.given_at) / h, 0.0)
        * sample.position_fits
        * sample.speed_fits
    )
    speed_misfit = sample.speed_misfit * fits
    bound = ONE_CHANGE * h * abs(sample.speed_misfit * fits)
    aside = minimum(maximum(sample.position_misfit * fits - 0.5 * h * speed_misfit, -bound), bound)
    *_, b3, b4, b5 = quintic.coefficients(
        h, (0.0, 0.0, 0.0), (0.5 * h * speed_misfit + aside, speed_misfit, 0.0)
    )
    # additional acceleration and its rates at the step's start
    begin = state.motion[1][2] + grows * (path.start - state.given_at) + lag
    added = 2.0 * c2 - begin, 6.0 * (c3 - b3) - grows, 24.0 * (c4 - b4), 120.0 * (c5 - b5)
    bent = speed - c1 - 0.5 * h * (2.0 * c2 + acceleration)
    shifted = (
        position - c0 - h * c1 - h * h / 6.0 * (4.0 * c2 + acceleration) - 0.5 * h * bent - aside
    )
    wave, leg_force = _leg_response(sums.wave, added, rope, leg, h)
    impedance = sqrt(rope.Qa * rope.mass_per_length)
    wave_force = STEP_SPEED * impedance * shifted / h
    within_force = WITHIN * impedance * speed_misfit
    drift = sums.drift + (1.0 - exp(-settings.observer * h)) * (misfit[1][0] - sums.drift)
    x, y, z, yaw = state.motion
    result: InputFilter = state._replace(
        end_accelerations=(x[2], y[2], z[2], yaw[2]),
        misfits=Misfits(
            time=sums.time + h,
            position=maximum(sums.position, misfits[0]),
            speed=maximum(sums.speed, misfits[1]),
            acceleration=maximum(sums.acceleration, misfits[2]),
            squares=(
                sums.squares[0] + h * (misfits[0] * misfits[0]),
                sums.squares[1] + h * (misfits[1] * misfits[1]),
                sums.squares[2] + h * (misfits[2] * misfits[2]),
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
