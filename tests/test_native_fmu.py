"""The native FMU's values, states and memory, on a stand-in for the rope (tests/native/stand_in.c)."""

from __future__ import annotations

import ctypes
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from native_host import Host
from stand_in import live

from fmu_src.native.build import host_platform

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


def test_input_derivatives_of_fmi_2_stand_for_speed_and_acceleration_that_are_not_set(host: Host) -> None:
    if host.fmi == 3:
        pytest.skip("FMI 3.0 has none")
    host.start()
    y, vy = (host.variables[f"right.{name}"].valueReference for name in ("y", "vy"))
    host.fmu.setRealInputDerivatives([y, y, vy], [1, 2, 3], [-2.0, -1.0, 7.0])
    assert host.get("right.vy", "right.ay") == [-2.0, -1.0]
    host.set(**{"right.vy": -3.0})
    host.fmu.setRealInputDerivatives([y, y], [1, 2], [-2.0, -1.5])
    assert host.get("right.vy", "right.ay") == [-3.0, -1.5]
    assert host.step(0.0, 0.1) == ""
    assert host.get("left.fy")[0] == pytest.approx(-0.5 * (120.0 - 90.0 + 0.3 + 0.0075) * 8.0 * 9.81)
    for order, value in ((0, 1.0), (1, math.nan)):
        with pytest.raises(FMICallException):
            host.fmu.setRealInputDerivatives([y], [order], [value])
        assert "must be of order 1 or higher, and finite" in host.error()


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


@pytest.mark.parametrize("way", [host_platform(), "valgrind"])
def test_no_memory_is_taken_while_stepping_and_all_is_given_back(
    fmus: dict[int, Path], tmp_path: Path, way: str
) -> None:
    assert live(fmus[2], tmp_path, way) == [0, 0]


def test_log_categories_are_those_of_the_description(host: Host, fmi: int) -> None:
    names = [category.name for category in host.description.logCategories]
    assert "logStatusWarning" in names
    for name in names:
        given = (ctypes.c_char_p * 1)(name.encode())
        boolean: Any = ctypes.c_int(1) if fmi == 2 else ctypes.c_bool(True)
        assert host.call("SetDebugLogging", boolean, ctypes.c_size_t(1), given) == 0, name
