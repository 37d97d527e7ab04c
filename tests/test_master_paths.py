"""The rope's ends on a master's steps: what their path misses of the motion that the host meant."""

import numpy as np
from end_paths import Follower
from masters import JERK, MISSED, random_steps
from numpy.testing import assert_allclose

from rope_model.simulation.ends.paths import EndMotion


def largest_miss(steps: list[float], jerk: float, rest: float = 0.0) -> np.ndarray:
    """Largest error in y, vy, ay behind constant jerk that is extrapolated from each start, after a ``rest`` (s)."""
    end, t, largest = Follower(), 0.0, np.zeros(3)
    if rest:
        end.step(rest, EndMotion())
    for h in steps:
        given = EndMotion(y=jerk * t**3 / 6, vy=jerk * t**2 / 2, ay=jerk * t)
        path = end.step(rest + t + h, given, rest + t).path
        s = t + h * np.linspace(0, 1, 21)
        truth = np.array([jerk * s**3 / 6, jerk * s**2 / 2, jerk * s])
        along = np.array([motion[1] for motion in path.motion(rest + s)])
        largest = np.maximum(largest, np.abs(along - truth).max(axis=1))
        t += h
    return largest


def test_path_misses_no_more_in_any_steps_than_stated_and_hardly_more_than_in_even_ones() -> None:
    even = largest_miss([1.0] * 40, 1.0)
    assert_allclose(even, [0.2575, 0.509, 2.94], rtol=2e-3)
    worst = np.zeros(3)
    for seed in range(200):
        worst = np.maximum(worst, largest_miss([h for _, h in random_steps(seed, 20.0, 1e-6, 1.0)], 1.0))
    for short in (1e-6, 0.1, 0.5, 0.9):
        worst = np.maximum(worst, largest_miss([1.0, *[short] * 3] * 10, 1.0))
    assert np.all(worst <= MISSED)
    # made good within the step, the last of these would take the path 1e6 times as far off
    assert np.all(largest_miss([1.0] * 5 + [1e-6] * 5, 1.0) <= MISSED)


def test_path_misses_as_much_after_a_long_step_of_rest_as_without() -> None:
    for rest in (1.0, 60.0):
        assert_allclose(largest_miss([0.01] * 100, JERK, rest), largest_miss([0.01] * 100, JERK), rtol=1e-7)
