"""What the HTML reports are made of: packed numbers, pictures, events, parameters with their units, the best run."""

import base64

import numpy as np
import pytest

from hoist_demo.report.html import packing


def unpack(packed: dict) -> np.ndarray:
    raw = base64.b64decode(packed["data"])
    if packed["kind"] == "f32":
        return np.frombuffer(raw, "<f4").astype(float)
    codes = np.frombuffer(raw, {"u8": "<u1", "u16": "<u2"}[packed["kind"]]).astype(float)
    top = packing.CODES[packed["kind"]]
    return np.where(codes > top, np.nan, packed["lo"] + (packed["hi"] - packed["lo"]) * codes / top)


@pytest.mark.parametrize("kind", ["u8", "u16"])
def test_packing_errs_by_half_a_quantum_at_most_and_keeps_what_is_missing(kind: str) -> None:
    values = np.random.default_rng(1).normal(3.0, 40.0, 500)
    values[[7, 100]] = np.nan, np.inf
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
