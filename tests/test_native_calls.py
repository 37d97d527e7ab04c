"""What calls of the native FMU are refused, and how it goes on, on a stand-in for the rope."""

from __future__ import annotations

import ctypes
import math
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from fmpy.fmi1 import FMICallException
from hypothesis import given, settings
from hypothesis import strategies as st
from native_host import H, Host
from stand_in import VERSIONS


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


@pytest.mark.parametrize("when", ["instantiated", "initialization", "stepping"])
def test_an_end_after_a_failure_leaves_its_message_the_last(host: Host, when: str) -> None:
    if when != "instantiated":
        host.enter()
    if when == "stepping":
        host.fmu.exitInitializationMode()
    with pytest.raises(FMICallException):
        host.set(**{"left.y": math.nan})
    said, status = [*host.log], host.get("status.message")
    host.fmu.terminate()
    assert host.log == said
    assert "left.y = nan is not finite" in said[-1][1]
    assert host.get("status.message") == status


def test_an_end_after_a_refused_question_is_quiet_too(host: Host) -> None:
    host.enter()
    host.set(**{"rope.length": -1.0})
    with pytest.raises(FMICallException):
        host.get("left.fy")
    said = [*host.log]
    host.fmu.terminate()
    assert host.log == said


def test_a_state_that_is_none_is_refused_and_not_followed(host: Host) -> None:
    host.start()
    state = "state" if host.fmi == 2 else "State"
    # what a tool hands in by mistake: zeros, the address of an empty pointer, a state that was freed before
    mistakes = [ctypes.create_string_buffer(4096), ctypes.create_string_buffer(b"\1" * 4096)]
    size, data = ctypes.c_size_t(), ctypes.create_string_buffer(16)
    for mistake in mistakes:
        pointer = ctypes.c_void_p(ctypes.addressof(mistake))
        calls: list[tuple[Any, ...]] = [
            (f"GetFMU{state}", ctypes.byref(pointer)),
            (f"SetFMU{state}", pointer),
            (f"SerializedFMU{state}Size", pointer, ctypes.byref(size)),
            (f"SerializeFMU{state}", pointer, data, ctypes.c_size_t(16)),
            (f"FreeFMU{state}", ctypes.byref(pointer)),
        ]
        for call in calls:
            assert host.call(*call) == 3, call[0]
            assert "no state of this FMU, or it was freed" in host.error()
        assert pointer.value == ctypes.addressof(mistake)
    assert host.step(0.0) == ""


def test_instance_with_a_wrong_token_is_refused(fmi: int, fmus: dict[int, Path], folders: dict[int, str]) -> None:
    with pytest.raises(Exception, match="instantiate"):
        Host(fmus[fmi], folders[fmi], token="{0}")


#: call -> modes in which it is legal, of the modes below
LEGAL = {
    "EnterInitializationMode": {"instantiated"},
    "ExitInitializationMode": {"initialization"},
    "DoStep": {"stepping"},
    "Terminate": {"stepping", "failed"},  # after a failure of no effect, so that its message stays the last
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
        2: ["GetRealOutputDerivatives", "CancelStep", "EnterEventMode", "GetDerivatives"],
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
