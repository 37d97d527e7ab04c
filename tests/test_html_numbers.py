"""What the HTML reports are made of: packed numbers, pictures, events, parameters with their units, the best run."""

import base64
import math
from types import SimpleNamespace

import numpy as np
import pytest

from hoist_demo.parameters import Winding
from hoist_demo.recording.time_series import Recording
from hoist_demo.report import panels
from hoist_demo.report.html import packing


def unpack(packed: dict) -> np.ndarray:
    raw = base64.b64decode(packed["data"])
    if packed["kind"] == "f32":
        return np.frombuffer(raw, "<f4").astype(float)
    codes = np.frombuffer(raw, {"u8": "<u1", "u16": "<u2"}[packed["kind"]]).astype(float)
    top = packing.CODES[packed["kind"]]
    return np.where(codes > top, math.nan, packed["lo"] + (packed["hi"] - packed["lo"]) * codes / top)


@pytest.mark.parametrize("kind", ["u8", "u16"])
def test_packing_errs_by_half_a_quantum_at_most_and_keeps_what_is_missing(kind: str) -> None:
    values = np.random.default_rng(1).normal(3.0, 40.0, 500)
    values[[7, 100]] = math.nan, math.inf
    there = np.isfinite(values)
    back = unpack(packing.pack(values, kind))
    assert np.isnan(back[~there]).all()
    # 1e-9: rounding of the few operations themselves
    allowed = np.ptp(values[there]) / packing.CODES[kind] / 2.0 * (1.0 + 1e-9)
    assert np.max(np.abs(back[there] - values[there])) <= allowed


def test_numbers_that_16_bits_do_not_resolve_are_packed_as_floats() -> None:
    assert packing.pack_to(np.linspace(0.0, 100.0, 9), 1e-2)["kind"] == "u16"
    assert packing.pack_to(np.linspace(0.0, 100.0, 9), 1e-4)["kind"] == "f32"


def test_thinning_keeps_a_peak_of_one_row_near_its_instant() -> None:
    t = np.linspace(0.0, 10.0, 5001)
    values = np.zeros(5001)
    values[3217] = 5.0
    thin, times = packing.thin(values, 400), packing.thin_times(t, 400)
    assert len(thin) == len(times) <= 400
    # two points per interval: at most an interval away
    assert abs(times[np.argmax(thin)] - t[3217]) < packing.interval(5001, 400) * 0.002
    assert np.max(thin) == 5.0
    assert np.all(np.diff(times) > 0.0)


@pytest.mark.parametrize(("count", "most"), [(1, 5), (2, 5), (5, 5), (6, 5), (1000, 7)])
def test_frames_hold_the_first_and_the_last_row(count: int, most: int) -> None:
    rows = packing.frames(count, most)
    assert (rows[0], rows[-1]) == (0, count - 1)
    assert len(rows) <= most


def test_each_part_of_the_length_shows_the_largest_value_in_it() -> None:
    # a peak of one point, 0.1 m wide, in parts of 1 m; the rope moves on by 40 m between the frames
    place = np.linspace(0.0, packing.ROPE_ROWS, 10 * packing.ROPE_ROWS + 1)
    values = np.zeros((2, place.size))
    values[0, 404] = values[1, 804] = 7.0
    picture = packing.over_length(values, [place, place], float(packing.ROPE_ROWS))
    assert picture[40, 0] == picture[80, 1] == 7.0
    assert np.count_nonzero(picture) == 2


def test_a_value_between_two_far_points_is_on_the_line_between_them() -> None:
    picture = packing.over_length(np.array([[2.0, 10.0]]), [np.array([0.0, 50.0])], 50.0)
    upper_ends = 2.0 + 8.0 * np.arange(1, packing.ROPE_ROWS + 1) / packing.ROPE_ROWS
    np.testing.assert_allclose(picture[:, 0], upper_ends, rtol=1e-12)


def curved_rope(**along_it: list[float]) -> Recording:
    """Two instants of a rope of three points on a line, 4 m long, with what is known at them."""
    points = {"x": [0.0, 1.0, 4.0], "y": [0.0] * 3, "z": [0.0] * 3} | along_it
    signals = {f"shape.{name}[{i + 1}]": np.full(2, row[i]) for name, row in points.items() for i in range(3)}
    return Recording({"time": np.array([0.0, 1.0])} | signals, {})


def test_quantities_along_the_rope_are_shown_in_their_units_over_its_length() -> None:
    shown = packing.along(curved_rope(bending=[0.0, 3e7, 0.0], torsion=[2e6, 2e6, 2e6], tension=[-1e3, 0.0, 9e3]))
    assert (shown["length"], shown["note"]) == (4.0, "")
    kept = {m["id"]: (m["unit"], m["values"]["hi"], m["quiet"]) for m in shown["maps"]}
    expected = {"bending": ("MPa", 30.0, False), "torsion": ("MPa", 2.0, True), "tension": ("kN", 9.0, False)}
    assert {name: (unit, pytest.approx(hi), quiet) for name, (unit, hi, quiet) in kept.items()} == expected
    rows = unpack(shown["maps"][0]["values"]).reshape(packing.ROPE_ROWS, 2)
    assert np.argmax(rows[:, 0]) in (packing.ROPE_ROWS // 4 - 1, packing.ROPE_ROWS // 4)


def recording(**signals: list[float]) -> Recording:
    named = {name.replace("__", "."): np.array(values, dtype=float) for name, values in signals.items()}
    return Recording(named, {})


def test_slips_last_until_the_swivel_sticks_again_and_transformations_are_where_their_count_grows() -> None:
    slipping, counts = [0, 1, 1, 0, 0, 1], [0, 0, 1, 1, 3, 3]
    run = recording(time=[0, 1, 2, 3, 4, 5], left__swivel__slipping=slipping, count__transformations=counts)
    assert (panels.slips(run, "left"), panels.slips(run, "right")) == ([(1.0, 3.0), (5.0, 5.0)], [])
    assert panels.transformations(run) == [2.0, 4.0]


def test_the_emergency_stop_and_the_end_of_a_stopped_run_are_marked() -> None:
    rows, trip = recording(time=[0, 5, 9]), SimpleNamespace(duration=12.0)
    run = SimpleNamespace(recording=rows, completed=False, cause="?", trajectory=trip)
    found = panels.marks(run, Winding(emergency_at=4.0))
    assert [(mark.t, mark.label) for mark in found] == [(4.0, "emergency stop"), (9.0, "run stopped")]
