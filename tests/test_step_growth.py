"""When a rope makes its steps longer again: where nothing errs, after so many steps, whatever the clock shows."""

from dataclasses import replace

import pytest

from rope_model.engine import NativeRope
from rope_model.numerics.kernels import find_compiler
from rope_model.parameters import Mesh, Rope, Scene, Solver
from rope_model.simulation.balance_rope import BalanceRope
from rope_model.simulation.ends.paths import EndMotion
from rope_model.simulation.simulator import RopeSimulator

FORMS = (RopeSimulator, pytest.param(NativeRope, marks=pytest.mark.skipif(not find_compiler(), reason="no compiler")))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    ("step", "host", "expected"),
    [
        (0.005, 0.005, 40),  # a fifth of a second
        (0.00125, 0.00125, 100),  # a hundred steps
        (0.002, 0.001, 200),  # both, of steps that the host cuts
    ],
)
@pytest.mark.parametrize("start", [0.0, 0.1, 12.3])
def test_steps_grow_after_as_many_whatever_the_clock_shows(
    form: type[BalanceRope], step: float, host: float, expected: int, start: float
) -> None:
    scene = Scene(rope=Rope(length=30.0), mesh=Mesh(kind="eem", elements=10))
    rope, still = form(scene.with_(solver=Solver(tolerance=1e6, step_max=step))), (EndMotion(), EndMotion())
    assert rope.initialize(start, *still).valid
    rope.retune(scene.with_(solver=replace(rope.scene.solver, step_max=0.02)))
    steps = 0
    while rope.state.step_next == step:
        steps += 1
        assert steps <= 2 * expected
        assert rope.advance_to(start + steps * host, *still).valid
    assert steps == expected
