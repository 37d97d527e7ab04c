"""What each place in the rope went through: counted by the standard's example, by hand, and over several trips."""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_data
from hoist_demo.recording import exposure as exposures
from hoist_demo.recording.time_series import TIME, Recording
from hoist_demo.study.run import build

WHERE = {"station.first": 0.0, "station.last": 1.0, "rope.length": 120.0}


def record(*columns: list[float]) -> Recording:
    """A record of stations with these values, one per second, of all quantities alike."""
    signals = {TIME: np.arange(float(len(columns[0])))}
    signals |= {f"station.{name}[{k + 1}]": np.array(x) for name in exposures.QUANTITIES for k, x in enumerate(columns)}
    return Recording(signals, dict.fromkeys(signals, "1"))


@cache
def winding() -> tuple[Recording, Recording]:
    """The 120 m rope wound by 90 m: what was recorded, and its table."""
    run = build("rope-120", {})
    read = {*exposures.STATION_SIGNALS, "left.fy", "right.fy", "loop.y"}
    rope = InProcessRope(rope_data(run.fmu, "draft"), read)
    recording = Host(rope, run.hoist, run.winding, run.coupling, run.gains).run().recording
    found = exposures.exposure(recording, rope.data().parameters)
    return recording, found


def test_cycles_are_those_of_the_example_of_astm_e1049() -> None:
    # figure 6 of the standard: cycles of 3 (a half), 4 (one and a half), 6 (a half), 8 (one) and 9 (a half), of which
    # those below a quarter of 9 are left out: none
    found = exposures.exposure(record([-2, 1, -3, 5, -1, 3, -4, 4, -2], [0.0] * 9), WHERE)
    assert_allclose(found["tension.range"], [9.0, 0.0])
    assert_allclose(found["tension.cycles"], [4.0, 0.0])
    extremes = [found[f"tension.{name}"][0] for name in ("least", "largest", "least_at", "largest_at")]
    assert_allclose(extremes, [-4.0, 5.0, 6.0, 3.0])
    # by bins of their range: 3 and 4 from 2 on; 6, 8 and 9 from 5 on
    binned = {name: found[name][0] for name in exposures.bin_columns("torque") if found[name][0]}
    assert binned == {"torque.from_2": 2.0, "torque.from_5": 2.0}


def test_time_in_the_bend_is_that_above_half_the_sharpest() -> None:
    found = exposures.exposure(record([0, 0.6, 1, 0.4, 0], [0, 0, 0.4, 0, 0]), WHERE)
    assert_allclose(found["bent"], [2.0, 0.0])


def test_trips_to_and_fro_add_up_to_whole_cycles() -> None:
    up, down = (exposures.exposure(record(values, [0, 0, 0]), WHERE) for values in ([0, 2, 4], [4, 2, 0]))
    assert_allclose(up["torque.cycles"], [0.5, 0.0])
    both = exposures.together([up, down, up, down])
    names = "torque.cycles", "torque.range", "s", "torque.from_2"
    assert_allclose([both[name] for name in names], [[2.0, 0.0], [4.0, 0.0], [0.0, 120.0], [2.0, 0.0]])


def test_a_vibration_in_a_trip_has_its_frequency_and_amplitude() -> None:
    t = np.arange(0.0, 40.0, 0.01)
    trip = 5000.0 * np.sin(np.pi * t / 40.0) ** 2
    columns = np.column_stack((trip + 7.0 * np.sin(2 * np.pi * 1.85 * t), trip, 0.0 * t))
    frequency, amplitude = exposures.strongest(exposures.spectra(t, columns))
    assert_allclose(frequency, [1.85, np.nan, np.nan])  # the line lies on one of the spectrum
    assert_allclose(amplitude, [7.0, 0.0, 0.0], rtol=1e-3)


def test_places_that_the_loop_passes_bend_once_in_a_winding_and_others_never() -> None:
    _, found = winding()
    # the loop's lowest point lies at (L - H) / 2 of the left end, H from 90 m to -90 m, and bends 1.5 m to either side
    s, cycles = found["s"], found["curvature.cycles"]
    assert_allclose(cycles[(s > 17.5) & (s < 102.5)], 1.0)
    assert_allclose(cycles[(s < 11.0) | (s > 109.0)], 0.0)


@pytest.mark.parametrize("station", [21, 41, 61])
def test_ranges_at_a_place_are_those_counted_by_hand(station: int) -> None:
    recording, found = winding()
    curvature, k = recording[f"station.curvature[{station}]"], station - 1
    # straight, bent once, straight again: the cycle is all that there is between its least and largest value
    assert_allclose(found["curvature.range"][k], curvature.max() - curvature.min(), rtol=1e-3)
    # the time above half the sharpest of all, sample by sample
    sharpest = max(float(recording[name].max()) for name in recording.signals if "curvature" in name)
    assert_allclose(found["bent"][k], 0.01 * np.count_nonzero(curvature > 0.5 * sharpest), rtol=1e-9)
    # the bend, of some 2.4 m above half its curvature, passes at the speed of the conveyances: more than half of 8 m/s
    assert 2.0 / 8.0 < found["bent"][k] < 3.0 / 4.0 + 0.2
