"""The coupling schemes: orders, the monolithic solution, rollback, energy, warnings, failures."""

import json
import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drives import Plant, PlantInput, PlantInputPath
from numpy.testing import assert_allclose, assert_array_equal
from rope_groups import rope_in_process
from two_masses import Data, error, start

from hoist_demo.cases.case import NAMED
from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_data
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.cosimulation.schemes.catalogue import SCHEMES
from hoist_demo.cosimulation.schemes.energy import EnergyControlled
from hoist_demo.cosimulation.schemes.explicit import (
    GaussSeidel,
    ImpulsePreserving,
    SemiImplicit,
    extrapolation_coefficients,
)
from hoist_demo.cosimulation.schemes.interface import Reader, Sample, Scheme
from hoist_demo.cosimulation.schemes.iterative import Iterative
from hoist_demo.cosimulation.schemes.stability import MARGIN, growth
from hoist_demo.parameters import Coupling, Hoist, Winding
from rope_model import ROPE_CASES, EndMotion, Solver, Status

EVEN = Solver(tolerance=1e6)  # steps that no error shortens
#: order in the communication step for smooth motion, by the end of a scheme's name
THEORY = {"0": 1, "1": 2, "2": 3, "preserving": 1, "impulse": 1, "controlled": 2}
THEORY |= dict.fromkeys(("jacobian", "aitken", "secant"), 4)
TRIP = Winding(travel=0.002, settle=0.15, start_delay=0.0)


def tight(name: str) -> Scheme:
    """The scheme, with a tolerance that does not show."""
    scheme = SCHEMES[name]
    return replace(scheme, tolerance=1e-9) if isinstance(scheme, Iterative) else scheme


@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_has_the_order_of_its_theory(name: str) -> None:
    errors = [error(tight(name), H) for H in (0.01, 0.005)]
    assert_allclose(math.log2(errors[0] / errors[1]), THEORY[name.rpartition("-")[2]], atol=0.12)
    if name.startswith("iterative"):  # the monolithic solution
        assert errors[1] < 1e-7


@pytest.mark.parametrize("accelerator", ["jacobian", "secant"])
def test_iteration_and_semi_implicit_exchange_hold_where_the_end_is_heavier_than_the_drive(accelerator: Any) -> None:
    heavy = Data(m_e=20.0)
    errors = [error(Iterative(accelerator, 1e-9, held=True), H, heavy) for H in (0.01, 0.005)]
    assert errors[1] < 0.6 * errors[0] < 0.05
    assert error(SemiImplicit(1), 0.01, heavy) < 0.05
    assert not error(GaussSeidel(0), 0.01, heavy) < 1.0


@pytest.mark.parametrize(
    ("scheme", "data", "H", "words"),
    [
        (Iterative("aitken", 1e-30), Data(m_e=20.0), 0.01, "tolerance 1e-30 N"),
        (EnergyControlled(ImpulsePreserving(), 1e-9, smallest=1e-3), Data(), 0.04, "bound 1e-09 W"),
    ],
)
def test_a_scheme_that_cannot_keep_what_is_asked_says_so(scheme: Scheme, data: Data, H: float, words: str) -> None:
    assert words in scheme.advance(*start(data, 0.5, H), 0.5, H).cause


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_extrapolation_reproduces_polynomials_of_its_order_on_uneven_samples(degree: int) -> None:
    def f(t: float) -> np.ndarray:
        return np.array([1.0 + 2.0 * (degree > 0) * t - 3.0 * (degree > 1) * t * t])

    samples = [Sample(t, f(t), f(t), f(t)) for t in (-0.5, -0.2, 0.1)]
    c0, c1, c2 = extrapolation_coefficients(samples, "force", degree, 0.3)
    for s in (0.0, 0.4, 1.0):
        assert_allclose(c0 + s * (c1 + s * c2), f(0.1 + 0.3 * s), rtol=1e-12)


@pytest.mark.parametrize(("inner", "bound"), [(ImpulsePreserving(), 1.0), (GaussSeidel(1), 0.05)])
def test_energy_control_keeps_the_residual_below_its_bound(inner: Scheme, bound: float) -> None:
    H = 0.04
    (free, free_memory), (pair, memory) = start(Data(), 0.5, H), start(Data(), 0.5, H)
    scheme, worst, uncontrolled = EnergyControlled(inner, bound), 0.0, 0.0
    for k in range(25):
        advance = scheme.advance(pair, memory, 0.5 + k * H, H)
        assert not advance.cause
        worst = max(worst, abs(advance.memory.residual - memory.residual) / H)
        memory = advance.memory
        after = inner.advance(free, free_memory, 0.5 + k * H, H).memory
        uncontrolled = max(uncontrolled, abs(after.residual - free_memory.residual) / H)
        free_memory = after
    assert worst <= bound < uncontrolled
    assert memory.exchanges > 25


# a mere mass; and F = -Z v with speeds that decay by 0.9 per step: the root is 0.9 - Z H / M
@pytest.mark.parametrize(
    ("degree", "impedance", "limit"),
    [
        *((k, np.eye(21)[0], limit) for k, limit in enumerate((1.0, 1 / 2, 3 / 11))),
        (0, 1.9 * 0.9 ** np.arange(400), 1.0),
    ],
)
def test_the_growth_is_one_at_the_limit_of_theory(degree: int, impedance: np.ndarray, limit: float) -> None:
    assert_allclose(growth(GaussSeidel(degree), impedance, 1.0 / limit), 1.0, rtol=1e-9)


def test_the_drive_integrates_a_changing_load_as_many_short_held_ones() -> None:
    plant = Plant(Hoist())
    state = plant.equilibrium(0.0, 90.0, -1200.0, -8200.0)
    held, rise, bend = (float(state.x[0]) + 1e4, -1200.0, -8200.0), (0.0, -500.0, 300.0), (0.0, 200.0, 100.0)
    path = PlantInputPath(*(PlantInput(*values) for values in (held, rise, bend)), (400.0, 300.0))
    whole, off = plant.step(state, 0.04, path).state, []
    for n in (100, 200):
        parts = state
        for i in range(n):
            # the force of each part is that for the acceleration at its start: of first order
            parts = plant.step(parts, 0.04 / n, plant.loads_at(parts, path, (i + 0.5) / n)).state
        off.append(parts.x - whole.x)
    assert_allclose(off[1][4:], 0.5 * off[0][4:], rtol=0.1)
    assert_allclose(off[1][4:], 0.0, atol=2e-6)


def rope(level: Any = "draft") -> InProcessRope:
    return InProcessRope(ROPE_CASES["rope-120"](level).scene)


def wind(scheme: str, plant: Any = None, **options: Any) -> Result:
    host = Host(plant or rope(), Hoist(), TRIP, Coupling(scheme=scheme))
    return host.run(**options)


@pytest.mark.parametrize("name", ["gauss-seidel-2", "semi-implicit-1", "iterative-jacobian", "energy-controlled"])
def test_the_trial_before_the_start_leaves_nothing_behind(name: str) -> None:
    result = wind(name)
    assert result.completed, result.cause
    assert result.recording["count.steps"][0] == 0
    assert result.recording["time"][-1] == pytest.approx(result.steps * 0.01)


def test_schemes_agree_with_the_iterated_exchange_on_the_hoist() -> None:
    exact = wind("iterative-secant").recording
    for name in ("jacobi-1", "gauss-seidel-1", "semi-implicit-1"):
        # 2e-4 of 8 kN, ten times what the committed data show for this step
        assert_allclose(wind(name).recording["right.fy"], exact["right.fy"], rtol=2e-3)


def test_a_choice_that_will_be_unstable_is_warned_of_with_the_number(caplog: pytest.LogCaptureFixture) -> None:
    light = Hoist(conveyance_mass=300.0, payload_left=0.0)
    host = Host(rope(), light, TRIP, Coupling(step=0.02, scheme="gauss-seidel-2"))
    with caplog.at_level(logging.WARNING):
        result = host.run(lambda fraction, t: False)
    assert host.stability is not None
    assert host.stability.growth > 1.1
    assert f"grow {host.stability.growth:.3g} times per step" in result.warning
    assert result.warning in caplog.text


@pytest.mark.parametrize("case", NAMED)
@pytest.mark.parametrize("H", [0.005, 0.01, 0.02])
def test_the_default_is_expected_to_be_stable_on_every_case(case: str, H: float) -> None:
    scene, plant = find_case(case), rope_in_process(case, level="draft")
    host = Host(plant, scene.hoist, scene.winding, Coupling(step=H), scene.gains)
    result = host.run(lambda fraction, t: False)
    assert result.warning == ""
    assert host.stability is not None
    assert host.stability.growth < MARGIN


@dataclass
class Faulty:
    """A rope that fails once, at a given step, in one of three ways."""

    inner: InProcessRope
    way: str
    at: float

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        if self.way == "rejects" and t >= self.at:
            return Status(False, "this step is refused")
        status = self.inner.step(t, h, left, right)
        if self.way == "raises" and t >= self.at:
            raise RuntimeError("the rope is gone")
        return status

    def reader(self, names: Sequence[str]) -> Reader:
        read = self.inner.reader(names)

        def values() -> np.ndarray:
            late = self.way == "nan" and self.inner.save().state.motion.t > self.at
            return np.full(len(names), math.nan) if late else read()

        return values

    def __getattr__(self, name: str) -> Any:
        return getattr(self.inner, name)


@pytest.mark.parametrize("way", ["rejects", "nan", "raises"])
def test_a_failure_saves_the_last_good_state_and_the_run_resumes_to_the_same_bits(way, tmp_path, monkeypatch):
    monkeypatch.setattr("hoist_demo.cosimulation.host.KEPT_EVERY", 0.03)
    whole = wind("gauss-seidel-1")
    # the trial before the start takes 0.48 s of the rope's time
    faulty = Faulty(rope(), way, 0.555)
    stopped = wind("gauss-seidel-1", faulty, save_to=tmp_path / "last_good.npz")
    assert not stopped.completed
    assert "t = 0.56 s" in stopped.cause or "t = 0.55 s" in stopped.cause
    assert stopped.saved == tmp_path / "last_good.npz"
    kept = Checkpoint.read(stopped.saved)
    assert stopped.recording.time[-1] - 0.03 < kept.t <= stopped.recording.time[-1]
    assert kept.cause == stopped.cause
    resumed = wind("gauss-seidel-1", resume=kept)
    assert resumed.completed
    assert resumed.steps == whole.steps
    for name, values in whole.recording.signals.items():
        assert_array_equal(resumed.recording[name], values, name)


def test_a_run_may_resume_with_another_scheme_but_not_as_another_trip(tmp_path: Path) -> None:
    stopped = wind("impulse-preserving", progress=lambda fraction, t: t < 0.1)
    assert stopped.checkpoint is not None
    assert wind("iterative-secant", resume=stopped.checkpoint).completed
    with pytest.raises(ValueError, match="must be of the same hoist"):
        Host(rope(), Hoist(), replace(TRIP, travel=0.003)).run(resume=stopped.checkpoint)


def test_a_file_that_is_no_checkpoint_is_named(tmp_path: Path) -> None:
    (tmp_path / "x.npz").write_text(json.dumps({}))
    with pytest.raises(ValueError, match=r"x\.npz' must be a checkpoint"):
        Checkpoint.read(tmp_path / "x.npz")


@pytest.mark.parametrize(("solver", "warned"), [(Solver(step_max=0.0025), True), (Solver(), True), (EVEN, False)])
def test_at_40_ms_the_host_warns_where_the_rope_s_own_steps_do_not_damp_the_waves(solver: Solver, warned: bool) -> None:
    scene = find_case("rope-120")
    rope = InProcessRope(rope_data(scene.rope).with_(solver=solver))
    host = Host(rope, scene.hoist, TRIP, Coupling(step=0.04, scheme="jacobi-2"))
    result = host.run(lambda fraction, t: False)
    assert bool(result.warning) == warned
