"""What motions that do not fit do to the results: kept for each end while it follows, and part of the error estimates.

The misfit's effect on the end force is that of the acceleration c which the followed motion has beyond the given one.
It acts on the leg's mass at once, and on the part of it that swings in the slowest axial wave by that wave's response;
a change of place within a step sends off a wave of the force sqrt(Qa rho) times its speed.  What changes of the given
acceleration within a step explain is no misfit: the path has the place and the speed of the motion that they make, and
only in between another speed.
"""

from __future__ import annotations

import math
from typing import Any

from ...numerics import quintic
from ...physics.accuracy import TINY, memory
from ...physics.elementary import cos, exp, larger, sin, smaller, sqrt, where
from ...physics.estimates import axial_frequency
from .following import LEAST_JERK, Following, beyond_linear

#: part of a leg's mass that swings in its slowest axial wave
SWINGING = 8.0 / math.pi**2
#: speed within a step that moves the end by d in h, root mean square over d / h: sqrt(900 / 630) of the quintic
STEP_SPEED = math.sqrt(900.0 / 630.0)
#: an acceleration whose rate changes once in a step of h gains speed, on the whole this part of h from its middle
ONE_CHANGE = 1.0 / 6.0
#: of the speed gained so, by which the path's speed differs from it within the step, root mean square: 0.022 of the
#: quintic, and the waves that this sends off last longer (seed 60 of evidence.promise)
WITHIN = 0.055


def follow_account(now: Any, path: Any, rates: Any, rope: Any, trusted: Any, leg: Any) -> Following:
    """``now`` at the end of the ``path``; ``leg`` is the length (m) of the rope from this end to the loop."""
    h = path.stop - path.start
    places, speeds, accelerations = path.motion(path.stop)
    ahead = path.stop - now.given_at
    found = []
    for axis, x, v, a in zip(now.motion[:3], places, speeds, accelerations, strict=False):
        place, speed = quintic.extrapolate(axis[0], axis[1], axis[2], ahead)
        found.append((abs(place - x), abs(speed - v), abs(a - axis[2])))
    misfits = tuple(larger(larger(x, y), z) for x, y, z in zip(*found, strict=True))
    given_y, given_vy, given_ay = now.motion[1]
    y, speed = quintic.extrapolate(given_y, given_vy, given_ay, ahead)
    c0, c1, c2 = path.coefficients[1][:3]
    beyond = beyond_linear(h, (c0, c1), (now.asked[1], given_ay), (y, speed), now.lively[1], LEAST_JERK)
    # a sample of the step's end whose place and speed fit: the rate of the acceleration changed once within the step
    fits = larger(1.0 - ahead / h, 0.0) * beyond.place_fits * beyond.speed_fits
    faster, most = beyond.faster * fits, ONE_CHANGE * h * abs(beyond.faster * fits)
    aside = smaller(larger(beyond.farther * fits - 0.5 * h * faster, -most), most)
    # of the acceleration, linear through the two given last, in the middle of the step
    given = now.motion[1][2] + (now.motion[1][2] - now.asked[1]) * (ahead / h - 0.5)
    order = where(trusted <= 0, 0.0, where(abs(trusted - 2) < 0.5, 3.0, 2.0))
    lags = order * (now.motion[1][2] - now.asked[1]) / (h * rates.estimate)
    lag = now.lag + (1.0 - exp(-rates.estimate * h)) * (lags - now.lag)
    added = (speeds[1] - c1 - faster) / h - given - lag
    bent = speeds[1] - c1 - 0.5 * h * (2.0 * c2 + accelerations[1]) - faster
    shifted = places[1] - c0 - h * c1 - h * h / 6.0 * (4.0 * c2 + accelerations[1]) - 0.5 * h * (bent + faster) - aside
    wave, of_leg = _swung(now.wave, added, rope, leg, h)
    impedance = sqrt(rope.Qa * rope.mass_per_length)
    of_place, within = STEP_SPEED * impedance * shifted / h, WITHIN * impedance * faster
    drift = now.drift + (1.0 - exp(-rates.observer * h)) * (y - places[1] - now.drift)
    position, speed, acceleration = misfits
    accounted: Following = now._replace(
        asked=tuple(axis[2] for axis in now.motion),
        time=now.time + h,
        position=larger(now.position, position),
        speed=larger(now.speed, speed),
        acceleration=larger(now.acceleration, acceleration),
        squares=tuple(sum_ + h * (size * size) for sum_, size in zip(now.squares, misfits, strict=True)),
        wave=wave,
        lag=lag,
        force=now.force + h * (of_leg * of_leg + of_place * of_place + within * within),
        drift=drift,
        farthest=larger(now.farthest, abs(drift)),
    )
    return accounted


def _swung(wave: Any, added: Any, rope: Any, leg: Any, h: Any) -> tuple[Any, Any]:
    """The leg's slowest axial wave, m/s^2, after a step with the acceleration ``added``, and the end force (N) then."""
    omega = axial_frequency(rope, leg)
    lasts = memory(rope, omega)
    fades = lasts / (lasts + h)
    c, s = fades * cos(omega * h), fades * sin(omega * h)
    off = wave[0] - added
    swung = added + c * off + s * wave[1], c * wave[1] - s * off
    return swung, rope.mass_per_length * leg * (SWINGING * swung[0] + (1.0 - SWINGING) * added)


def with_misfit(error: Any, sums: Any, left: Any, right: Any) -> Any:
    """``error`` of the end forces, root mean square over the largest, with that of motions that do not fit."""
    squares = larger(left.force, right.force) / larger(sums.time, TINY)
    return sqrt(error * error + squares / larger(sums.force * sums.force, TINY))


def with_drift(error: Any, left: Any, right: Any) -> Any:
    """``error`` of the loop's place, m, with that of ends that are not where they are said to be."""
    apart = 0.5 * (left.farthest + right.farthest)
    return sqrt(error * error + apart * apart)
