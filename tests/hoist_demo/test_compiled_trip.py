"""A trip in C has the numbers, the words and the states of the host in Python, and leaves to it what it cannot wind."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from ctypes import CFUNCTYPE, c_double, c_float, c_int, c_size_t, c_void_p
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from checkout import HELPERS, QUICK
from exports import FLAVOURS
from numpy.testing import assert_allclose
from rope_groups import rope_in_process

from hoist_demo.cases.table import find_case
from hoist_demo.control.controller import Gains
from hoist_demo.cosimulation.compiled_trip import CompiledTrip
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants import fmu_rope
from hoist_demo.cosimulation.participants.fmi_versions import Instance
from hoist_demo.cosimulation.participants.fmu_description import Fmu, read_fmu
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.cosimulation.schemes.interface import ROPE_FORCES, RopePlant
from hoist_demo.parameters import Coupling, Winding
from rope_model import EndMotion, Level

pytestmark = pytest.mark.skipif("native-3" not in FLAVOURS, reason="needs a C compiler")

COUPLING = Coupling(step=0.02, sample=0.01)
GAINS = Gains()
TRIP = Winding(travel=6.0, speed=4.0, start_delay=0.2, settle=0.8)


@dataclass
class Wound:
    """Runs of one trip, in Python where that is asked for."""

    name: str = "rope-120"
    level: Level = "draft"
    coupling: Coupling = COUPLING
    winding: Winding = TRIP
    gains: Gains = GAINS
    rope: dict[str, Any] = field(default_factory=dict)
    hoist: dict[str, Any] = field(default_factory=dict)
    fmu: Path | None = None

    def run(self, python: bool = False, **options: Any) -> Result:
        case = find_case(self.name)
        rope: RopePlant
        if self.fmu is not None:
            rope = FmuRope(self.fmu, {**case.rope, **self.rope})
        else:
            rope = rope_in_process(self.name, self.level, self.rope)
        hoist = replace(case.hoist, **self.hoist)
        host = Host(rope, hoist, self.winding, self.coupling, self.gains)
        if python:
            with patch.object(CompiledTrip, "for_run", return_value=None):
                result = host.run(**options)
        else:
            result = host.run(**options)
        if self.fmu is not None:
            rope.close()
        return result


@pytest.fixture
def in_c(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Numbers of the samples that were done in C, call by call."""
    done: list[int] = []
    samples = CompiledTrip.wind_samples

    def counted(self: CompiledTrip, first: int, last: int) -> Any:
        reached = samples(self, first, last)
        done.append(reached.sample - first)
        return reached

    monkeypatch.setattr(CompiledTrip, "wind_samples", counted)
    return done


def assert_alike(one: Result, other: Result) -> None:
    """The same outcome, and numbers to 1e-9 of a signal's largest: another libm rounds otherwise, here none differs."""
    for outcome in ("cause", "completed", "steps", "winding"):
        assert getattr(one, outcome) == getattr(other, outcome)
    assert list(one.recording.signals) == list(other.recording.signals)
    for name, values in other.recording.signals.items():
        largest = float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))
        assert_allclose(one.recording[name], values, rtol=0.0, atol=1e-9 * largest, err_msg=name)


@pytest.mark.parametrize("kind", ["native-2", "native-3"])
def test_an_fmu_is_wound_in_c(kind: str, fmu_of: Callable[[str], Path], in_c: list[int]) -> None:
    wound = Wound(fmu=fmu_of(kind), winding=replace(TRIP, travel=0.5, settle=0.2))
    test_a_trip_in_c_has_the_numbers_of_python(wound, in_c)


@pytest.mark.parametrize(
    "wound",
    [
        Wound(),
        Wound(level="standard", coupling=Coupling(step=0.01, sample=0.02)),
        Wound("monopol-1000", coupling=Coupling(step=0.02)),  # its conveyances have play
        Wound("rope-240", rope={"model.fidelity": 1}),
    ],
    ids=lambda wound: f"{wound.name} {wound.level}",
)
def test_a_trip_in_c_has_the_numbers_of_python(wound: Wound, in_c: list[int]) -> None:
    whole = wound.run()
    assert sum(in_c) == whole.recording.time.size - 1
    assert_alike(whole, wound.run(python=True))
    assert sum(in_c) == whole.recording.time.size - 1


def test_a_guard_of_the_rope_stops_the_hoist_as_in_python(in_c: list[int]) -> None:
    wound = Wound(
        winding=replace(TRIP, travel=20.0), rope={"guard.window": 0.6, "model.fidelity": 1}
    )
    stopped = wound.run()
    assert stopped.winding.emergency_at is not None
    assert in_c.count(0) == 1  # the sample that sees it
    assert sum(in_c) == stopped.recording.time.size - 2
    assert_alike(stopped, wound.run(python=True))


SHORT_SAMPLES = Coupling(step=0.02, sample=0.01)
LONG_SAMPLES = Coupling(step=0.01, sample=0.02)


@pytest.mark.parametrize(
    ("kind", "coupling"),
    [
        ("", SHORT_SAMPLES),
        ("", LONG_SAMPLES),
        ("native-3", SHORT_SAMPLES),
        pytest.param("native-3", LONG_SAMPLES, marks=pytest.mark.slow),
        pytest.param("native-2", SHORT_SAMPLES, marks=pytest.mark.slow),
        pytest.param("native-2", LONG_SAMPLES, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("part", ["rope", "drive"])
def test_a_trip_that_fails_does_so_with_the_words_of_python(
    part: str, kind: str, coupling: Coupling, fmu_of
) -> None:
    wound = Wound(coupling=coupling)
    if kind:
        wound.fmu = fmu_of(kind)
    if part == "rope":
        wound.rope = {"inputs.acceleration_max": 0.5}  # m/s^2, less than the trip's
    else:
        wound.hoist = {"shaft_travel": 6.0, "head_rope_length_up": 0.3}
        # overshoots
        wound.gains = Gains(speed=2e4, integral_time=0.2, position=3.0, feed_forward=0.0)
    failed = wound.run()
    told = wound.run(python=True)
    place = {"rope": 0, "drive": 1}[part]
    assert part in failed.cause.split(":")[place]
    assert_alike(failed, told)
    assert failed.checkpoint is not None
    assert told.checkpoint is not None
    assert failed.checkpoint.sample == told.checkpoint.sample


@pytest.mark.parametrize("python", [False, True])
def test_a_trip_goes_on_in_the_other_form(python: bool) -> None:
    wound = Wound()
    stopped = wound.run(python, progress=lambda _, t: t < 1.51)
    assert stopped.checkpoint is not None
    assert_alike(wound.run(not python, resume=stopped.checkpoint), wound.run())


def test_warnings_are_those_of_python(caplog: pytest.LogCaptureFixture) -> None:
    winding = replace(find_case("caught-rope").winding, settle=6.0)
    wound = Wound("caught-rope", coupling=Coupling(step=0.02), winding=winding)
    told = []
    for python in (False, True):
        caplog.clear()
        wound.run(python)
        told.append(
            [
                record.getMessage()
                for record in caplog.records
                if record.name.startswith("hoist_demo")
            ]
        )
    assert "has struck" in told[0][0]
    assert told[0] == told[1]


def test_other_schemes_slipping_ropes_and_brakes_are_wound_in_python(in_c: list[int]) -> None:
    for wound in (
        Wound(coupling=Coupling(step=0.02, scheme="semi-implicit-1")),
        Wound("jammed-conveyance"),
        Wound("slack-rope", winding=replace(find_case("slack-rope").winding, emergency_at=0.5)),
    ):
        # what is wound in C is so from the first sample on; here the brake holds since 0.5 s
        assert wound.run(progress=lambda _, t: t < 1.5).recording.time[-1] > 1.4
    assert sum(in_c) == 0


def _with_types(fmu: Path, types: dict[str, str]) -> Fmu:
    """Return the description of an FMU with other types of these variables."""
    described = read_fmu(fmu)
    variables = [replace(v, type=types.get(v.name, v.type)) for v in described.variables]
    return replace(described, variables=tuple(variables))


@pytest.mark.parametrize("name", ["left.y", "right.az", "left.fy", "right.fy_mean", "left.fx"])
def test_a_rope_with_single_precision_is_not_wound_in_c(
    name: str, fmu_of: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    fmu = fmu_of("native-3")
    rope = FmuRope(fmu)
    assert rope.library() is not None
    rope.close()
    described = _with_types(fmu, {name: "Float32"})
    monkeypatch.setattr(fmu_rope, "read_fmu", lambda _: described)
    rope = FmuRope(fmu)
    assert rope.library() is None
    rope.close()


def test_each_motion_is_set_by_the_function_of_its_own_type(
    fmu_of: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    ends = EndMotion(y=0.25), EndMotion(y=89.75)  # exact in single precision
    fmu = fmu_of("native-3")
    rope = FmuRope(fmu)
    assert rope.initialize(0.0, *ends).valid
    expected = rope.reader(ROPE_FORCES)()
    rope.close()

    described = _with_types(fmu, {"left.y": "Float32", "right.y": "Float32"})
    monkeypatch.setattr(fmu_rope, "read_fmu", lambda _: described)
    function = Instance._function
    set_singles: list[list[float]] = []
    kept = []

    def function_with_singles(self: Instance, name: str) -> Any:
        if name != "SetFloat32":
            return function(self, name)
        set_doubles = function(self, "SetFloat64")

        def set_floats(fmu: int, references: int, count: int, values: int, length: int) -> int:
            singles = list((c_float * length).from_address(values))
            set_singles.append(singles)
            doubles = (c_double * length)(*singles)
            status: int = set_doubles(
                c_void_p(fmu), c_void_p(references), c_size_t(count), doubles, c_size_t(length)
            )
            return status

        kept.append(CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p, c_size_t)(set_floats))
        return kept[-1]

    monkeypatch.setattr(Instance, "_function", function_with_singles)
    rope = FmuRope(fmu)
    assert rope.initialize(0.0, *ends).valid
    forces = rope.reader(ROPE_FORCES)()
    rope.close()
    assert set_singles == [[0.25, 89.75]]
    assert forces.tolist() == expected.tolist()


def test_an_input_that_is_no_real_number_is_refused(
    fmu_of: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    fmu = fmu_of("native-3")
    described = read_fmu(fmu)
    variables = [
        replace(v, type="Int32", kind="Integer") if v.name == "left.y" else v
        for v in described.variables
    ]
    described = replace(described, variables=tuple(variables))
    monkeypatch.setattr(fmu_rope, "read_fmu", lambda _: described)
    with pytest.raises(ValueError, match=r"must have left\.y as a real number, not of the type"):
        FmuRope(fmu)


#: A call through a type whose result is an int for an enumeration: what the check below must find.
_OTHER_TYPE = """\
typedef enum { WELL } Status;
static Status called(void *x) { return x ? WELL : WELL; }
int main(void) {
    int (*volatile other)(void *) = (int (*)(void *))(void (*)(void))called;
    return other(0);
}
"""
#: Winds the rope in process, and FMUs, in C, compiled with checks of each call through a pointer, and prints the
#: samples done in C.  The FMUs have the stand-in for the rope behind their own shell.  No number is looked at:
#: without optimisation, and without the forms for some processors.
_CHECKED = """\
import json, sys
from dataclasses import replace
from pathlib import Path
from fmu_src.shell import build
from rope_model import compiler as kernels
for module in (build, kernels):
    module.FLAGS = (*(flag for flag in module.FLAGS if flag != "-O3"), *json.loads(sys.argv[1]))
from exports import export_stand_in
from hoist_demo.cosimulation.compiled_trip import CompiledTrip
from test_compiled_trip import TRIP, Wound
samples, done = CompiledTrip.wind_samples, []
def counted(self, first, last):
    reached = samples(self, first, last)
    done[-1] += reached.sample - first
    return reached
CompiledTrip.wind_samples = counted
fmus = [export_stand_in(Path(f"{fmi}.fmu").absolute(), fmi) for fmi in (2, 3)]
for fmu in (None, *fmus):
    done.append(0)
    run = Wound("monopol-1000", fmu=fmu, winding=replace(TRIP, travel=0.2, settle=0.1)).run()
    assert run.completed or fmu, run.cause  # the stand-in lets a hoist run away after half a second
print(json.dumps(done))
"""


@pytest.mark.slow
@pytest.mark.skipif(
    sys.platform != "linux" or not find_spec("ziglang"), reason="needs Linux and ziglang's clang"
)
def test_trip_in_c_calls_each_function_by_its_own_type(tmp_path: Path) -> None:
    # zig checks all code that is not optimised for more than this
    checks = [
        "-O0",
        "-fno-sanitize=all",
        "-fsanitize=function",
        "-fsanitize-trap=function",
        "-DHAS_WIDE_FORMS=0",
    ]
    zig = [sys.executable, "-m", "ziglang", "cc"]
    (tmp_path / "other.c").write_text(_OTHER_TYPE)
    subprocess.run([*zig, *checks, "other.c", "-o", "other"], cwd=tmp_path, check=True)
    if subprocess.run([tmp_path / "other"], check=False).returncode == 0:
        pytest.skip("this ziglang does not check types of functions in C: needs clang 17")
    # not the copies that the quick tests compile with less optimisation
    quick = str(QUICK)
    path = [part for part in os.environ["PYTHONPATH"].split(os.pathsep) if part != quick]
    environment = {**os.environ, "CC": " ".join(zig), "BALANCE_ROPE_CACHE": str(tmp_path / "cache")}
    environment["PYTHONPATH"] = os.pathsep.join([*path, str(HELPERS), str(Path(__file__).parent)])
    command = [sys.executable, "-c", _CHECKED, json.dumps(checks)]
    wound = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert wound.returncode == 0, wound.stderr[-3000:]
    assert all(done > 10 for done in json.loads(wound.stdout.splitlines()[-1])), wound.stdout
