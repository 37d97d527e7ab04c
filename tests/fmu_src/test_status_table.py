"""What each call returns in each state: one table, of the Python flavour and of the native one alike."""

import ctypes
import math
import re
import shutil
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from exports import FLAVOURS
from native_host import DISCARD, ERROR, OK, SMALL, Host

STATES = ("instantiated", "initialisation", "stepping", "terminated", "failed")
H = 0.01
Fmu = tuple[Path, str]
#: announced end of the run, s
STOP = 1.0
_ONE = ctypes.c_size_t(1)
_LETTERS = {OK: "O", DISCARD: "D", ERROR: "E"}

if not FLAVOURS:
    pytest.skip("no compiler builds the FMUs here", allow_module_level=True)


class Call(NamedTuple):
    """What is called, and the status in each of STATES: O OK, E error, D discard."""

    make: Callable[[Host], int]
    statuses: str
    versions: tuple[int, ...] = (2, 3)


def bring_to(fmu: Fmu, state: str) -> Host:
    """An instance in one of STATES; "failed" by a step that goes on from another time."""
    rope = Host(*fmu)
    assert rope.give(SMALL) == OK
    if state == "instantiated":
        return rope
    assert rope.enter(stop=STOP) == OK
    if state != "initialisation":
        assert rope.call("ExitInitializationMode") == OK
        assert rope.do_step(0.0, H) == OK
    if state == "terminated":
        assert rope.call("Terminate") == OK
    if state == "failed":
        assert rope.do_step(0.5, H) == ERROR
    return rope


def enter(rope: Host) -> int:
    if rope.fmi == 2:
        return rope.call("EnterInitializationMode")
    return rope.enter()


def set_up(start: float, stop: float) -> Callable[[Host], int]:
    times = (0, ctypes.c_double(0.0), ctypes.c_double(start), 1, ctypes.c_double(stop))
    return lambda rope: rope.call("SetupExperiment", *times)


def got(name: str, reference: int | None = None) -> Callable[[Host], int]:
    return lambda rope: rope.fetch(name, reference)[0]


def put_value(name: str, value: float, **more: Any) -> Callable[[Host], int]:
    return lambda rope: rope.put(name, value, **more)


def logging(category: bytes) -> Callable[[Host], int]:
    names = (ctypes.c_char_p * 1)(category)
    return lambda rope: rope.call("SetDebugLogging", ctypes.c_int(1), _ONE, names)


def save(rope: Host) -> int:
    state = ctypes.c_void_p()
    return rope.save(state) or rope.forget(state)


def save_and_restore(rope: Host) -> int:
    state = ctypes.c_void_p()
    return rope.save(state) or rope.restore(state) or rope.forget(state)


def write_and_read(rope: Host) -> int:
    state = ctypes.c_void_p()
    read = ctypes.c_void_p()
    return rope.save(state) or rope.read(rope.write(state), read) or rope.restore(read)


def ask(name: str, kind: int) -> Callable[[Host], int]:
    """fmi2Get...Status: 0 doStep, 1 pending, 2 last successful time, 3 terminated."""
    room = ctypes.create_string_buffer(16)
    return lambda rope: rope.call(name, ctypes.c_int(kind), room)


def call_unsupported(name: str) -> Callable[[Host], int]:
    return lambda rope: rope.call(name, *[ctypes.c_size_t(0)] * 5)


def derive(unknown: str, known: str) -> Callable[[Host], int]:
    return lambda rope: rope.derive(
        *(rope.variables[name].valueReference for name in (unknown, known))
    )[0]


#: FMI 2.0.4, section 4.2.4, and FMI 3.0, section 4.2.1: what the state machines allow, and what this FMU can do
TABLE: dict[str, Call] = {
    "setupExperiment": Call(set_up(0.0, STOP), "OEEEE", (2,)),
    "setupExperiment, start NaN": Call(set_up(math.nan, STOP), "EEEEE", (2,)),
    "setupExperiment, stop before start": Call(set_up(1.0, 0.0), "EEEEE", (2,)),
    "enterInitializationMode": Call(enter, "OEEEE"),
    "exitInitializationMode": Call(lambda rope: rope.call("ExitInitializationMode"), "EOEEE"),
    "doStep": Call(lambda rope: rope.do_step(H, H), "EEOEE"),
    "doStep from another time": Call(lambda rope: rope.do_step(0.5, H), "EEEEE"),
    "doStep of no length": Call(lambda rope: rope.do_step(H, 0.0), "EEEEE"),
    "doStep of NaN": Call(lambda rope: rope.do_step(H, math.nan), "EEEEE"),
    "doStep of infinity": Call(lambda rope: rope.do_step(H, math.inf), "EEEEE"),
    "doStep backwards": Call(lambda rope: rope.do_step(H, -H), "EEEEE"),
    "doStep beyond the stop time": Call(lambda rope: rope.do_step(H, STOP), "EEEEE"),
    "terminate": Call(lambda rope: rope.call("Terminate"), "EEOEO"),
    "reset": Call(lambda rope: rope.call("Reset"), "OOOOO"),
    "get a parameter": Call(got("rope.length"), "OOOOO"),
    "get an input": Call(got("left.y"), "OOOOO"),
    "get a real output": Call(got("left.fy"), "EOOOO"),
    "get an integer output": Call(got("count.steps"), "EOOOO"),
    "get a boolean output": Call(got("left.swivel.slipping"), "EOOOO"),
    "get a text": Call(got("status.fidelity"), "EOOOO", (2,)),
    "get status.valid": Call(got("status.valid"), "OOOOO"),
    "get status.message": Call(got("status.message"), "OOOOO", (2,)),
    "get an unknown reference": Call(got("left.fy", 99999), "EEEEE"),
    "set a fixed parameter": Call(put_value("rope.EI", 400.0), "OOEEE"),
    "set a fixed parameter as it is": Call(put_value("rope.EI", 300.0), "OOOEE"),
    "set a tunable parameter": Call(put_value("solver.step_max", 0.01), "OOOEE"),
    "set a choice": Call(put_value("left.swivel.mode", 1), "OOEEE"),
    "set no choice": Call(put_value("left.swivel.mode", 7), "EEEEE"),
    "set an input": Call(put_value("left.y", 0.0), "OOOEE"),
    "set an input to NaN": Call(put_value("left.y", math.nan), "EEEEE"),
    "set an output": Call(put_value("left.fy", 0.0), "EEEEE"),
    "set a text": Call(put_value("status.message", 0.0, kind="String"), "EEEEE", (2,)),
    "set an unknown reference": Call(put_value("left.y", 0.0, reference=99999), "EEEEE"),
    "get and free a state": Call(save, "OOOOO"),
    "restore a state": Call(save_and_restore, "OOOOO"),
    "restore a serialized state": Call(write_and_read, "OOOOO"),
    "read bytes that are no state": Call(lambda rope: rope.read(b"{}", ctypes.c_void_p()), "EEEEE"),
    "setDebugLogging": Call(logging(b"logAll"), "OOOOO"),
    "setDebugLogging, unknown category": Call(logging(b"logEvents"), "EEEEE"),
    "getStatus": Call(ask("GetStatus", 0), "EDDDD", (2,)),
    "getRealStatus, last successful time": Call(ask("GetRealStatus", 2), "EOOOO", (2,)),
    "getIntegerStatus": Call(ask("GetIntegerStatus", 0), "EDDDD", (2,)),
    "getBooleanStatus, terminated": Call(ask("GetBooleanStatus", 3), "EOOOO", (2,)),
    "getStringStatus, pending": Call(ask("GetStringStatus", 1), "EDDDD", (2,)),
    "getDirectionalDerivative": Call(derive("left.fy", "left.ay"), "EOOOO"),
    "getDirectionalDerivative of another output": Call(derive("loop.x", "left.ay"), "EEEEE"),
    "getDirectionalDerivative to a parameter": Call(derive("left.fy", "rope.EI"), "EEEEE"),
    "cancelStep": Call(call_unsupported("CancelStep"), "EEEEE", (2,)),
    "setRealInputDerivatives": Call(call_unsupported("SetRealInputDerivatives"), "OOOEE", (2,)),
    "getRealOutputDerivatives": Call(call_unsupported("GetRealOutputDerivatives"), "EEEEE", (2,)),
    "enterEventMode": Call(call_unsupported("EnterEventMode"), "EEEEE"),
}


@pytest.fixture(params=sorted(FLAVOURS))
def fmu(request: pytest.FixtureRequest, unpacked: Callable[[str], Fmu]) -> Fmu:
    return unpacked(request.param)


@pytest.mark.skipif("python" not in FLAVOURS, reason="needs a C compiler")
def test_python_flavour_without_its_code_is_not_instantiated_and_says_why(
    unpacked: Callable[[str], Fmu], tmp_path: Path
) -> None:
    path, folder = unpacked("python")
    # a library of its own: the one that has instances has its code already
    shutil.copytree(Path(folder) / "binaries", tmp_path / "binaries")
    for location in (b"", b"file:///nowhere/at%20all", "file:///nowhere/Förderseil".encode() * 20):
        with pytest.raises(AssertionError, match="cannot be loaded: it needs Python 3"):
            Host(path, str(tmp_path), resources=location)


#: the C code that answers is that of both flavours, and the reference rope takes longer to hang
QUICK_WITH_PYTHON = ("instantiated", "stepping")


def case_of(kind: str, state: str) -> Any:
    if kind == "python" and state not in QUICK_WITH_PYTHON:
        return pytest.param(kind, state, marks=pytest.mark.slow)
    return pytest.param(kind, state)


EACH = [case_of(kind, state) for kind, state in product(sorted(FLAVOURS), STATES)]


@pytest.mark.parametrize(("fmu", "state"), EACH, indirect=["fmu"])
def test_each_call_returns_what_the_table_says(
    fmu: Fmu, state: str, request: pytest.FixtureRequest
) -> None:
    rope = bring_to(fmu, state)
    calls = {name: call for name, call in TABLE.items() if rope.fmi in call.versions}
    before = rope.state()
    found = {}
    for name, call in calls.items():
        found[name] = _LETTERS[call.make(rope)]
        # a state of before the first step does not lead back from a failure
        if state in STATES[:2]:
            rope.free()
            rope = bring_to(fmu, state)
        else:
            assert rope.restore(before) == OK
    rope.free()
    expected = {name: call.statuses[STATES.index(state)] for name, call in calls.items()}
    if request.node.callspec.params["fmu"] == "python":
        expected["getDirectionalDerivative"] = "E"  # this flavour offers none
    assert found == expected


@pytest.mark.parametrize(
    ("values", "statuses", "words"),
    [
        ({"rope.length": -5.0}, "OOEE", "length = -5"),
        ({"layout.spacing": 500.0}, "OOEE", "longer rope|closer together"),
        ({"left.vy": 1.0}, "OOEE", "starts from rest|must rest"),
        ({"left.y": math.nan}, "EEEE", "left.y = nan is not finite"),
        ({"rope.EI": math.inf}, "EEEE", "rope.EI = inf is out of range"),
    ],
)
def test_a_value_that_cannot_be_fails_where_it_is_met_and_reset_makes_all_good(
    fmu: Fmu, values: dict[str, float], statuses: str, words: str
) -> None:
    rope = Host(*fmu)
    ((name, value),) = values.items()
    leave = "ExitInitializationMode"
    calls = (
        lambda: rope.put(name, value),
        rope.enter,
        lambda: rope.call(leave),
        lambda: rope.do_step(0.0, H),
    )
    assert "".join(_LETTERS[call()] for call in calls) == statuses
    assert re.search(words, rope.said[0]), rope.said
    assert re.search(words, rope.said[-1])  # a step tells what failed before
    assert math.isnan(rope.real("left.fy"))
    assert rope.hang({}) == OK
    assert rope.do_step(0.0, H) == OK
    rope.free()
