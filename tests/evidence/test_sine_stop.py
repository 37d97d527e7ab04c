"""The promise's stop by half a sine."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from evidence.promise.scenes import TUNE, draw
from evidence.promise.sine_stop import sine_stop


def test_a_sine_stop_ends_at_rest_and_its_rates_fit_its_places() -> None:
    stops = [sine_stop(s.trip) for s in draw(TUNE, 20) if s.by_sine]
    assert len(stops) > 2
    for stop in stops:
        assert_allclose(stop.at(stop.duration - 1e-9).speed, 0.0, atol=1e-7)
        assert stop.at(stop.duration + 1.0) == stop.at(stop.duration + 1e-9)
        dt = 1e-4
        for t in np.linspace(stop.begin + dt, stop.duration - dt, 7):
            before, now, after = (stop.at(t + k * dt) for k in (-1, 0, 1))
            # central differences of smooth functions: dt^2 times their third rates
            assert_allclose((after.position - before.position) / (2 * dt), now.speed, atol=1e-6)
            assert_allclose((after.speed - before.speed) / (2 * dt), now.acceleration, atol=1e-6)
            assert_allclose((after.acceleration - before.acceleration) / (2 * dt), now.jerk, atol=1e-5)
