"""Runs that lack something, or hang in a shaft, in a headless browser."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from browser import BROWSER, END, POINTS, STEPS, curve, look, run

from hoist_demo.parameters import Hoist, Winding
from hoist_demo.recording.time_series import Recording
from hoist_demo.report.html.run import run_report

pytestmark = pytest.mark.skipif(BROWSER is None, reason="no Chromium found: apt-get install chromium")


def test_old_recording_says_why_nothing_is_shown_along_the_rope(tmp_path: Path) -> None:
    probe = """seen.note = document.getElementById("along-note").textContent;
        seen.titles = [...document.querySelectorAll(".plot strong")].map((title) => title.textContent);"""
    seen = look(run(tmp_path, known=False), probe, 800)
    assert seen.console == []
    assert "no outputs shape.bending and shape.torsion and shape.tension" in seen.said["note"]
    assert not [title for title in seen.said["titles"] if "along the rope" in title]


def test_a_run_without_a_recorded_curve_still_has_its_plots(tmp_path: Path) -> None:
    missing = {f"shape.x[{i + 1}]": np.full(STEPS, math.nan) for i in range(POINTS)}
    seen = look(run(tmp_path, **missing), 'seen.plots = document.querySelectorAll(".plot").length;', 800)
    assert seen.console == []
    assert seen.said["plots"] > 3


def test_a_run_that_stopped_after_one_row_is_shown(tmp_path: Path) -> None:
    only = {name: np.array([value]) for name, value in (("time", 0.0), ("left.fy", -1e3), ("loop.y", -15.0))}
    only |= {f"shape.{c}[{i + 1}]": curve(0.0)[i : i + 1, k] for k, c in enumerate("xyz") for i in range(POINTS)}
    result = SimpleNamespace(
        recording=Recording(only, {}), completed=False, cause="overwind", trajectory=SimpleNamespace(duration=9.0)
    )
    page = run_report(result, Hoist(), Winding(), [], "T", tmp_path / "run.html")
    seen = look(page, 'seen.bottom = document.getElementById("loop").dataset.bottom;', 800)
    assert seen.console == []
    assert seen.said["bottom"] == "0.0000 -15.0000 0.0000"


def test_a_run_that_never_began_says_why(tmp_path: Path) -> None:
    result = SimpleNamespace(recording=Recording({}, {}), completed=False, cause="no <shape>", trajectory=None)
    page = run_report(result, Hoist(), Winding(), [], "T", tmp_path / "run.html")
    seen = look(page, 'seen.note = document.querySelector(".stopped").textContent;', 800)
    assert seen.console == []
    assert "no <shape>" in seen.said["note"]


_SHAFT = """
const slider = document.getElementById("slider"), loop = document.getElementById("loop");
const at = (t) => {
  slider.value = t; slider.dispatchEvent(new Event("input"));
  const circle = loop.querySelector(".contact"), bottom = loop.querySelector(".bottom");
  return {contacts: loop.dataset.contacts, tripped: loop.dataset.tripped,
    label: loop.querySelector(".contact-label")?.textContent ?? "",
    apart: circle && Math.hypot(...["cx", "cy"].map((c) => circle.getAttribute(c) - bottom.getAttribute(c)))};
};
[seen.free, seen.pressed] = [at(1), at(6)];
seen.parts = ["lining", "floor", "divider", "guard"].map((kind) => loop.querySelectorAll("." + kind).length);
const box = new Shaft(DATA.shaft, () => NaN).boxes([-1, 0, 0], [1, 90, 0]).find(({ kind }) => kind === "divider");
seen.distance = distanceFrom(box, [0.5, -13, 7]);
seen.stretch = document.getElementById("stretch").value;
"""


def test_the_shaft_is_drawn_with_its_contacts_and_the_guard_that_tripped(tmp_path: Path) -> None:
    t = np.linspace(0.0, END, STEPS)
    shapes = np.array([curve(float(s)) for s in t])
    late = (t > 4.0).astype(float)
    signals = {"time": t, "contact.floor": 50.0 * late, "contact.lining": 0.0 * t, "loop.rise": 0.01 * t}
    signals |= {"guard.tripped": late, "guard.cause": late, "guard.time": 4.0 * late}
    signals |= {f"shape.{c}[{i + 1}]": shapes[:, i, k] for k, c in enumerate("xyz") for i in range(POINTS)}
    parameters = {"lining.width": 5.0, "lining.depth": 3.0, "lining.rounding": 0.5, "sump.level": -15.5}
    parameters |= {"divider_2.size": 0.2, "divider_2.y": -13.0, "divider_2.rounding": 1.0, "guard.rise": 0.5}
    result = SimpleNamespace(
        recording=Recording(signals, {}), completed=True, cause="", trajectory=SimpleNamespace(duration=9.0)
    )
    page = run_report(result, Hoist(), Winding(), [], "T", tmp_path / "run.html", parameters=parameters)
    seen = look(page, _SHAFT, 1000)
    assert seen.console == []
    assert seen.said["free"] == {"contacts": "", "tripped": "", "label": "", "apart": None}
    assert seen.said["pressed"]["contacts"] == "floor"
    assert seen.said["pressed"]["tripped"] == "rise"
    assert seen.said["pressed"]["label"].startswith("floor 50.0")
    assert seen.said["pressed"]["apart"] < 0.1  # the lowest point is the nearest to the floor
    assert all(seen.said["parts"])
    assert seen.said["distance"] == pytest.approx(0.4)
    assert seen.said["stretch"] == "1"
