"""What calls of the native FMU take and refuse, and how it goes on, on a stand-in for the rope."""

import ctypes
import math
import re
import shutil
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from fmpy.fmi2 import defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from native_host import ERROR, OK, H, Host, reseal
from shared import Unpacked

from fmu_src.shell.sources import HEADERS

SHELL = HEADERS.parent


class Names(NamedTuple):
    """Parts of the names of functions that differ between versions of FMI."""

    get: str
    put: str
    state: str
    deserialize: str


NAMES = {
    2: Names("GetReal", "SetReal", "FMUstate", "DeSerializeFMUstate"),
    3: Names("GetFloat64", "SetFloat64", "FMUState", "DeserializeFMUState"),
}


def test_a_read_that_fails_is_said_once(host: Host) -> None:
    host.enter()
    assert host.put("rope.length", -1.0) == OK
    outputs = [
        v.valueReference for v in host.variables.values() if v.name.startswith(("left.f", "loop."))
    ]
    number = len(outputs)
    before = len(host.said)
    size = ctypes.c_size_t(number)
    arguments = [(ctypes.c_uint * number)(*outputs), size, (ctypes.c_double * number)()]
    if host.fmi == 3:
        arguments.append(size)
    assert host.call(NAMES[host.fmi].get, *arguments) == ERROR
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
def test_bad_values_are_refused_and_the_fmu_is_usable_after_reset(
    host: Host, values: Any, words: str
) -> None:
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
    one = ctypes.c_size_t(1)
    nothing = ctypes.c_void_p()
    reference = (ctypes.c_uint * 1)(0)
    value = (ctypes.c_double * 1)()
    names = NAMES[host.fmi]
    more = (one,)
    if host.fmi == 2:
        more = ()
    calls: list[tuple[Any, ...]] = [
        (names.get, nothing, one, value, *more),
        (names.get, reference, one, nothing, *more),
        (names.put, reference, one, nothing, *more),
        (f"Get{names.state}", nothing),
        (f"Set{names.state}", nothing),
        (f"Serialized{names.state}Size", nothing, nothing),
        (f"Serialize{names.state}", nothing, nothing, one),
        (names.deserialize, nothing, one, nothing),
        ("SetDebugLogging", ctypes.c_int(1), one, nothing),
    ]
    for call in calls:
        assert host.call(*call) == 3, call[0]
        assert "pointer is NULL" in host.said[-1], call[0]
    assert host.step(0.0) == ""
    kept = host.instance
    host.instance = None
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
    said = [*host.log]
    status = host.get("status.message")
    host.call("Terminate")
    assert host.log == said
    assert "left.y = nan is not finite" in said[-1][1]
    assert host.get("status.message") == status


def test_a_state_that_is_none_is_refused_and_not_followed(host: Host) -> None:
    host.start()
    state = NAMES[host.fmi].state
    # what a tool hands in by mistake: zeros, the address of an empty pointer, a state that was freed before
    mistakes = [ctypes.create_string_buffer(4096), ctypes.create_string_buffer(b"\1" * 4096)]
    size = ctypes.c_size_t()
    data = ctypes.create_string_buffer(16)
    for mistake in mistakes:
        pointer = ctypes.c_void_p(ctypes.addressof(mistake))
        calls: list[tuple[Any, ...]] = [
            (f"Get{state}", ctypes.byref(pointer)),
            (f"Set{state}", pointer),
            (f"Serialized{state}Size", pointer, ctypes.byref(size)),
            (f"Serialize{state}", pointer, data, ctypes.c_size_t(16)),
            (f"Free{state}", ctypes.byref(pointer)),
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
    height = 90.0
    if not at_step_end:
        height -= 0.2 + 0.005
    assert host.get("left.fy")[0] == pytest.approx(-0.5 * (120.0 - height) * 8.0 * 9.81)


def test_input_derivatives_of_fmi_2_stand_for_speed_and_acceleration_that_are_not_set(
    host: Host,
) -> None:
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
    assert host.get("left.fy")[0] == pytest.approx(
        -0.5 * (120.0 - 90.0 + 0.3 + 0.0075) * 8.0 * 9.81
    )
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


def test_tolerance_that_is_not_the_models_own_is_told_in_the_log(host: Host) -> None:
    """The model's accuracy is a parameter; a host's tolerance, whatever it means there, does not change it."""
    (own,) = host.get("accuracy.end_force")
    for tolerance, told in ((own, False), (0.1 * own, True)):
        before = len(host.log)
        numbers = ctypes.c_double(tolerance), ctypes.c_double(0.0)
        stop = 0, ctypes.c_double(0.0)
        if host.fmi == 2:
            assert host.call("SetupExperiment", 1, *numbers, *stop) == OK
            assert host.call("EnterInitializationMode") == OK
        else:
            assert host.call("EnterInitializationMode", True, *numbers, *stop) == OK
        said = [message for _, message in host.log[before:] if "tolerance" in message]
        assert bool(said) == told
        assert all(f"is not used: accuracy.end_force = {own:g}" in message for message in said)
        host.call("Reset")


def test_times_that_lose_digits_are_warned_of_once(host: Host) -> None:
    """Numbers near 1.7e9 s, seconds of a calendar, are 2e-7 s apart."""
    for start, told in ((0.0, 0), (4e6, 0), (1.7e9, 1)):
        host.call("Reset")
        before = len(host.log)
        numbers = ctypes.c_double(0.0), ctypes.c_double(start), 0, ctypes.c_double(0.0)
        if host.fmi == 2:
            assert host.call("SetupExperiment", 0, *numbers) == OK
            assert host.call("EnterInitializationMode") == OK
        else:
            assert host.call("EnterInitializationMode", False, *numbers) == OK
        assert host.call("ExitInitializationMode") == OK
        for k in range(3):
            assert host.step(start + k * H) == ""
        said = [
            (status, message) for status, message in host.log[before:] if "lose digits" in message
        ]
        assert len(said) == told
        assert all(status == 1 and "up to 4.5e+06 s" in message for status, message in said)
    host.call("Reset")


def test_numbers_in_messages_are_the_shortest_that_read_back(host: Host) -> None:
    """Below a power of two the nearest short text belongs to another number."""
    host.start()
    assert "communication step -5.684341886080802e-14 s is" in host.step(0.0, -(2.0**-44))
    host.call("Reset")
    host.start()
    assert "communication step -1 s is" in host.step(0.0, -1.0)
    host.call("Reset")


def test_a_state_with_an_integer_of_more_than_32_bits_is_refused(host: Host) -> None:
    host.start(mesh__elements=12345)
    data = bytearray(host.write(host.state()))
    place = data.index(struct.pack("<d", 12345.0))
    data[place : place + 8] = struct.pack("<d", 2.0**31)
    assert host.read(reseal(bytes(data)), ctypes.c_void_p()) == ERROR
    assert "mesh.elements = 2147483648 is out of range" in host.said[-1]
    host.call("Reset")


def test_accelerations_follow_where_only_first_derivatives_are_given(host: Host) -> None:
    """The cubic through places and speeds of two steps has the acceleration of a motion of third degree."""
    if host.fmi == 3:
        pytest.skip("FMI 3.0 has no input derivatives")
    host.start(inputs_at_step_end=0)
    y = ctypes.c_uint(host.variables["right.y"].valueReference)
    for k in range(4):
        t = k * H
        host.set(**{"right.y": 90.0 - t**3})
        speed = ctypes.byref(ctypes.c_double(-3.0 * t**2))
        arguments = ctypes.byref(y), ctypes.c_size_t(1), ctypes.byref(ctypes.c_int(1)), speed
        assert host.call("SetRealInputDerivatives", *arguments) == OK
        if k == 2:
            data = host.write(state := host.state())
            host.forget(state)
        assert host.step(t) == ""
        # differences of places of 90 m, rounded to 1e-14 m, over H^2; 0 at the start, where t is 0
        assert host.get("right.ay") == [pytest.approx(-6.0 * t, abs=1e-8)]
    host.go_on_from(data)
    assert host.step(2 * H) == ""
    assert host.get("right.ay") == [pytest.approx(-12.0 * H, abs=1e-8)]
    host.set(**{"right.ay": -0.5})  # which the host gives itself
    assert host.step(3 * H) == ""
    assert host.get("right.ay") == [-0.5]


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_builds_that_take_no_notice_of_nan_are_refused() -> None:
    path = SHELL / "model.h"
    for flags, words in (
        ([], ""),
        (["-ffast-math"], "compile without -Ofast"),
        (["-ffinite-math-only"], "NaN"),
    ):
        command = ["cc", "-std=c99", "-fsyntax-only", *flags, "-x", "c", str(path)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert (done.returncode != 0) == bool(words)
        assert words in done.stderr


COMMA = """\
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* snprintf in a locale whose decimal separator has two bytes */
int with_comma(char *to, size_t size, const char *format, ...) {
    va_list arguments;
    char text[2000], *point;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (strchr(format, 'g') && (point = strchr(text, '.')))
        return snprintf(to, size, "%.*s\\xd9\\xab%s", (int)(point - text), text, point + 1);
    return snprintf(to, size, "%s", text);
}
"""


@pytest.mark.skipif(
    not sys.platform.startswith("linux") or shutil.which("cc") is None, reason="needs cc on Linux"
)
def test_messages_have_a_decimal_point_in_every_locale_and_names_whole_characters(
    unpacked: Unpacked, tmp_path: Path
) -> None:
    fmu, folder = unpacked("stand-in-2")
    shutil.copytree(folder, tmp_path / "fmu")
    binary = next((tmp_path / "fmu" / "binaries").rglob("*.so"))
    (tmp_path / "comma.c").write_text(COMMA)
    files = [str(path) for path in sorted((tmp_path / "fmu" / "sources").glob("*.c"))]
    options = [
        "-std=gnu99",
        "-O0",
        "-fPIC",
        "-w",
        f"-I{HEADERS}",
        "-DFMI2_OVERRIDE_FUNCTION_PREFIX",
    ]
    objects = str(tmp_path / "comma.o")
    subprocess.run(["cc", *options, "-c", str(tmp_path / "comma.c"), "-o", objects], check=True)
    command = [
        "cc",
        *options,
        "-Dsnprintf=with_comma",
        "-shared",
        "-o",
        str(binary),
        *files,
        objects,
        "-lm",
    ]
    subprocess.run(command, check=True)
    host = Host(fmu, str(tmp_path / "fmu"))
    host.start()
    assert "t = 7.5 s" in host.step(7.5)
    assert host.said[-1].isascii()
    host.free()
    names: list[bytes] = []
    heard = fmi2CallbackLoggerTYPE(lambda _, name, *told: names.append(name))
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = heard
    callbacks.allocateMemory = defaultCallbacks.allocateMemory
    callbacks.freeMemory = defaultCallbacks.freeMemory
    token = host.description.guid.encode()
    instance = host.dll.fmi2Instantiate(
        ("x" + "ü" * 100).encode(), 1, token, b"", ctypes.byref(callbacks), 0, 1
    )
    assert (
        host.dll.fmi2DoStep(
            ctypes.c_void_p(instance), ctypes.c_double(0.0), ctypes.c_double(1.0), 0
        )
        == ERROR
    )
    host.dll.fmi2FreeInstance(ctypes.c_void_p(instance))
    assert names == [("x" + "ü" * 63).encode()]


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_search_finds_each_function_of_the_standard_where_it_is_defined(fmi: int) -> None:
    header = (HEADERS / f"fmi{fmi}Functions.h").read_text(encoding="utf-8")
    declared = set(re.findall(rf"^ *FMI{fmi}_Export \w+ +(fmi\w+);", header, re.MULTILINE))
    text = (SHELL / f"fmi{fmi}.c").read_text(encoding="utf-8")
    assert len(declared) > 40
    assert {name for name in declared if not re.search(rf"\b{name}[(,]", text)} == set()
