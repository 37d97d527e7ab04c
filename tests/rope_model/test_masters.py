"""Steps as masters take them: rests of rounding size, short steps after long ones, steps taken back.

What the path of an end misses of a motion with a jerk, docs/reference/variables.md states; extrapolation is exact at
constant acceleration.
"""

import itertools
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from end_paths import Follower
from exports import NATIVE
from masters import DURATION, JERK, LOOPS, MISSED, TRAVEL, Steps, random_steps
from native_host import Host
from numpy.testing import assert_allclose
from scenes import smooth_trip

from rope_model.boundary.end_paths import EndMotion
from rope_model.cases import rope_120

MASS_PER_LENGTH = rope_120().scene.rope.mass_per_length
FORCES = ("left.fy", "right.fy")


def trip(t: float) -> tuple[EndMotion, EndMotion]:
    return smooth_trip(t, TRAVEL, DURATION, TRAVEL)


@pytest.fixture(params=[*NATIVE, "drive-2"])
def host(
    request: pytest.FixtureRequest, unpacked: Callable[[str], tuple[Path, str]]
) -> Iterator[Host]:
    made = Host(*unpacked(request.param))
    yield made
    made.free()


rope_only = pytest.mark.parametrize("host", NATIVE, indirect=True)


def give(host: Host, t: float) -> None:
    for side, motion in zip(("left", "right"), trip(t), strict=True):
        host.set(**{f"{side}.{name}": getattr(motion, name) for name in ("y", "vy", "ay")})


def is_rope(host: Host) -> bool:
    return "rope.EI" in host.variables


def run(host: Host, steps: Steps, T: float) -> None:
    """All steps are done, and they end at T."""
    t = h = 0.0
    for t, h in steps:
        if is_rope(host):
            give(host, t)
        message = host.step(t, h)
        assert message == "", f"t = {t!r}, h = {h!r}: {message}"
    assert abs(t + h - T) < 1e-9


def start_rigid(host: Host) -> None:
    """Start the host; a rope is rigid where its clock is the claim, and not its motion."""
    if is_rope(host):
        host.start(**{"model.fidelity": 4})
    else:
        host.start()


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize(
    ("H", "T"), [(0.02, 5.0), (0.005, 2.0), pytest.param(0.02, 9.0, marks=pytest.mark.slow)]
)
def test_loop_of_a_master_ends_where_it_should(host: Host, loop: str, H: float, T: float) -> None:
    start_rigid(host)
    run(host, LOOPS[loop](H, T), T)


def test_rest_of_rounding_size_moves_nothing_and_is_not_lost(host: Host) -> None:
    """In the middle of a trip, 1000 rests that are 5e-7 s together: the conveyances do 2.5 um in it."""
    t0 = 8.0
    H = 0.02
    rest = 5e-10
    rests = 1000
    start_rigid(host)
    run(host, LOOPS["counting"](H, t0), t0)
    state = host.state()
    # the motion is extrapolated, and the torque sampled, so much later
    later = JERK * rests * rest
    leg = 0.5 * (rope_120().scene.rope.length + TRAVEL)
    if is_rope(host):
        shown = FORCES
        allowed = later * MASS_PER_LENGTH * leg
    else:
        shown = ("left.y",)
        allowed = 10 * later * H**2 / 2

    def after(steps: Steps) -> list[float]:
        host.restore(state)
        run(host, steps, t0 + H)
        return host.get(*shown)

    rounding = itertools.chain(
        ((t0 + k * rest, rest) for k in range(rests)), [(t0 + rests * rest, H - rests * rest)]
    )
    assert_allclose(after(rounding), after(iter([(t0, H)])), rtol=0, atol=allowed)
    host.restore(state)
    before = host.get(*shown)
    assert host.step(t0, rest) == ""
    assert host.get(*shown) == before
    # the time that was handed over is saved and restored
    again = host.state()
    run(host, iter([(t0 + rest, H)]), t0 + rest + H)
    once = host.get(*shown)
    host.restore(again)
    run(host, iter([(t0 + rest, H)]), t0 + rest + H)
    assert host.get(*shown) == once


@rope_only
def test_restored_outputs_are_those_before_a_tunable_was_changed(host: Host) -> None:
    """The friction of a swivel that slips; also where the change was entered before the state was saved, and waits."""
    host.start(inputs_at_step_end=True, **{"left.swivel.mode": 2, "right.swivel.mode": 2})
    H = 0.01
    friction = "right.swivel.mu_kinetic"

    def turn(k: int) -> list[float]:
        t = (k + 1) * H
        host.set(**{"right.yaw": t * t, "right.yaw_rate": 2 * t})
        assert host.step(k * H, H) == ""
        return shown()

    def shown() -> list[float]:
        return host.get("right.my", "right.swivel.torque", "right.swivel.rate", "left.fy")

    for k in range(60):
        turn(k)
    assert host.get("right.swivel.slipping") == [True]
    (mu,) = host.get(friction)
    for waits in (mu, 0.5 * mu):
        host.set(**{friction: waits})
        state = host.state()
        before = shown()
        after = turn(60)
        host.set(**{friction: 0.25 * mu})
        assert turn(61)[0] != pytest.approx(before[0], rel=0.1)
        host.restore(state)
        assert shown() == before
        assert host.get(friction) == [waits]
        assert turn(60) == after
        host.restore(state)


@rope_only
def test_trials_of_a_position_alone_are_taken_back_without_a_trace(host: Host) -> None:
    H = 0.01
    trials = [9e-3, -9e-3, *(9e-3 * 0.5**k for k in range(1, 6))]
    shown = (*FORCES, "inputs.repeated", "inputs.misfit.position")

    def wind(trials: list[float]) -> list[list[float]]:
        host.start(**{"mesh.kind": 1, "mesh.elements": 16})
        rows = []
        for t, h in LOOPS["counting"](H, 10 * H):
            give(host, t)
            (y,) = host.get("left.y")
            before = host.state()
            for trial in trials:
                host.set(**{"left.y": y + trial})
                assert host.step(t, h) == ""
                host.restore(before)
            host.forget(before)
            give(host, t)
            assert host.step(t, h) == ""
            rows.append(host.get(*shown))
        host.call("Reset")
        return rows

    assert wind(trials) == wind([])


def largest_miss(steps: list[float], jerk: float, rest: float = 0.0) -> np.ndarray:
    """Largest error in y, vy, ay behind constant jerk that is extrapolated from each start, after a ``rest`` (s)."""
    end = Follower()
    t = 0.0
    largest = np.zeros(3)
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


@pytest.mark.parametrize("seeds", [15, pytest.param(60, marks=pytest.mark.slow)])
def test_path_misses_no_more_in_any_steps_than_stated_and_hardly_more_than_in_even_ones(
    seeds: int,
) -> None:
    assert_allclose(largest_miss([1.0] * 40, 1.0), [0.2575, 0.509, 2.94], rtol=2e-3)
    worst = np.zeros(3)
    for seed in range(seeds):
        worst = np.maximum(
            worst, largest_miss([h for _, h in random_steps(seed, 20.0, 1e-6, 1.0)], 1.0)
        )
    for short in (1e-6, 0.1, 0.5, 0.9):
        worst = np.maximum(worst, largest_miss([1.0, *[short] * 3] * 10, 1.0))
    assert np.all(worst <= MISSED)
    # made good within the step, the last of these would take the path 1e6 times as far off
    assert np.all(largest_miss([1.0] * 5 + [1e-6] * 5, 1.0) <= MISSED)


def test_path_misses_as_much_after_a_long_step_of_rest_as_without() -> None:
    for rest in (1.0, 60.0):
        assert_allclose(
            largest_miss([0.01] * 100, JERK, rest), largest_miss([0.01] * 100, JERK), rtol=1e-7
        )
