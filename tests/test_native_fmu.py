"""The native FMU's shells, tables and packaging, on a stand-in for the rope (tests/native/stand_in.c)."""

from __future__ import annotations

import ctypes
import math
import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy.build import build_platform_binary
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from hypothesis import given, settings
from hypothesis import strategies as st
from lxml import etree
from native_host import H, Host

from balance_rope import main
from fmu_src.interface import scene_of, variables
from fmu_src.native.build import PLATFORMS, available_platforms, host_platform, library
from fmu_src.native.export import export_native
from fmu_src.native.mach_o import universal
from fmu_src.profile import FULL
from rope_model.native.tables import parameter_structures, signal_numbers
from rope_model.parameters import rope_120
from rope_model.simulation.ends import refusal
from rope_model.simulation.paths import EndMotion, EndPath

ROOT = Path(__file__).resolve().parent.parent
SCHEMAS = Path(fmpy.__file__).with_name("schema")
VERSIONS = (2, 3)


def stand_in() -> dict[str, str]:
    """What stands behind rope.h in these tests."""
    files = (ROOT / "tests" / "native" / "stand_in.c", ROOT / "rope_model" / "native" / "rope.h")
    texts = {path.name: path.read_text(encoding="utf-8") for path in files}
    return texts | {"parameters.h": parameter_structures(), "signal_numbers.h": signal_numbers()}


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    folder = tmp_path_factory.mktemp("native")
    here = (host_platform(),)
    return {
        fmi: export_native(folder / f"{fmi}.fmu", fmi=fmi, platforms=here, rope=stand_in(), profile=FULL)
        for fmi in VERSIONS
    }


@pytest.fixture(scope="module")
def folders(fmus: dict[int, Path], tmp_path_factory: pytest.TempPathFactory) -> dict[int, str]:
    return {fmi: fmpy.extract(str(path), str(tmp_path_factory.mktemp("unzipped"))) for fmi, path in fmus.items()}


@pytest.fixture(params=VERSIONS)
def fmi(request: pytest.FixtureRequest) -> int:
    version: int = request.param
    return version


@pytest.fixture
def host(fmi: int, fmus: dict[int, Path], folders: dict[int, str]) -> Iterator[Host]:
    made = Host(fmus[fmi], folders[fmi])
    yield made
    made.call("FreeInstance")


# description and package


def test_fmpy_validation_reports_nothing(fmi: int, fmus: dict[int, Path]) -> None:
    assert validate_fmu(str(fmus[fmi])) == []


@pytest.mark.parametrize(
    ("name", "schema"),
    [
        ("terminalsAndIcons/terminalsAndIcons.xml", "fmi3/fmi3TerminalsAndIcons.xsd"),
        ("sources/buildDescription.xml", "fmi3/fmi3BuildDescription.xsd"),
    ],
)
def test_other_descriptions_follow_their_schemas(fmi: int, fmus: dict[int, Path], name: str, schema: str) -> None:
    with zipfile.ZipFile(fmus[fmi]) as archive:
        document = etree.fromstring(archive.read(name))
    etree.XMLSchema(file=str(SCHEMAS / schema)).assertValid(document)


def test_terminals_have_all_motions_and_forces_of_their_ends(fmi: int, fmus: dict[int, Path]) -> None:
    names = {v.name for v in fmpy.read_model_description(str(fmus[fmi])).modelVariables}
    with zipfile.ZipFile(fmus[fmi]) as archive:
        root = ElementTree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        assert {f"terminalsAndIcons/{t.get('iconBaseName')}.png" for t in root.iter("TerminalGraphicalRepresentation")}
    for terminal in root.iter("Terminal"):
        members = [member.get("variableName") for member in terminal.iter("TerminalMemberVariable")]
        assert len(members) == 11 + 6
        assert set(members) <= names


def test_archive_is_sorted_deflated_relative_and_without_dates(fmi: int, fmus: dict[int, Path]) -> None:
    with zipfile.ZipFile(fmus[fmi]) as archive:
        names = archive.namelist()
        assert names == sorted(names)
        assert not any(name.startswith("/") or "\\" in name or ".." in name for name in names)
        assert {(e.compress_type, e.date_time) for e in archive.infolist()} == {
            (zipfile.ZIP_DEFLATED, (1980, 1, 1, 0, 0, 0))
        }
        picture = "model.png" if fmi == 2 else "terminalsAndIcons/icon.png"
        for name in ("documentation/index.html", "documentation/licenses/license.txt", picture):
            assert name in names


def test_same_sources_give_the_same_bytes_and_other_start_values_another_token(
    fmi: int, fmus: dict[int, Path], tmp_path: Path
) -> None:
    again = export_native(tmp_path / "again.fmu", fmi=fmi, platforms=(host_platform(),), rope=stand_in(), profile=FULL)
    assert again.read_bytes() == fmus[fmi].read_bytes()
    long = export_native(tmp_path / "long.fmu", "rope-240", fmi=fmi, platforms=(host_platform(),), rope=stand_in())
    tokens = {fmpy.read_model_description(str(path)).guid for path in (again, long)}
    assert len(tokens) == 2


def test_only_fmi_functions_are_exported(fmi: int, folders: dict[int, str]) -> None:
    if shutil.which("nm") is None or host_platform() not in ("x86_64-linux", "aarch64-linux"):
        pytest.skip("needs nm")
    binary = next(Path(folders[fmi], "binaries").rglob("BalanceRope.so"))
    listing = subprocess.run(["nm", "-D", "--defined-only", binary], capture_output=True, text=True, check=True).stdout
    names = [line.split()[-1] for line in listing.splitlines()]
    assert len(names) == {2: 44, 3: 75}[fmi]
    assert all(name.startswith(f"fmi{fmi}") for name in names)


def test_value_references_are_places_in_the_table_in_both_versions(fmus: dict[int, Path]) -> None:
    places = {v.name: i for i, v in enumerate(variables(rope_120()))}
    for path in fmus.values():
        for v in fmpy.read_model_description(str(path)).modelVariables:
            name = v.name if v.name in places else f"{v.name}[1]"
            assert v.valueReference == places.get(name, len(places)), v.name  # the time comes last


def test_values_beyond_min_and_max_of_a_parameter_are_refused_by_the_rope() -> None:
    table = variables(rope_120())
    start = {v.name: v.start for v in table if v.start is not None}
    for v in table:
        if v.causality != "parameter" or v.kind == "Boolean":
            continue
        for bound, beyond in ((v.minimum, -1), (v.maximum, 1)):
            if bound is not None:
                size = 1 if v.kind == "Integer" else 1e-9 * max(1.0, abs(bound))
                with pytest.raises(ValueError, match=r".+"):
                    scene_of(start | {v.name: type(v.start)(bound + beyond * size)})


#: parameters that go along with another one's bound: static friction is no less than kinetic, and the like
_ALONG = {
    "rope.Qa": {"rope.Qb": 0.0, "rope.Qc": 0.0},
    "rope.Qd": {"rope.Qb": 0.0, "rope.Qc": 0.0},
    "left.swivel.mu_static": {"left.swivel.mu_kinetic": 0.0},
    "right.swivel.mu_static": {"right.swivel.mu_kinetic": 0.0},
    "solver.step_max": {"solver.step_min": 1e-15},
    "solver.step_min": {"solver.step_max": 1.0},
    **{f"mesh.counts[{i}]": {f"mesh.counts[{j}]": 0 for j in (1, 2, 4, 5)} for i in range(1, 6)},
}


def test_min_and_max_of_a_parameter_are_taken_by_the_rope() -> None:
    table = variables(rope_120())
    start = {v.name: v.start for v in table if v.start is not None}
    for v in table:
        if v.causality != "parameter" or v.kind == "Boolean":
            continue
        for bound in (v.minimum, v.maximum):
            if bound is not None:
                scene_of(start | _ALONG.get(v.name, {}) | {v.name: type(v.start)(bound)})


def test_bounds_of_the_inputs_are_those_of_the_rope() -> None:
    peaks = EndPath.at_rest(0.0, EndMotion()).peak_accelerations()
    inputs = [v for v in variables(rope_120()) if v.causality == "input"]
    assert len(inputs) == 22
    for v in inputs:
        side, name = v.name.split(".")
        for bound in (v.minimum, v.maximum):
            assert bound is not None
            assert refusal(EndMotion(**{name: bound}), peaks, side) == ""
            assert "beyond" in refusal(EndMotion(**{name: math.nextafter(bound, math.inf * bound)}), peaks, side)


def test_sources_rebuild_with_fmpy_compile(fmi: int, fmus: dict[int, Path], tmp_path: Path) -> None:
    if shutil.which("cmake") is None:
        pytest.skip("needs cmake")
    folder = fmpy.extract(str(fmus[fmi]), str(tmp_path))
    shutil.rmtree(tmp_path / "binaries")
    build_platform_binary(folder)
    rebuilt = Host(fmus[fmi], folder)
    rebuilt.start()
    assert rebuilt.get("left.fy") == [pytest.approx(-15.0 * 8.0 * 9.81)]
    rebuilt.call("FreeInstance")


@pytest.mark.slow
def test_every_platform_is_built_from_here(tmp_path: Path) -> None:
    if set(available_platforms()) != set(PLATFORMS):
        pytest.skip("needs ziglang")
    for fmi in VERSIONS:
        made = export_native(tmp_path / f"{fmi}.fmu", fmi=fmi, rope=stand_in())
        with zipfile.ZipFile(made) as archive:
            heads = {name: archive.read(name)[:20] for name in archive.namelist() if name.startswith("binaries/")}
        folder = {2: ("linux64", "win64", "darwin64"), 3: ("x86_64-linux", "x86_64-windows", "aarch64-darwin")}[fmi]
        elf, pe, macho = (heads[next(n for n in heads if n.split("/")[1] == f)] for f in folder)
        assert elf[:4] == b"\x7fELF"
        assert pe[:2] == b"MZ"
        assert macho[:4] == {2: b"\xca\xfe\xba\xbe", 3: b"\xcf\xfa\xed\xfe"}[fmi]
        assert len(heads) == {2: 4, 3: 5}[fmi]


def test_universal_library_holds_its_parts_at_aligned_places() -> None:
    parts = [b"\xcf\xfa\xed\xfe" + bytes([7 + i, 0, 0, 1, 3, 0, 0, 0]) + bytes(100 * i) for i in (0, 5)]
    whole = universal(parts)
    for i, part in enumerate(parts):
        kind, _, place, size, power = (
            int.from_bytes(whole[k : k + 4], "big") for k in range(8 + 20 * i, 28 + 20 * i, 4)
        )
        assert kind == int.from_bytes(part[4:8], "little")
        assert place % (1 << power) == 0
        assert whole[place : place + size] == part


def test_unknown_platform_is_refused_with_the_choices() -> None:
    with pytest.raises(ValueError, match=host_platform()):
        library(stand_in(), "BalanceRope", "sparc-solaris")


# values


def test_outputs_follow_the_inputs_in_initialization_mode(host: Host) -> None:
    host.enter()
    first = host.get("left.fy", "right.fy")
    assert sum(first) == pytest.approx(-8.0 * 9.81 * 120.0)
    host.set(**{"right.y": 80.0})
    lower = host.get("left.fy", "right.fy")
    assert lower[0] - first[0] == pytest.approx(-0.5 * 10.0 * 8.0 * 9.81)
    host.fmu.exitInitializationMode()
    assert host.get("left.fy", "right.fy") == lower


def test_parameters_decide_until_initialisation_ends(host: Host) -> None:
    host.enter()
    host.get("left.fy")
    host.set(rope__mass_per_length=16.0)
    host.fmu.exitInitializationMode()
    assert sum(host.get("left.fy", "right.fy")) == pytest.approx(-16.0 * 9.81 * 120.0)
    assert host.get("status.valid", "status.message", "status.fidelity") == [True, "", "torsional"]


@pytest.mark.parametrize("at_step_end", [True, False])
def test_inputs_are_read_at_the_end_or_extrapolated(host: Host, at_step_end: bool) -> None:
    host.start(inputs_at_step_end=at_step_end)
    host.set(**{"right.vy": -2.0, "right.ay": -1.0})
    assert host.step(0.0, 0.1) == ""
    height = 90.0 if at_step_end else 90.0 - 0.2 - 0.005
    assert host.get("left.fy")[0] == pytest.approx(-0.5 * (120.0 - height) * 8.0 * 9.81)


@pytest.mark.parametrize("at_step_end", [True, False])
def test_directional_derivatives_are_those_of_a_step(host: Host, at_step_end: bool) -> None:
    host.start(inputs_at_step_end=at_step_end)
    assert host.step(0.0, 0.1) == ""  # the derivative is of a step as long as the last
    state = host.state()
    assert host.step(0.1, 0.1) == ""
    for name in ("right.y", "right.vy", "right.ay", "left.y", "left.ay"):
        analytic = host.derivative("right.fy", name, seed=2.0)
        force = []
        for change in (-1e-4, 1e-4):
            host.restore(state)
            host.set(**{name: host.get(name)[0] + change})
            assert host.step(0.1, 0.1) == ""
            force += host.get("right.fy")
        host.restore(state)
        assert host.step(0.1, 0.1) == ""
        assert analytic == pytest.approx(2.0 * (force[1] - force[0]) / 2e-4, rel=1e-6, abs=1e-6), name
    host.free(state)


def test_derivatives_of_others_are_refused(host: Host) -> None:
    host.start()
    for pair in (("loop.x", "left.y"), ("left.fy", "rope.EI"), ("left.y", "left.y")):
        with pytest.raises(FMICallException):
            host.derivative(*pair)
        assert "there is no derivative" in host.error()


def test_tunable_parameter_takes_effect_in_the_run(host: Host) -> None:
    host.start()
    host.run(0, 1)
    before = host.get("count.steps")[0]
    host.set(solver__step_max=0.0025)
    host.run(1, 2)
    assert host.get("count.steps")[0] - before == 4


def test_arrays_and_enumerations_of_fmi_3(fmus: dict[int, Path], folders: dict[int, str]) -> None:
    host = Host(fmus[3], folders[3])
    host.set(**{"mesh.counts": [4, 8, 80, 8, 4], "mesh.kind": 1})
    host.start()
    assert host.get("mesh.counts", "mesh.kind") == [[4, 8, 80, 8, 4], 1]
    assert len(host.get("shape.x")[0]) == 81
    host.run(0, 3)
    assert host.get("time") == [pytest.approx(0.03)]
    values = (ctypes.c_double * 80)()
    reference = (ctypes.c_uint * 1)(host.variables["shape.x"].valueReference)
    assert host.call("GetFloat64", reference, ctypes.c_size_t(1), values, ctypes.c_size_t(80)) == 3
    assert "fewer values" in host.error()
    host.call("FreeInstance")


# errors


def test_a_read_that_fails_is_said_once(host: Host) -> None:
    host.enter()
    host.set(**{"rope.length": -1.0})
    outputs = [v.valueReference for v in host.variables.values() if v.name.startswith(("left.f", "loop."))]
    host.log.clear()
    with pytest.raises(FMICallException):
        getattr(host.fmu, "getReal" if host.fmi == 2 else "getFloat64")(outputs)
    assert len([message for status, message in host.log if status == 3]) == 1


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"left.vy": math.nan}, "left.vy = nan is not finite; check the signal"),
        ({"left.y": -math.inf}, "left.y = -inf is not finite"),
        ({"rope.EI": 100.0}, "rope.EI is fixed after initialisation; it stays 300; reset"),
        ({"left.fy": 0.0}, "left.fy is an output"),
        ({"left.swivel.mode": 2}, "left.swivel.mode is fixed"),
        ({"solver.step_max": math.nan}, "solver.step_max = nan is out of range: it must be finite"),
    ],
)
def test_bad_values_are_refused_and_the_fmu_is_usable_after_reset(host: Host, values: Any, words: str) -> None:
    host.start()
    host.run(0, 2)
    with pytest.raises(FMICallException):
        host.set(**values)
    assert words in host.error()
    assert host.get("status.valid") == [False]
    assert words in host.get("status.message")[0]
    assert "is not allowed after a failure" in host.step(2 * H)
    host.fmu.reset()
    host.start()
    assert len(host.run(0, 2)) == 2
    assert host.get("status.valid", "status.message") == [True, ""]


@pytest.mark.parametrize(
    ("t", "h", "words"),
    [
        (0.5, H, "the host steps from t = 0.5 s, the FMU is at 0.02 s; restore a state"),
        (math.nan, H, "the host steps from t = nan s"),
        (0.02, 0.0, "communication step 0 s is not positive"),
        (0.02, -0.01, "communication step -0.01 s is not positive"),
        (0.02, math.nan, "communication step nan s is not positive"),
        (0.02, math.inf, "communication step inf s is not positive"),
    ],
)
def test_bad_steps_are_refused_and_a_state_restored_goes_on(host: Host, t: float, h: float, words: str) -> None:
    host.start()
    host.run(0, 2)
    state = host.state()
    assert words in host.step(t, h)
    host.restore(state)
    host.free(state)
    assert len(host.run(2, 4)) == 2


def test_refusal_by_the_rope_reaches_the_host(host: Host) -> None:
    host.start()
    host.set(**{"left.vy": 1e3})
    assert "left.vy = 1000 is beyond +-60" in host.step(0.0)
    assert host.get("left.fy")[0] == pytest.approx(-15.0 * 8.0 * 9.81)  # of the last good state


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"rope.EI": -1.0}, "initialisation: rope: EI = -1 is out of range: it must be > 0"),
        ({"layout.spacing": 500.0}, "longer rope"),
    ],
)
def test_failed_initialisation_is_an_error(host: Host, parameters: Any, words: str) -> None:
    with pytest.raises(FMICallException):
        host.start(**parameters)
    assert words in host.error()
    assert words in host.get("status.message")[0]
    with pytest.raises(FMICallException):
        host.get("left.fy")
    assert words in host.step(0.0)
    host.fmu.reset()
    host.start()
    assert host.step(0.0) == ""


def test_choice_that_there_is_not_is_refused_with_the_choices(host: Host) -> None:
    with pytest.raises(FMICallException):
        host.set(**{"left.swivel.mode": 7})
    assert "left.swivel.mode = 7 is none of the choices: 0 locked, 1 free, 2 coulomb" in host.error()


def test_steps_beyond_the_announced_stop_are_refused(host: Host) -> None:
    host.enter(stop=0.02)
    host.fmu.exitInitializationMode()
    assert [host.step(0.0), host.step(0.01)] == ["", ""]
    assert "beyond the stop time 0.02 s" in host.step(0.02)


def test_unknown_reference_and_wrong_type_are_refused(host: Host) -> None:
    host.start()
    real = "GetReal" if host.fmi == 2 else "GetFloat64"
    more = () if host.fmi == 2 else (ctypes.c_size_t(1),)
    for reference in (99999, 0xFFFFFFFF, host.variables["status.valid"].valueReference):
        arguments = ((ctypes.c_uint * 1)(reference), ctypes.c_size_t(1), (ctypes.c_double * 1)(), *more)
        assert host.call(real, *arguments) == 3
        assert f"value reference {reference}" in host.error()
    assert host.step(0.0) == ""  # a question that has no answer harms nothing


def test_null_pointers_are_errors(host: Host) -> None:
    host.start()
    one, nothing = ctypes.c_size_t(1), ctypes.c_void_p()
    reference, value = (ctypes.c_uint * 1)(0), (ctypes.c_double * 1)()
    state = "state" if host.fmi == 2 else "State"
    get, put = ("GetReal", "SetReal") if host.fmi == 2 else ("GetFloat64", "SetFloat64")
    more = () if host.fmi == 2 else (one,)
    calls: list[tuple[Any, ...]] = [
        (get, nothing, one, value, *more),
        (get, reference, one, nothing, *more),
        (put, reference, one, nothing, *more),
        (f"GetFMU{state}", nothing),
        (f"SetFMU{state}", nothing),
        (f"SerializedFMU{state}Size", nothing, nothing),
        (f"SerializeFMU{state}", nothing, nothing, one),
        (f"DeSerializeFMU{state}" if host.fmi == 2 else f"DeserializeFMU{state}", nothing, one, nothing),
        ("SetDebugLogging", ctypes.c_int(1), one, nothing),
    ]
    for call in calls:
        assert host.call(*call) == 3, call[0]
        assert "pointer is NULL" in host.error(), call[0]
    assert host.step(0.0) == ""
    host.instance, kept = None, host.instance
    for call in (*calls, ("Reset",), ("Terminate",), ("EnterInitializationMode",)):
        if call[0] != "EnterInitializationMode" or host.fmi == 2:
            assert host.call(*call) == 3
    host.instance = kept


def test_instance_with_a_wrong_token_is_refused(fmi: int, fmus: dict[int, Path], folders: dict[int, str]) -> None:
    with pytest.raises(Exception, match="instantiate"):
        Host(fmus[fmi], folders[fmi], token="{0}")


#: call -> modes in which it is legal, of the modes below
LEGAL = {
    "EnterInitializationMode": {"instantiated"},
    "ExitInitializationMode": {"initialization"},
    "DoStep": {"stepping"},
    "Terminate": {"stepping"},
    "Set": {"instantiated", "initialization", "stepping"},
    "Get": {"instantiated", "initialization", "stepping", "terminated", "failed"},
    "Reset": {"instantiated", "initialization", "stepping", "terminated", "failed"},
}


def bring_to(host: Host, mode: str) -> None:
    if mode != "instantiated":
        host.enter()
    if mode in ("stepping", "terminated", "failed"):
        host.fmu.exitInitializationMode()
    if mode == "terminated":
        host.fmu.terminate()
    if mode == "failed":
        host.step(1.0)


@pytest.mark.parametrize("mode", ["instantiated", "initialization", "stepping", "terminated", "failed"])
@pytest.mark.parametrize("name", list(LEGAL))
def test_calls_are_legal_in_the_modes_of_the_standard(host: Host, name: str, mode: str) -> None:
    bring_to(host, mode)
    calls = {
        "EnterInitializationMode": host.enter,
        "ExitInitializationMode": host.fmu.exitInitializationMode,
        "DoStep": lambda: host.fmu.doStep(0.0, H),
        "Terminate": host.fmu.terminate,
        "Set": lambda: host.set(**{"left.y": 0.0}),
        "Get": lambda: host.get("rope.length"),
        "Reset": host.fmu.reset,
    }
    if mode in LEGAL[name]:
        calls[name]()
        return
    with pytest.raises(FMICallException):
        calls[name]()
    assert "is not allowed" in host.error()


def test_what_the_flags_rule_out_is_an_error_with_a_message(host: Host) -> None:
    host.start()
    arguments = [ctypes.c_size_t(0)] * 8
    names = {
        2: ["SetRealInputDerivatives", "GetRealOutputDerivatives", "CancelStep", "EnterEventMode", "GetDerivatives"],
        3: [
            "EnterEventMode",
            "EnterStepMode",
            "GetAdjointDerivative",
            "GetOutputDerivatives",
            "EnterConfigurationMode",
        ],
    }
    for name in names[host.fmi]:
        heard = len(host.log)
        assert host.call(name, *arguments) == 3
        assert len(host.log) == heard + 1
    assert host.step(0.0) == ""


NUMBERS = st.one_of(st.floats(width=64), st.sampled_from([0.0, H, 2 * H, 90.0, 1e308, -1.0]))
REFERENCES = st.one_of(st.integers(0, 400), st.sampled_from([2**31, 2**32 - 1]))
CALLS = st.lists(
    st.tuples(st.sampled_from(["enter", "exit", "step", "terminate", "reset", "set", "get", "save", "restore"]))
    | st.tuples(st.just("set"), REFERENCES, NUMBERS)
    | st.tuples(st.just("step"), NUMBERS, NUMBERS)
    | st.tuples(st.just("derivative"), REFERENCES, REFERENCES, NUMBERS),
    max_size=30,
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(calls=CALLS)
def test_no_sequence_of_calls_does_harm(fmus: dict[int, Path], folders: dict[int, str], calls: list[Any]) -> None:
    for fmi in VERSIONS:
        host = Host(fmus[fmi], folders[fmi])
        states: list[Any] = []
        put = host.fmu.setReal if fmi == 2 else host.fmu.setFloat64
        derivative = host.fmu.getDirectionalDerivative
        actions: dict[str, Any] = {
            "enter": host.enter,
            "exit": host.fmu.exitInitializationMode,
            "terminate": host.fmu.terminate,
            "reset": host.fmu.reset,
            "get": partial(host.get, "left.fy", "status.message"),
            "set": lambda reference=47, value=0.0, put=put: put([reference], [value]),
            "step": lambda t=0.0, h=H, fmu=host.fmu: fmu.doStep(t, h),
            "derivative": lambda unknown, known, seed, of=derivative: of([unknown], [known], [seed]),
            "save": lambda states=states, host=host: states.append(host.state()),
            "restore": lambda states=states, host=host: [host.restore(state) for state in states[-1:]],
        }
        for name, *arguments in calls:
            try:
                actions[name](*arguments)
            except FMICallException:
                assert host.error()
        for state in states:
            host.free(state)
        host.fmu.reset()
        host.start(inputs_at_step_end=True)
        assert len(host.run(0, 2)) == 2
        host.call("FreeInstance")


# states


def test_restored_state_goes_on_to_the_bit(host: Host) -> None:
    host.start(inputs_at_step_end=True)
    host.run(0, 5)
    state = host.state()
    first = host.run(5, 10)
    host.restore(state)
    host.free(state)
    assert host.run(5, 10) == first


def test_serialized_state_goes_on_in_another_instance_with_other_parameters(
    host: Host, fmi: int, fmus: dict[int, Path], folders: dict[int, str]
) -> None:
    host.start(inputs_at_step_end=True, rope__mass_per_length=16.0, mesh__kind=1, mesh__elements=60)
    host.run(0, 5)
    state = host.state()
    data = host.serialize(state)
    assert host.serialize(state) == data
    host.free(state)
    expected = host.run(5, 8)
    other = Host(fmus[fmi], folders[fmi])
    taken = other.deserialize(data)  # without any initialisation
    other.restore(taken)
    other.free(taken)
    assert other.get("rope.mass_per_length") == [16.0]
    assert other.run(5, 8) == expected
    other.call("FreeInstance")


def test_state_keeps_the_mode(host: Host) -> None:
    before = host.state()
    host.start()
    running = host.state()
    host.fmu.terminate()
    host.restore(running)
    assert host.step(0.0) == ""
    host.restore(before)
    host.start()
    assert host.step(0.0) == ""
    host.free(before)
    host.free(running)


def test_damaged_state_is_refused_and_changes_nothing(host: Host) -> None:
    host.start(inputs_at_step_end=True)
    host.run(0, 3)
    state = host.state()
    data = host.serialize(state)
    host.free(state)
    damaged = [b"", b"x", data[:-1], data + b"\0", data[: len(data) // 2]]
    places = np.linspace(0, len(data) - 1, 200).astype(int)
    damaged += [data[:i] + bytes([data[i] ^ 1]) + data[i + 1 :] for i in places]
    for bad in damaged:
        with pytest.raises(FMICallException):
            host.deserialize(bad)
        assert "state" in host.error()
    assert len(host.run(3, 5)) == 2


def test_instances_do_not_know_of_each_other(fmi: int, fmus: dict[int, Path], folders: dict[int, str]) -> None:
    hosts = [Host(fmus[fmi], folders[fmi]) for _ in range(3)]
    for i, host in enumerate(hosts):
        host.start(inputs_at_step_end=True, rope__mass_per_length=8.0 + i)
    records: list[list[Any]] = [[], [], []]
    for k in range(5):
        for record, host in zip(records, hosts, strict=True):
            record += host.run(k, k + 1)
    alone = Host(fmus[fmi], folders[fmi])
    alone.start(inputs_at_step_end=True, rope__mass_per_length=9.0)
    assert alone.run(0, 5) == records[1]
    for host in (*hosts, alone):
        host.call("FreeInstance")


# memory


#: platform -> what runs its programs here
RUNNERS = {
    host_platform(): (),
    "valgrind": ("valgrind", "--quiet", "--leak-check=full", "--error-exitcode=99"),
    "aarch64-linux": ("qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu"),
    "x86_64-windows": ("wine",),
}


def live(fmu: Path, folder: Path, way: str) -> list[int]:
    """Allocations while stepping, in each of the lives of tests/native/life_cycle.c, run in one of RUNNERS."""
    runner = RUNNERS[way]
    if runner and shutil.which(runner[0]) is None:
        pytest.skip(f"needs {runner[0]}")
    name = host_platform() if way == "valgrind" else way
    compiler = ["cc"]
    if name != host_platform():
        compiler = [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS[name].target.replace("2.17", "2.31")]
    elif not name.endswith("linux") or shutil.which("cc") is None:
        pytest.skip("needs Linux and a C compiler")
    unzipped, program = Path(fmpy.extract(str(fmu), str(folder))), folder / "life.exe"
    source = str(ROOT / "tests" / "native" / "life_cycle.c")
    libraries = ["-lm"] if name.endswith("windows") else ["-ldl", "-lm"]
    subprocess.run(
        [*compiler, "-std=gnu99", f"-I{unzipped / 'sources'}", source, "-o", str(program), *libraries], check=True
    )
    binary = unzipped / "binaries" / PLATFORMS[name].folder2 / f"BalanceRope{PLATFORMS[name].suffix}"
    command = [*runner, str(program), str(binary), fmpy.read_model_description(str(fmu)).guid]
    environment = {**os.environ, "WINEDEBUG": "-all", "WINEPREFIX": str(folder / "wine")}
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False, env=environment)
    assert done.returncode == 0, done.stderr[-3000:]
    return [int(line) for line in done.stdout.split()]


@pytest.mark.parametrize("way", [host_platform(), "valgrind"])
def test_no_memory_is_taken_while_stepping_and_all_is_given_back(
    fmus: dict[int, Path], tmp_path: Path, way: str
) -> None:
    assert live(fmus[2], tmp_path, way) == [0, 0]


# command line


def test_command_line_lists_what_it_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("fmu_src.native.export.rope_sources", stand_in)
    arguments = ["export", "--native", "--fmi", "2", "3", "--platform", host_platform(), "--out", str(tmp_path)]
    assert main(arguments) == 0
    rows = capsys.readouterr().out.splitlines()[1:]
    assert [row.split()[1:4] for row in rows] == [["native", f"{fmi}.0", host_platform()] for fmi in VERSIONS]
    assert all(Path(row.split()[0]).exists() for row in rows)


def test_python_flavour_of_fmi_3_is_refused_with_the_cure(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "--fmi", "3"]) == 2
    assert "comes with --native" in capsys.readouterr().err


def test_an_installed_case_is_exported_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fmu_src.native.export.rope_sources", stand_in)
    path = tmp_path / "monopol.fmu"
    options = ["--case", "monopol-1000", "--level", "draft", "--native", "--platform", "host", "--out", str(path)]
    assert main(["export", *options]) == 0
    starts = {v.name: v.start for v in fmpy.read_model_description(str(path)).modelVariables}
    assert [float(starts[name]) for name in ("rope.length", "right.y")] == [1040.0, 1000.0]
    assert math.isclose(float(starts["rope.EI"]), 300.0 * (14.25 / 8.0) ** 2)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--outputs", "loop"], {"loop.x", "left.fy", "status.valid"}),
        (["--outputs", "all"], {"shape.x", "mesh.counts", "energy.total", "left.fy"}),
        (["--outputs", "all", "--scalar"], {"shape.x[81]", "mesh.counts[5]", "energy.total", "left.fy"}),
    ],
)
def test_outputs_and_their_form_are_chosen_on_the_command_line(
    options: list[str], named: set[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fmu_src.native.export.rope_sources", stand_in)
    path = tmp_path / "rope.fmu"
    assert main(["export", "--native", "--fmi", "3", "--platform", "host", "--out", str(path), *options]) == 0
    host = Host(path, fmpy.extract(str(path), str(tmp_path / "unzipped")))
    known = {"shape.x", "shape.x[81]", "mesh.counts[5]", "energy.total", "loop.x", "left.fy", "status.valid"}
    assert known & set(host.variables) >= named - {"mesh.counts"}
    assert ("energy.total" in host.variables) == ("energy.total" in named)
    assert ("shape.x" in host.variables) == ("shape.x" in named)
    host.start()
    host.run(0, 2)
    for name in named:
        value = host.get(name)[0]
        assert len(value) == host.variables[name].dimensions[0].start if isinstance(value, list) else True
    host.call("FreeInstance")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--native", "--fmi", "2", "3", "--out", "x.fmu"], "give a folder"),
        (["--out", "file/x.fmu"], "file cannot be written to"),
        (["--out", "x.txt"], "--out x.txt must end in .fmu or be a folder that is there: give x.fmu"),
        (["--native", "--scalar"], "add --native --fmi 3"),
    ],
)
def test_an_export_that_cannot_be_meant_is_refused_before_anything_is_built(
    options: list[str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    assert main(["export", *options]) == 2
    assert words in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_a_folder_that_is_there_takes_the_fmu_under_its_own_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fmu_src.native.export.rope_sources", stand_in)
    assert main(["export", "--native", "--platform", "host", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "balance_rope_native.fmu").is_file()


def test_compilation_is_announced_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("BALANCE_ROPE_CACHE", str(tmp_path))
    monkeypatch.setattr("fmu_src.native.export.rope_sources", stand_in)
    announced = [f"compiling BalanceRope for {host_platform()}, FMI {fmi}.0, some 10 s" for fmi in (2, 3)]
    for expected in (announced, []):
        caplog.clear()
        assert main(["export", "--native", "--fmi", "2", "3", "--platform", "host", "--out", str(tmp_path)]) == 0
        lines = [r.getMessage() for r in caplog.records]
        assert [line for line in lines if line.startswith("compiling BalanceRope")] == expected


def test_verbose_is_understood_on_either_side_of_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[bool] = []
    monkeypatch.setattr("balance_rope._export", lambda options: told.append(options.verbose) or 0)
    for arguments in (["-v", "export"], ["export", "-v"], ["export"]):
        assert main(arguments) == 0
    assert told == [True, True, False]


def test_log_categories_are_those_of_the_description(host: Host, fmi: int) -> None:
    names = [category.name for category in host.description.logCategories]
    assert "logStatusWarning" in names
    for name in names:
        given = (ctypes.c_char_p * 1)(name.encode())
        boolean: Any = ctypes.c_int(1) if fmi == 2 else ctypes.c_bool(True)
        assert host.call("SetDebugLogging", boolean, ctypes.c_size_t(1), given) == 0, name
