"""What the HTML reports are made of: packed numbers, events, bending, parameters with their units, the best run."""

from __future__ import annotations

import base64
import json
import math
import re
from dataclasses import dataclass, fields
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from hoist_demo import events
from hoist_demo.html import bending, given, packing, page, panels
from hoist_demo.html.study import study_report
from hoist_demo.parameters import Coupling, Hoist, Winding
from hoist_demo.recording import Recording


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


def test_a_constant_is_packed_exactly() -> None:
    assert unpack(packing.pack(np.full(3, 0.1))).tolist() == [0.1, 0.1, 0.1]


def test_numbers_that_16_bits_do_not_resolve_are_packed_as_floats() -> None:
    assert packing.pack_to(np.linspace(0.0, 100.0, 9), 1e-2)["kind"] == "u16"
    assert packing.pack_to(np.linspace(0.0, 100.0, 9), 1e-4)["kind"] == "f32"


def test_thinning_keeps_a_peak_of_one_row_near_its_instant() -> None:
    t = np.linspace(0.0, 10.0, 5001)
    values = np.zeros(5001)
    values[3217] = 5.0
    thin, times = packing.thinned(values, 400), packing.thinned_times(t, 400)
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


def test_the_curvature_of_a_circle_is_one_over_its_radius_whatever_the_distance_of_its_points() -> None:
    angle = np.sort(np.random.default_rng(2).uniform(0.0, 3.0, 40))
    circle = 2.5 * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(40)])
    # 1e-6: three points that happen to lie 1e-4 m apart lose half of the digits
    np.testing.assert_allclose(bending.curvature(circle)[1:-1], 1.0 / 2.5, rtol=1e-6)


def test_curvature_becomes_stress_only_when_it_explains_the_largest_stress() -> None:
    curvature = np.array([0.7, 0.8, 0.9])
    assert bending.stress_per_curvature(3.6e7 * curvature, curvature) == pytest.approx(3.6e7)
    assert bending.stress_per_curvature(np.array([9e7, 3e7, 3e7]), curvature) is None


def test_bending_lies_where_the_curve_is_bent() -> None:
    straight = np.column_stack([np.linspace(0.0, 4.0, 30), np.zeros(30), np.zeros(30)])
    angle = np.linspace(0.0, math.pi, 30)[1:]
    bent = np.column_stack([4.0 + np.sin(angle), 1.0 - np.cos(angle), np.zeros(29)])
    values, length = bending.curvature_map(np.array([np.vstack([straight, bent])]), 50)
    places = (np.arange(50) + 0.5) * length / 50
    assert np.max(values[places < 3.8]) < 1e-9
    np.testing.assert_allclose(values[(places > 4.3) & (places < length - 0.3)], 1.0, rtol=1e-6)


def recording(**signals: list[float]) -> Recording:
    named = {name.replace("__", "."): np.array(values, dtype=float) for name, values in signals.items()}
    return Recording(named, {})


def test_slips_last_until_the_row_in_which_the_swivel_sticks_again() -> None:
    run = recording(time=[0, 1, 2, 3, 4, 5], left__swivel__slipping=[0, 1, 1, 0, 0, 1])
    assert events.slips(run, "left") == [(1.0, 3.0), (5.0, 5.0)]
    assert events.slips(run, "right") == []


def test_transformations_are_where_their_count_grows() -> None:
    run = recording(time=[0, 1, 2, 3, 4], count__transformations=[0, 0, 1, 1, 3])
    assert events.transformations(run) == [2.0, 4.0]


def test_the_emergency_stop_and_the_end_of_a_stopped_run_are_marked() -> None:
    run = SimpleNamespace(
        recording=recording(time=[0, 5, 9]), completed=False, cause="?", reference=SimpleNamespace(duration=12.0)
    )
    found = events.marks(run, Winding(emergency_at=4.0))
    assert [(mark.t, mark.label) for mark in found] == [(4.0, "emergency stop"), (9.0, "run stopped")]


def test_panels_hold_recorded_signals_only() -> None:
    run = recording(time=[0, 1], left__fy=[-1.0, -2.0], stress__bending_max=[1e6, 2e6])
    shown = panels.panels(run, Hoist())
    assert [[line.signal for line in panel.lines] for panel in shown] == [["left.fy"], ["stress.bending_max"]]


def test_parameters_show_the_unit_that_stands_behind_them() -> None:
    rows = {name.split(",")[0]: (value, unit) for name, value, unit in given.rows(Hoist())}
    assert rows["conveyance mass"] == ("10000", "kg")
    assert rows["loss viscous"] == ("200", "N s/m")
    assert rows["friction coefficient"] == ("0.25", "")
    assert rows["payload right"] == ("0", "kg")


def test_every_parameter_has_a_unit_or_is_a_pure_number() -> None:
    for data in (Hoist(), Winding(), Coupling()):
        rows = {name.split(",")[0].replace(" ", "_"): unit for name, _, unit in given.rows(data)}
        assert set(rows) == {field.name for field in fields(data)}
        numbers = {name for name, unit in rows.items() if not unit and isinstance(getattr(data, name), (int, float))}
        assert numbers <= {
            "head_rope_number",
            "head_rope_modes",
            "tail_rope_number",
            "head_rope_damping",
            "friction_coefficient",
            "emergency_at",
        }


@dataclass(frozen=True)
class Inner:
    gap: float = 2.0  # mm, play of a guide


@dataclass(frozen=True)
class Outer:
    guide: Inner = Inner()
    on: bool = True  # -, whether it brakes


def test_parameters_of_parameters_are_shown_too() -> None:
    assert given.rows(Outer()) == [
        ("guide: gap, play of a guide", "2", "mm"),
        ("on, whether it brakes", "yes", ""),
    ]


@pytest.mark.parametrize(
    ("fmi", "shown"),
    [("N.m2", "N m²"), ("m/s3", "m/s³"), ("m/s^2", "m/s²"), ("N m", "N m"), ("1/m", "1/m"), ("1", ""), ("", "")],
)
def test_units_read_as_people_write_them(fmi: str, shown: str) -> None:
    assert page.unit_text(fmi) == shown


def study() -> pd.DataFrame:
    return pd.DataFrame(
        {
            "jerk": [0.5, 1.0, 1.5],
            "swing": [4.0, math.nan, 2.0],
            "status": ["completed", "failed", "completed"],
            "cause": ["", "overwind", None],
        }
    )


def columns(table: pd.DataFrame, meta: dict, path: Path) -> dict[str, dict]:
    text = study_report(table, {"jerk": "m/s3", "mass": "kg"}, meta, path).read_text(encoding="utf-8")
    found = re.search(r'id="data">(.*?)</script>', text, re.DOTALL)
    assert found is not None
    return {column["name"]: column for column in json.loads(found[1])["columns"]}


def test_only_what_differs_between_runs_has_an_axis_and_constants_are_data(tmp_path: Path) -> None:
    table = study().assign(run=[1, 2, 3], key=["a1", "b2", "c3"], case="", mass=7.5, limit=[1.0, 1.0, 1.0])
    path = tmp_path / "study.html"
    found = columns(table, {"parameters": ["jerk", "case", "mass"]}, path)
    assert {name for name, column in found.items() if column["axis"]} == {"jerk", "swing"}
    assert list(found) == [
        "jerk",
        "swing",
        "limit",
        "key",
    ]  # run is the page's own, a constant metric stays in the table
    text = path.read_text(encoding="utf-8")
    assert '<td>mass</td><td class="value">7.5</td><td class="unit">kg</td>' in text
    assert "Assumed data." in text


def test_a_study_of_one_run_still_shows_its_metrics(tmp_path: Path) -> None:
    found = columns(study().iloc[:1].assign(key="a1"), {"parameters": ["jerk"]}, tmp_path / "study.html")
    assert {name for name, column in found.items() if column["axis"]} == {"swing"}


def test_without_a_metric_to_judge_by_the_page_tells_how_to_name_one(tmp_path: Path) -> None:
    path = study_report(study(), {}, {}, tmp_path / "study.html")
    assert "minimise or maximise in [study]" in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(("sense", "best"), [("min", "Best run: 3"), ("max", "Best run: 1")])
def test_the_best_run_is_chosen_among_those_that_did_not_fail(tmp_path: Path, sense: str, best: str) -> None:
    table = study()
    table.loc[1, "swing"] = 1.0 if sense == "min" else 9.0  # a failed run's number does not count
    path = study_report(table, {}, {"best": {"metric": "swing", "sense": sense}}, tmp_path / "study.html")
    assert best in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("meta", "words"),
    [
        ({"parameters": ["jerc"]}, "'jerc', which is no column"),
        ({"best": {"metric": "sing", "sense": "min"}}, "'sing', which is no column"),
        ({"best": {"metric": "swing", "sense": "least"}}, "must be 'min' or 'max'"),
    ],
)
def test_a_study_whose_names_do_not_fit_is_an_error(tmp_path: Path, meta: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        study_report(study(), {}, meta, tmp_path / "study.html")
    assert not (tmp_path / "study.html").exists()


def test_the_same_study_gives_the_same_bytes(tmp_path: Path) -> None:
    first, second = (study_report(study(), {}, {}, tmp_path / name).read_bytes() for name in "ab")
    assert first == second
