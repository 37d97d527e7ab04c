"""Where to set a guard (evidence.guards): thresholds of made-up windings, and what a drawn one comes to."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from evidence.guards import jam
from evidence.guards.judging import EARLY, Guard, guard
from evidence.guards.page import page
from evidence.guards.scenes import SET, draw
from evidence.guards.wind import COLUMNS, QUANTITIES, judge
from evidence.rendering import DOCS
from evidence.tables import read, table

HEALTHY, FOULED = np.array([1.0, 2.0, 3.0, 4.0]), np.array([2.5, 5.0, 6.0, 7.0])


def test_thresholds_of_two_samples_are_where_they_part() -> None:
    found = Guard(HEALTHY, FOULED)
    assert (found.missed(found.highest_without_missed), found.false(found.highest_without_missed)) == (0.0, 0.5)
    assert (found.missed(found.lowest_without_false), found.false(found.lowest_without_false)) == (0.25, 0.0)
    assert found.evenly == 4.0
    # of the 16 pairs, 3.0 and 4.0 went further than 2.5
    assert_allclose(found.told_apart, 14 / 16)


def test_a_winding_is_healthy_or_fouls_and_goes_further_later() -> None:
    judged = {int(row[1]): dict(zip(COLUMNS, row, strict=True)) for row in map(judge, short())}
    assert {row["outcome"] for row in judged.values()} == {"healthy", "fouled"}
    for row in judged.values():
        assert (row["clearance, peak"] <= 0.0) == (row["outcome"] == "fouled")
        for name in QUANTITIES:
            sign = -1.0 if name == "clearance" else 1.0
            assert sign * row[f"{name}, {EARLY}"] <= sign * row[f"{name}, peak"]
            assert sign * row[f"{name}, at rest"] <= sign * row[f"{name}, {EARLY}"]
    t = table(COLUMNS, [tuple(row.values()) for row in judged.values()])
    assert guard(t, "clearance", (SET,)).told_apart == 1.0


@pytest.mark.slow
def test_the_recorded_jam_is_what_a_run_of_today_shows() -> None:
    recorded = read(DOCS / "data" / "guards")["jam"]
    for k, (name, threshold, seconds, _) in enumerate(jam.wind_jam()):
        assert recorded["guard"][k] == name
        assert_allclose(recorded["set to"][k], threshold, rtol=1e-2)
        # two samples
        assert_allclose(recorded["trips after the catch [s]"][k], seconds, rtol=0.0, atol=0.02)


def short() -> list:  # type: ignore[type-arg]
    """Some of the quickest that the page has."""
    return [sample for sample in draw(SET, 30) if sample.scene.rope.length < 250.0][:6]


def test_the_page_names_what_sees_the_jam_before_the_slack_and_after_it() -> None:
    recorded = read(DOCS / "data" / "guards")
    jam_table = dict(recorded["jam"])
    for times, said in (
        (
            [0.2, 0.05, np.nan, 0.3, 0.15],
            "first in window**, before the head ropes are slack.\n- It shows in rise and torque",
        ),
        (
            [0.2, 0.3, 0.4, 0.5, 0.15],
            "The slack comes first.**\n- It shows in rise, window, turns and torque too",
        ),
    ):
        jam_table[jam.COLUMNS[2]] = np.array(times)
        assert said in page({**recorded, "jam": jam_table})
