"""The native FMU's values, states and memory, on a stand-in for the rope (tests/native/stand_in.c)."""

import math
from pathlib import Path

import pytest
from fmpy.fmi1 import FMICallException
from native_host import Host
from stand_in import live

from fmu_src.native.build import host_platform

# values


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


# states


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


# memory


@pytest.mark.parametrize("way", [host_platform(), "valgrind"])
def test_no_memory_is_taken_while_stepping_and_all_is_given_back(
    fmus: dict[int, Path], tmp_path: Path, way: str
) -> None:
    assert live(fmus[2], tmp_path, way) == [0, 0]
