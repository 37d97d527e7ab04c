"""The coupling schemes: orders, the monolithic solution, rollback, energy, warnings, failures."""

import json
import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from rope_groups import rope_in_process
from scipy.linalg import expm

from hoist_demo.cases.case import BUILTIN_HOISTS
from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.compiled_trip import CompiledTrip
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_scene
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.cosimulation.schemes import explicit
from hoist_demo.cosimulation.schemes.catalogue import SCHEMES
from hoist_demo.cosimulation.schemes.energy import EnergyControlled
from hoist_demo.cosimulation.schemes.explicit import GaussSeidel, ImpulsePreserving, SemiImplicit
from hoist_demo.cosimulation.schemes.interface import (
    ROPE_FORCES,
    CoupledSystem,
    DriveLoad,
    InterfaceMotion,
    ParticipantFailed,
    Reader,
    Sample,
    Scheme,
    SchemeState,
)
from hoist_demo.cosimulation.schemes.iterative import Iterative
from hoist_demo.cosimulation.schemes.stability import MARGIN, growth_per_step
from hoist_demo.parameters import Coupling, Hoist, Winding
from rope_model import EndMotion, Solver, Status

# two masses split in two: the smallest co-simulation with an exact solution, on which schemes show their order
#
#     drive      m y'' + k y = f + F
#     follower   m_2 x'' = k_2 (y - x) + c_2 (y' - x') ,     F = -m_e y'' - k_2 (y - x) - c_2 (y' - x')
#
# Both halves are solved exactly within a step, by the matrix exponential, so that only the exchange errs.

NOTHING = EndMotion()


@cache
def _exponential(entries: bytes, n: int) -> np.ndarray:
    return np.asarray(expm(np.frombuffer(entries).reshape(n, n)))


def exponential(A: np.ndarray) -> np.ndarray:
    """exp(A), computed once for the steps of a length and the instants of all schemes."""
    return _exponential(A.tobytes(), len(A))


def both(left: float) -> np.ndarray:
    """Return the value of the left end, and 0 at the right one."""
    return np.array([left, 0.0])


class Exact(NamedTuple):
    """Place and speed of the drive's mass (y, v) and of the rope's (x, w), m and m/s."""

    y: float
    v: float
    x: float
    w: float


@dataclass(frozen=True)
class Data:
    """Masses (kg), springs (N/m) and damper (N s/m); periods of about 1 and 0.4 s."""

    m: float = 10.0
    k: float = 400.0
    f: float = 40.0  # N
    m_e: float = 1.0  # moves with the drive
    m_2: float = 2.0
    k_2: float = 500.0
    c_2: float = 1.0

    def exact(self, t: float) -> Exact:
        """The exact solution at t from rest at zero."""
        M = self.m + self.m_e
        k = self.k_2
        c = self.c_2
        A = np.zeros((5, 5))
        A[0, 1] = A[2, 3] = 1.0
        A[1] = np.array([-(self.k + k), -c, k, c, self.f]) / M
        A[3, :4] = np.array([k, c, -k, -c]) / self.m_2
        *motion, _ = exponential(A * t) @ np.array([0.0, 0.0, 0.0, 0.0, 1.0])
        return Exact(*motion)

    def forces(self, t: float) -> tuple[float, float]:
        """F and y'' of the exact solution."""
        y, v, x, w = self.exact(t)
        inner = self.k_2 * (y - x) + self.c_2 * (v - w)
        a = (self.f - self.k * y - inner) / (self.m + self.m_e)
        return -self.m_e * a - inner, a


def driven(A: np.ndarray, b: np.ndarray, x: np.ndarray, h: float, c: np.ndarray) -> np.ndarray:
    """x(h) of x' = A x + b u with u = sum c_i (t / h)^i: exact, by a chain of integrators."""
    n = len(x)
    p = len(c)
    whole = np.zeros((n + p, n + p))
    whole[:n, :n] = A
    whole[:n, n] = b
    whole[n + np.arange(p - 1), n + 1 + np.arange(p - 1)] = 1.0
    start = [ci * math.factorial(i) / h**i for i, ci in enumerate(c)]
    return (exponential(whole * h) @ np.concatenate((x, start)))[:n]


class Drive:
    """The left half; state (y, v). The right end of the interface rests, and no force acts there."""

    def __init__(self, data: Data, state: np.ndarray) -> None:
        self.data = data
        self.state = state

    def step(self, t: float, h: float, load: DriveLoad) -> Status:
        d = self.data
        mass = self.data.m + float(load.added_mass[0])
        c = np.array([load.start[0] + d.f, load.linear[0], load.quadratic[0]])
        self.state = driven(
            np.array([[0.0, 1.0], [-d.k / mass, 0.0]]),
            np.array([0.0, 1.0 / mass]),
            self.state,
            h,
            c,
        )
        return Status(True)

    def position(self) -> np.ndarray:
        return both(self.state[0])

    def motion(self, load: DriveLoad, s: float) -> InterfaceMotion:
        d = self.data
        y, v = self.state
        force = load.start[0] + s * (load.linear[0] + s * load.quadratic[0])
        return InterfaceMotion(
            both(y), both(v), both((d.f - d.k * y + force) / (d.m + load.added_mass[0]))
        )

    def ends(self, motion: InterfaceMotion) -> tuple[EndMotion, EndMotion]:
        return EndMotion(
            y=motion.position[0], vy=motion.speed[0], ay=motion.acceleration[0]
        ), NOTHING

    def accelerance(self) -> np.ndarray:
        return np.diag(both(1.0 / self.data.m))

    def work(self) -> float:
        """Work of F: the energy less the work of f."""
        d = self.data
        y, v = self.state
        return float(d.m * v * v / 2 + d.k * y * y / 2 - d.f * y)

    def save(self) -> np.ndarray:
        return self.state

    def restore(self, snapshot: np.ndarray) -> None:
        self.state = snapshot


class Follower:
    """The right half; state (x, w), and the end's motion (y, v, a), which is a quintic within a step."""

    def __init__(
        self, data: Data, state: np.ndarray, end: np.ndarray, mean: float, h: float
    ) -> None:
        self.data = data
        self.state = state
        self.end = end
        self.mean = mean
        self.h = h

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        d = self.data
        y0, v0, a0 = self.end
        before = self.state
        new = np.array([left.y, left.vy, left.ay])
        dx = new[0] - y0 - h * v0 - h * h * a0 / 2
        dv = h * (new[1] - v0 - h * a0)
        da = h * h * (new[2] - a0)
        c = np.array([10 * dx - 4 * dv + da / 2, -15 * dx + 7 * dv - da, 6 * dx - 3 * dv + da / 2])
        c = np.concatenate(([y0, h * v0, h * h * a0 / 2], c))
        A = np.array([[0.0, 1.0], [-d.k_2 / d.m_2, -d.c_2 / d.m_2]])
        force = d.k_2 * c + d.c_2 * np.append(np.arange(1, 6) * c[1:], 0.0) / h
        self.state = driven(A, np.array([0.0, 1.0 / d.m_2]), before, h, force)
        self.mean = -(d.m_e * (new[1] - v0) + d.m_2 * float(self.state[1] - before[1])) / h
        self.end = new
        self.h = h
        return Status(True)

    def reader(self, names: Sequence[str]) -> Reader:
        signals = {
            "left.fy": self.force,
            "left.fy_mean": lambda: self.mean,
            "left.added_mass": self.added_mass,
        }
        asked = [signals.get(name, lambda: 0.0) for name in names]
        return lambda: np.array([signal() for signal in asked])

    def force(self) -> float:
        d = self.data
        x, w = self.state
        y, v, a = self.end
        return -d.m_e * a - d.k_2 * (y - x) - d.c_2 * (v - w)

    def added_mass(self) -> float:
        """Answer to an acceleration that grows over the last step."""
        still = Follower(self.data, np.zeros(2), np.zeros(3), 0.0, self.h)
        still.step(0.0, self.h, EndMotion(y=self.h**2 / 6, vy=self.h / 2, ay=1.0), NOTHING)
        return -still.force()

    def save(self) -> dict[str, Any]:
        return {**vars(self)}

    def restore(self, snapshot: dict[str, Any]) -> None:
        vars(self).update(snapshot)


def start(data: Data, t: float, H: float) -> tuple[CoupledSystem, SchemeState]:
    """Both halves on the exact solution at t, with exact samples of the two steps before."""
    samples = []
    for past in (t - 2 * H, t - H, t):
        now = data.exact(past)
        before = data.exact(past - H)
        force, a = data.forces(past)
        impulse = data.m_e * (now.v - before.v) + data.m_2 * (now.w - before.w)
        samples.append(Sample(past, both(force), both(-impulse / H), both(a)))
    y, v, x, w = data.exact(t)
    follower = Follower(data, np.array([x, w]), np.array([y, v, a]), float(samples[-1].mean[0]), H)
    return CoupledSystem(Drive(data, np.array([y, v])), follower), SchemeState(tuple(samples))


def error(scheme: Scheme, H: float, data: Data | None = None) -> float:
    """RMS error of the force over its largest, from 0.5 to 2.5 s, at the communication points."""
    data = data or Data()
    begin = 0.5
    coupled, scheme_state = start(data, begin, H)
    found = []
    times = begin + H * np.arange(round(2.0 / H))
    for t in times:
        advance = scheme.advance(coupled, scheme_state, float(t), H)
        if not advance.status.valid:
            return math.inf
        scheme_state = advance.scheme_state
        found.append(float(scheme_state.last.force[0]))
    exact = np.array([data.forces(float(t) + H)[0] for t in times])
    return float(np.sqrt(np.mean((np.array(found) - exact) ** 2)) / np.max(np.abs(exact)))


EVEN = Solver(tolerance=1e6)  # steps that no error shortens
#: order in the communication step for smooth motion, by the end of a scheme's name
THEORY = {"0": 1, "1": 2, "2": 3, "preserving": 1, "impulse": 1, "controlled": 2}
THEORY |= dict.fromkeys(("jacobian", "aitken", "secant"), 4)
TRIP = Winding(travel=0.002, settle=0.15, start_delay=0.0)


def tight(name: str) -> Scheme:
    """The scheme, with a tolerance that does not show."""
    scheme = SCHEMES[name]
    if isinstance(scheme, Iterative):
        return replace(scheme, tolerance=1e-9)
    return scheme


@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_has_the_order_of_its_theory(name: str) -> None:
    errors = [error(tight(name), H) for H in (0.01, 0.005)]
    assert_allclose(math.log2(errors[0] / errors[1]), THEORY[name.rpartition("-")[2]], atol=0.12)
    if name.startswith("iterative"):  # the monolithic solution
        assert errors[1] < 1e-7


@pytest.mark.parametrize("accelerator", ["jacobian", "secant"])
def test_iteration_and_semi_implicit_exchange_hold_where_the_end_is_heavier_than_the_drive(
    accelerator: Any,
) -> None:
    heavy = Data(m_e=20.0)
    errors = [error(Iterative(accelerator, 1e-9, hold_mean=True), H, heavy) for H in (0.01, 0.005)]
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
def test_a_scheme_that_cannot_keep_what_is_asked_says_so(
    scheme: Scheme, data: Data, H: float, words: str
) -> None:
    assert words in scheme.advance(*start(data, 0.5, H), 0.5, H).status.message


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_extrapolation_reproduces_polynomials_of_its_order_on_uneven_samples(degree: int) -> None:
    def f(t: float) -> np.ndarray:
        return np.array([1.0 + 2.0 * (degree > 0) * t - 3.0 * (degree > 1) * t * t])

    samples = [Sample(t, f(t), f(t), f(t)) for t in (-0.5, -0.2, 0.1)]
    c0, c1, c2 = explicit.extrapolation_coefficients(samples, "force", degree, 0.3)
    for s in (0.0, 0.4, 1.0):
        assert_allclose(c0 + s * (c1 + s * c2), f(0.1 + 0.3 * s), rtol=1e-12)


@pytest.mark.parametrize(("inner", "bound"), [(ImpulsePreserving(), 1.0), (GaussSeidel(1), 0.05)])
def test_energy_control_keeps_the_residual_below_its_bound(inner: Scheme, bound: float) -> None:
    H = 0.04
    free, free_memory = start(Data(), 0.5, H)
    coupled, scheme_state = start(Data(), 0.5, H)
    scheme = EnergyControlled(inner, bound)
    worst = 0.0
    uncontrolled = 0.0
    for k in range(25):
        advance = scheme.advance(coupled, scheme_state, 0.5 + k * H, H)
        assert advance.status.valid
        worst = max(worst, abs(advance.scheme_state.residual - scheme_state.residual) / H)
        scheme_state = advance.scheme_state
        after = inner.advance(free, free_memory, 0.5 + k * H, H).scheme_state
        uncontrolled = max(uncontrolled, abs(after.residual - free_memory.residual) / H)
        free_memory = after
    assert worst <= bound < uncontrolled
    assert scheme_state.exchanges > 25


# a mere mass; and F = -Z v with speeds that decay by 0.9 per step: the root is 0.9 - Z H / M
@pytest.mark.parametrize(
    ("degree", "impedance", "limit"),
    [
        *((k, np.eye(21)[0], limit) for k, limit in enumerate((1.0, 1 / 2, 3 / 11))),
        (0, 1.9 * 0.9 ** np.arange(400), 1.0),
    ],
)
def test_the_growth_is_one_at_the_limit_of_theory(
    degree: int, impedance: np.ndarray, limit: float
) -> None:
    assert_allclose(
        growth_per_step(GaussSeidel(degree), impedance, 1.0 / limit, 0.0), 1.0, rtol=1e-9
    )


def test_a_semi_implicit_exchange_with_a_mere_mass_leaves_nothing_of_a_disturbance() -> None:
    assert growth_per_step(SemiImplicit(0), np.eye(21)[0], 0.1, 1.0) == 0.0
    assert (
        growth_per_step(SemiImplicit(0), np.eye(21)[0], 0.1, 0.2) > 1.0
    )  # the added mass of another step


def test_the_jacobian_of_the_held_mean_is_exact_for_a_mere_mass() -> None:
    coupled, scheme_state = start(Data(m_e=20.0, k=0.1, k_2=0.0, c_2=0.0), 0.5, 0.01)
    advance = Iterative("jacobian", 1e-9, hold_mean=True).advance(coupled, scheme_state, 0.5, 0.01)
    assert advance.status.valid
    assert advance.scheme_state.exchanges == 2


def wind(scheme: str, **options: Any) -> Result:
    return Host(rope_in_process("rope-120", "draft"), Hoist(), TRIP, Coupling(scheme=scheme)).run(
        **options
    )


@pytest.mark.parametrize(
    "name", ["gauss-seidel-2", "semi-implicit-1", "iterative-jacobian", "energy-controlled"]
)
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


def test_a_choice_that_will_be_unstable_is_warned_of_with_the_number(
    caplog: pytest.LogCaptureFixture,
) -> None:
    light = Hoist(conveyance_mass=300.0, payload_left=0.0)
    host = Host(
        rope_in_process("rope-120", "draft"),
        light,
        TRIP,
        Coupling(step=0.02, scheme="gauss-seidel-2"),
    )
    with caplog.at_level(logging.WARNING):
        result = host.run(lambda fraction, t: False)
    assert host.stability is not None
    assert host.stability.growth_per_step > 1.1
    assert f"grow {host.stability.growth_per_step:.3g} times per step" in result.warning
    assert result.warning in caplog.text


@pytest.mark.parametrize("case", BUILTIN_HOISTS)
@pytest.mark.parametrize("H", [0.005, 0.01, 0.02])
def test_the_default_is_expected_to_be_stable_on_every_case(case: str, H: float) -> None:
    scene = find_case(case)
    plant = rope_in_process(case, level="draft")
    host = Host(plant, scene.hoist, scene.winding, Coupling(step=H), scene.gains)
    assert host.run(lambda fraction, t: False).warning == ""
    assert host.stability is not None
    assert host.stability.growth_per_step < MARGIN


@pytest.mark.parametrize("way", ["rejects", "nan", "raises", "cannot be read"])
def test_a_failure_saves_the_last_good_state_and_the_run_resumes_to_the_same_bits(
    way, tmp_path, monkeypatch, caplog
):
    monkeypatch.setattr("hoist_demo.cosimulation.host.SAVE_INTERVAL", 0.03)
    whole = wind("gauss-seidel-1")
    step = InProcessRope.step
    reader = InProcessRope.reader
    at = 0.555

    def faulty_step(
        self: InProcessRope, t: float, h: float, left: EndMotion, right: EndMotion
    ) -> Status:
        if way == "rejects" and t >= at:
            return Status(False, "this step is refused")
        status = step(self, t, h, left, right)
        if way == "raises" and t >= at:
            raise RuntimeError("the rope is gone")
        return status

    def faulty_reader(self: InProcessRope, names: Sequence[str]) -> Reader:
        read = reader(self, names)

        def faulty() -> np.ndarray:
            if way == "nan" and self.save().state.motion.t > at:
                return np.full(len(names), math.nan)
            reads_the_record = tuple(names) != ROPE_FORCES
            if way == "cannot be read" and reads_the_record and self.save().state.motion.t > at:
                raise ParticipantFailed("the rope cannot be read")
            return read()

        return faulty

    with monkeypatch.context() as patch:
        patch.setattr(CompiledTrip, "for_run", lambda *_: None)
        patch.setattr(InProcessRope, "step", faulty_step)
        patch.setattr(InProcessRope, "reader", faulty_reader)
        # the trial before the start takes 0.48 s of the rope's time
        stopped = wind("gauss-seidel-1", save_to=tmp_path / "last_good.npz")
    assert not stopped.completed
    # a mistake in the code shows its place
    assert ("faulty_step" in caplog.text) == (way == "raises")
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


@pytest.mark.parametrize(
    "scheme",
    [
        "gauss-seidel-1",
        "semi-implicit-0",
        "semi-implicit-1",
        "impulse-preserving",
        "iterative-secant",
        "energy-controlled",
    ],
)
def test_a_stopped_run_of_every_kind_of_scheme_resumes_to_the_same_bits(
    scheme: str, tmp_path: Path
) -> None:
    whole = wind(scheme)
    stopped = wind(scheme, progress=lambda fraction, t: t < 0.1, save_to=tmp_path / "kept.npz")
    assert stopped.saved is not None
    resumed = wind(scheme, resume=Checkpoint.read(stopped.saved))
    assert resumed.completed, resumed.cause
    for name, values in whole.recording.signals.items():
        assert_array_equal(resumed.recording[name], values, name)


def test_a_run_may_resume_with_another_scheme_but_not_as_another_trip(tmp_path: Path) -> None:
    stopped = wind("impulse-preserving", progress=lambda fraction, t: t < 0.1)
    assert stopped.checkpoint is not None
    assert wind("iterative-secant", resume=stopped.checkpoint).completed
    with pytest.raises(ValueError, match="must be of the same hoist"):
        Host(rope_in_process("rope-120", "draft"), Hoist(), replace(TRIP, travel=0.003)).run(
            resume=stopped.checkpoint
        )


def test_a_file_that_is_no_checkpoint_is_named(tmp_path: Path) -> None:
    (tmp_path / "x.npz").write_text(json.dumps({}))
    with pytest.raises(ValueError, match=r"x\.npz' must be a checkpoint"):
        Checkpoint.read(tmp_path / "x.npz")


@pytest.mark.parametrize(
    ("solver", "warned"), [(Solver(step_max=0.0025), True), (Solver(), True), (EVEN, False)]
)
def test_at_40_ms_the_host_warns_where_the_rope_s_own_steps_do_not_damp_the_waves(
    solver: Solver, warned: bool
) -> None:
    scene = find_case("rope-120")
    rope = InProcessRope(rope_scene(scene.rope).with_(solver=solver))
    host = Host(rope, scene.hoist, TRIP, Coupling(step=0.04, scheme="jacobi-2"))
    assert bool(host.run(lambda fraction, t: False).warning) == warned
