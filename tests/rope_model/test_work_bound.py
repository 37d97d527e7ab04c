"""The bound on a communication step's work: what it holds and gives up; and when steps become longer again."""

from dataclasses import replace

import numpy as np
import pytest
from bounced_rope import SHORT, SWIVEL, bounce
from numpy.typing import NDArray
from scenes import Ends, Motion, Trip, hung, past_each_other, recorded, wound

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from rope_model import EndMotion, Mesh, Rope, Scene, Solver
from rope_model.engine import NativeRope

pytest.importorskip("rope_model.codegen.build")

#: winds 200 m, its swivels are released at 20 s, and it is stopped after that
STOP = Trip("rope-240", "emergency stop", "draft", 0.01)
READ = (
    "count.newton",
    "status.given_up",
    "status.given_up_since",
    "left.fy",
    "right.fy",
    "loop.yaw",
)
NEWTON = 0
GIVEN_UP = 1
SINCE = 2
FORCES = slice(3, 5)
BOUND = 48
SOON = replace(SWIVEL, release_time=0.1)


def away_from_each_other(t: float) -> Ends:
    """The left end falls and the right one rises, so that the loop moves to the left and the mesh follows it."""
    left, right = past_each_other(t)
    return right, left


def work(values: NDArray[np.float64]) -> float:
    """Newton iterations of the longest communication step."""
    return float(np.diff(values[:, NEWTON], prepend=0.0).max())


def wind(work_max: int) -> NDArray[np.float64]:
    """Outputs (steps, READ) after each communication step."""
    scene = rope_scene(find_case(STOP.scene).rope, STOP.level)
    rope = NativeRope(scene.with_(solver=replace(scene.solver, work_max=work_max)))
    return recorded(rope, STOP.ends, STOP.steps, READ, STOP.H)


@pytest.fixture(scope="module")
def unbounded() -> NDArray[np.float64]:
    return wind(0)


def test_the_bound_holds_through_a_release_and_an_emergency_stop_and_the_status_says_so(
    unbounded,
) -> None:
    bounded = wind(BOUND)
    assert work(unbounded) > BOUND >= work(bounded)
    given_up = bounded[:, GIVEN_UP]
    since = bounded[:, SINCE]
    first = int(np.argmax(given_up > 0))
    assert given_up[first] >= 1
    assert (since[:first] == 0.0).all()
    # the communication step in which it began, not its end
    assert (since[first:] == first * STOP.H).all()
    # an event that is found a step late moves the forces by no more than they move in a step
    forces = unbounded[:, FORCES]
    assert np.abs(bounded[:, FORCES] - forces).max() < np.abs(np.diff(forces, axis=0)).max()


def test_a_bound_that_is_not_reached_changes_no_bit(unbounded: NDArray[np.float64]) -> None:
    far = wind(100 * BOUND)
    assert (far == unbounded).all()
    assert far[-1, GIVEN_UP] == 0.0


@pytest.mark.parametrize(
    ("scene", "motion", "h", "steps", "events"),
    [
        (Scene(rope=Rope(length=60.0), solver=Solver(work_max=24)), bounce, 0.02, 35, False),
        # swivels switch at the ends of steps
        (
            Scene(
                rope=SHORT,
                mesh=Mesh(coarse_length=2.0),  # with a transformation on the way
                left=SOON,
                right=SOON,
                solver=Solver(work_max=12),
            ),
            away_from_each_other,
            0.005,
            109,
            True,
        ),
    ],
)
def test_a_bound_gives_up_steps_and_the_rope_warns_of_it(
    scene: Scene, motion: Motion, h: float, steps: int, events: bool
) -> None:
    rope = wound(NativeRope(scene), motion, steps, h)
    state = rope.state
    assert bool(state.counts.transformations and state.counts.swivel_events) == events
    assert state.counts.given_up > 0
    told = f"given up in {state.counts.given_up} steps since t = {state.given_up_since:.6g} s"
    assert told in rope.warnings()["accuracy_given_up"]


def test_a_bound_below_one_step_does_not_stop_the_rope(unbounded: NDArray[np.float64]) -> None:
    bounded = wind(1)
    assert np.isfinite(bounded).all()
    assert bounded[-1, GIVEN_UP] > 0
    last, right = (values[-100:, FORCES].mean(axis=0) for values in (bounded, unbounded))
    assert last == pytest.approx(right, rel=0.01)


@pytest.mark.parametrize(
    ("step", "host", "expected"),
    [
        (0.005, 0.005, 40),  # a fifth of a second
        (0.00125, 0.00125, 100),  # a hundred steps
        (0.002, 0.001, 200),  # both, of steps that the host cuts
    ],
)
@pytest.mark.parametrize("start", [0.0, 0.1, 12.3])
def test_steps_grow_after_as_many(step: float, host: float, expected: int, start: float) -> None:
    # any mesh does: the number of steps is the claim
    scene = Scene(rope=Rope(length=30.0), mesh=Mesh(kind="eem", elements=10))
    rope = hung(NativeRope(scene.with_(solver=Solver(tolerance=1e6, step_max=step))), t=start)
    rope.retune(scene.with_(solver=replace(rope.scene.solver, step_max=0.02)))
    steps = 0
    while rope.state.step_next == step:
        steps += 1
        assert steps <= 2 * expected
        assert rope.advance_to(start + steps * host, EndMotion(), EndMotion()).valid
    assert steps == expected
