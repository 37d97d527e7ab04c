"""What calls of the native FMU take and refuse, and how it goes on, on a stand-in for the rope."""

import ctypes
import math
from typing import Any

import pytest
from native_host import ERROR, OK, H, Host


def test_a_read_that_fails_is_said_once(host: Host) -> None:
    host.enter()
    assert host.put("rope.length", -1.0) == OK
    outputs = [v.valueReference for v in host.variables.values() if v.name.startswith(("left.f", "loop."))]
    number, before = len(outputs), len(host.said)
    one, more = ctypes.c_size_t(number), () if host.fmi == 2 else (ctypes.c_size_t(number),)
    arrays = (ctypes.c_uint * number)(*outputs), one, (ctypes.c_double * number)()
    assert host.call("GetReal" if host.fmi == 2 else "GetFloat64", *arrays, *more) == ERROR
    assert len(host.said) == before + 1


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
    ((name, value),) = values.items()
    host.start()
    lower(host)
    assert host.put(name, value) == ERROR
    assert words in host.said[-1]
    assert host.get("status.valid") == [False]
    assert words in host.get("status.message")[0]
    assert "is not allowed after a failure" in host.step(2 * H)
    host.call("Reset")
    host.start()
    lower(host)
    assert host.get("status.valid", "status.message") == [True, ""]


def lower(host: Host) -> None:
    """Two steps with the right end lowered by 1 m/s."""
    for k in range(2):
        host.set(**{"right.y": 90.0 - (k + 1) * H, "right.vy": -1.0})
        assert host.step(k * H) == ""


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
        assert "pointer is NULL" in host.said[-1], call[0]
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
        host.call("ExitInitializationMode")
    assert host.put("left.y", math.nan) == ERROR
    said, status = [*host.log], host.get("status.message")
    host.call("Terminate")
    assert host.log == said
    assert "left.y = nan is not finite" in said[-1][1]
    assert host.get("status.message") == status


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
            assert "no state of this FMU, or it was freed" in host.said[-1]
        assert pointer.value == ctypes.addressof(mistake)
    assert host.step(0.0) == ""


def test_instance_with_a_wrong_token_is_refused(fmi: int, unpacked: Any) -> None:
    with pytest.raises(AssertionError, match="is not that of this FMU"):
        Host(*unpacked(f"stand-in-{fmi}"), token="{0}")


@pytest.mark.parametrize("at_step_end", [True, False])
def test_inputs_are_read_at_the_end_or_extrapolated(host: Host, at_step_end: bool) -> None:
    host.start(inputs_at_step_end=at_step_end)
    host.set(**{"right.vy": -2.0, "right.ay": -1.0})
    assert host.step(0.0, 0.1) == ""
    height = 90.0 if at_step_end else 90.0 - 0.2 - 0.005
    assert host.get("left.fy")[0] == pytest.approx(-0.5 * (120.0 - height) * 8.0 * 9.81)


def test_input_derivatives_of_fmi_2_stand_for_speed_and_acceleration_that_are_not_set(host: Host) -> None:
    if host.fmi == 3:
        pytest.skip("FMI 3.0 has none")
    host.start()
    y, vy = (host.variables[f"right.{name}"].valueReference for name in ("y", "vy"))

    def give(*given: tuple[int, int, float]) -> int:
        references, orders, values = zip(*given, strict=True)
        n = len(given)
        arrays = (ctypes.c_uint * n)(*references), ctypes.c_size_t(n), (ctypes.c_int * n)(*orders)
        return host.call("SetRealInputDerivatives", *arrays, (ctypes.c_double * n)(*values))

    assert give((y, 1, -2.0), (y, 2, -1.0), (vy, 3, 7.0)) == OK
    assert host.get("right.vy", "right.ay") == [-2.0, -1.0]
    host.set(**{"right.vy": -3.0})
    assert give((y, 1, -2.0), (y, 2, -1.5)) == OK
    assert host.get("right.vy", "right.ay") == [-3.0, -1.5]
    assert host.step(0.0, 0.1) == ""
    assert host.get("left.fy")[0] == pytest.approx(-0.5 * (120.0 - 90.0 + 0.3 + 0.0075) * 8.0 * 9.81)
    for order, value in ((0, 1.0), (1, math.nan)):
        assert give((y, order, value)) == ERROR
        assert "must be of order 1 or higher, and finite" in host.said[-1]


def test_state_keeps_the_mode(host: Host) -> None:
    before = host.state()
    host.start()
    running = host.state()
    host.call("Terminate")
    host.restore(running)
    assert host.step(0.0) == ""
    host.restore(before)
    host.start()
    assert host.step(0.0) == ""
    for state in (before, running):
        host.forget(state)
