"""The native FMU's values, states and memory, on a stand-in for the rope (tests/native/stand_in.c)."""

from pathlib import Path

import pytest
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
