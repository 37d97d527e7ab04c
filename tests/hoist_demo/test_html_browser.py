"""The HTML reports, each opened once in a headless browser: they load in silence, without network, and react."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from browser import BROWSER, END, STEPS, bottom, curve, look, result, run, shaped

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.parameters import Hoist
from hoist_demo.report.html.packing import ROPE_ROWS
from hoist_demo.report.html.run import run_report
from hoist_demo.report.html.study import study_report
from hoist_demo.report.rows import Report
from hoist_demo.report.verdict import judge
from hoist_demo.study.objective import Constraint, Objective
from hoist_demo.study.perform import Best, StudyResult
from hoist_demo.study.store import Results

pytestmark = pytest.mark.skipif(
    BROWSER is None, reason="no Chromium found: apt-get install chromium"
)

_RUN = """
const slider = document.getElementById("slider"), loop = document.getElementById("loop");
const rope = () => ({t: loop.dataset.t, bottom: loop.dataset.bottom.split(" ").map(Number),
  path: loop.querySelector(".rope .left").getAttribute("d"), slider: Number(slider.value)});
const set = (t) => { slider.value = t; slider.dispatchEvent(new Event("input")); return rope(); };
seen.address = rope();
seen.early = set(3);
seen.late = set(9);
const plot = document.querySelector(".chart");
plot.scrollIntoView();
const cursor = () => Number(plot.querySelector(".cursor").getAttribute("x1"));
seen.cursor = [3, 9].map((t) => { set(t); return cursor(); });
press(plot, [0.5, 0.5]);
seen.pressed = rope();
const front = document.querySelector('[data-view="front"]');
front.click();
seen.front = rope();
seen.titles = [...document.querySelectorAll(".plot strong")].map((title) => title.textContent);
// place of a picture's darkest point at the start: share of the height, from the top
const darkest = async (title) => {
  const titled = (plot) => plot.querySelector("strong")?.textContent === title;
  const figure = [...document.querySelectorAll(".plot")].find(titled);
  const image = new Image(), canvas = document.createElement("canvas");
  image.src = figure.querySelector("image").getAttribute("href");
  await image.decode();
  [canvas.width, canvas.height] = [image.width, image.height];
  const context = canvas.getContext("2d");
  context.drawImage(image, 0, 0);
  const light = [...context.getImageData(0, 0, 1, image.height).data].filter((_, k) => k % 4 === 0);
  return {at: light.indexOf(Math.min(...light)) / image.height, scale: figure.querySelector(".scale").textContent};
};
seen.bending = await darkest("Bending stress along the rope");
seen.quiet = document.querySelector("#plots .wide").textContent;
seen.curves = document.querySelectorAll(".plot path.line").length;
seen.marks = [...plot.querySelectorAll(".mark-label")].map((label) => label.textContent);
seen.transformations = plot.querySelectorAll(".transformation").length;
seen.slips = plot.querySelectorAll(".slip").length;
seen.instants = document.querySelectorAll("#instants .rope").length;
set(6);
seen.reading = document.querySelector("#readout .value").textContent;
seen.swivels = [...document.querySelectorAll("#readout td[colspan]")].map((cell) => cell.textContent);
seen.limit = document.querySelector("figcaption .limit-label").textContent;
seen.round = [[0.9, 9.7, 4], [4.2, 5.6, 1], [0, 1, 4]].map(([lo, hi, count]) => ticks(lo, hi, count).values);
set(0);
// frames by the browser's own clock, which runs ahead of those of the screen here
window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 20);
document.getElementById("play").click();
await wait(1000);
document.getElementById("play").click();
seen.played = rope();
const shown = document.getElementById("window");
shown.value = "1"; shown.dispatchEvent(new Event("change"));
seen.ticks = [...plot.querySelectorAll('.tick[text-anchor="middle"]')].map((text) => Number(text.textContent));
"""

_STUDY = """
const cells = (k) => [...document.querySelectorAll(`#runs tbody tr td:nth-child(${k})`)];
const column = (k) => cells(k).map((cell) => cell.textContent);
const heading = (text) => [...document.querySelectorAll("#runs th button")].find((b) => b.textContent.startsWith(text));
// codes of 16 bits for -1, 0 and 2: none of them is exactly 0
seen.unpacked = [...unpack({kind: "u16", lo: -1, hi: 2, data: btoa("\\x00\\x00\\x55\\x55\\xfe\\xff")})];
seen.ticks = [0, 1, 2, 3].map((k) => tickText(0.01232 + k * 2e-6, 2e-6));
seen.axes = document.querySelectorAll("#parallel .axis").length;
seen.chosen = ["across", "up"].map((id) => document.getElementById(id).selectedOptions[0].textContent);
seen.lines = document.querySelectorAll(".run-line").length;
seen.best = document.querySelector(".run-line.best").dataset.run;
seen.failed = document.getElementById("failed").textContent;
heading("swing").click(); seen.up = column(5);
heading("swing").click(); seen.down = column(5);
document.querySelector('#runs tr[data-run="2"]').click();
seen.marked = [...document.querySelectorAll(".run-line.marked")].map((line) => line.dataset.run);
seen.dots = document.querySelectorAll(".dot").length;
seen.bounds = document.querySelectorAll("#parallel .bound").length;
seen.fits = byId("runs").scrollWidth <= byId("runs").parentElement.clientWidth + 1;
const labels = [...document.querySelectorAll("#columns label")];
const shown = (name) => labels.find((label) => label.textContent.trim() === name).firstChild;
for (const [id, name] of [["across", "slip_safety"], ["up", "clearance"]]) {
  byId(id).value = COLUMNS.findIndex((column) => column.name === name);
  byId(id).dispatchEvent(new Event("change"));
}
seen.front = [...document.querySelectorAll("circle.front title")].map((title) => title.textContent.match(/\\d+/)[0]);
for (const name of ["slip_safety", "clearance"]) if (shown(name).checked) shown(name).click();
const brush = document.querySelectorAll(".brush")[0], box = brush.getBoundingClientRect();
const point = (kind, part, target) => target.dispatchEvent(new PointerEvent(kind,
  {clientX: box.left + 5, clientY: box.bottom - part * box.height, bubbles: true, buttons: 1}));
point("pointerdown", 0, brush); point("pointermove", 0.6, window); point("pointerup", 0.6, window);
seen.kept = column(1);
"""


@pytest.fixture(scope="module", params=[1280, pytest.param(390, marks=pytest.mark.slow)])
def seen_run(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> SimpleNamespace:
    return look(run(tmp_path_factory.mktemp("run")), _RUN, request.param, "t=4.5")


@pytest.fixture(scope="module", params=[1280, pytest.param(390, marks=pytest.mark.slow)])
def seen_study(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> SimpleNamespace:
    table = pd.DataFrame(
        {
            "jerk": [0.5, 1.0, 1.5, 2.0],
            "controller": ["PI", "PI", "shaped", "PI"],
            "swing": [4.0, math.nan, 12.0, 1.0],
            "status": ["completed", "failed", "completed", "completed"],
            "cause": ["", "head rope <b>gone</b>", "", ""],
        }
    )
    table["slip_safety"] = [2.0, 1.5, 1.9, 1.8]
    table["clearance"] = [0.5, 2.0, 0.7, 0.4]
    meta = {"parameters": ["jerk", "controller"], "title": "Jerks"}
    page = tmp_path_factory.mktemp("study") / "study.html"
    objective = Objective({"swing": 1.0}, 1.0, (Constraint("clearance", 0.45, -1.0),))
    result = StudyResult(page, 4, {}, {}, {}, (), range(4), Best((3,), "run 4", True))
    return look(
        study_report(Results(table, {"swing": "mm"}), meta, page, (), result, objective),
        _STUDY,
        request.param,
    )


def test_a_run_loads_silently_and_follows_slider_click_and_clock(seen_run: SimpleNamespace) -> None:
    said = seen_run.said
    assert seen_run.console == [] == said["requests"]
    assert said["width"] <= said["room"]
    assert (float(said["address"]["t"]), said["address"]["slider"]) == (4.5, 4.5)
    for when, t in (("early", 3.0), ("late", 9.0)):
        # a tenth of a millimetre for packing, as much for four decimals
        np.testing.assert_allclose(said[when]["bottom"], bottom(t), atol=2e-4)
    assert said["early"]["path"] != said["late"]["path"]
    assert said["cursor"][1] > said["cursor"][0] + 50.0
    # the middle of the picture lies right of the plot's middle by half the margins' difference, 20 px of at least 240
    assert END / 2.0 - 1.2 < said["pressed"]["slider"] < END / 2.0
    assert float(said["pressed"]["t"]) == pytest.approx(said["pressed"]["slider"], abs=1e-3)
    assert said["front"]["t"] == said["pressed"]["t"]
    assert said["front"]["path"] != said["pressed"]["path"]
    # at speed 1, a frame of 20 ms to begin with and one at the end
    assert said["played"]["slider"] == pytest.approx(1.0, abs=0.05)
    t = said["played"]["slider"]
    ticks = said["ticks"]
    assert len(ticks) >= 2
    assert all(t - 0.51 <= tick <= max(1.0, t + 0.51) for tick in ticks)


def test_a_run_shows_what_was_recorded(seen_run: SimpleNamespace) -> None:
    said = seen_run.said
    expected = {"Height in the shaft", "Tension ratio on the sheave", "Pull on the conveyances"}
    expected |= {
        "Largest nominal stress of the rope",
        "Bending stress along the rope",
        "Tension along the rope",
    }
    assert expected <= set(said["titles"])
    assert said["curves"] >= 8
    # what never moves, and what is zero all along, is a number and no plot
    numbers = {
        "Clearance between the legs": "clearance 2.000 m",
        "Torsional stress along the rope": "0 MPa",
    }
    for title, number in numbers.items():
        assert f"{title} ({number})" in said["quiet"]
        assert title not in said["titles"]
    # at the start the left leg is 14 m long, the right one 104 m, and the half circle between them 3.1 m
    at = (14.0 + math.pi / 2.0) / (14.0 + 104.0 + math.pi)
    assert said["bending"] == {"at": pytest.approx(at, abs=1.0 / ROPE_ROWS), "scale": "040.00 MPa"}
    # a narrow plot has no room for both names
    assert said["marks"] in (["emergency stop", "reference at rest"], ["emergency stop +1"])
    assert (said["transformations"], said["slips"], said["instants"]) == (6, 1, 8)
    assert float(said["reading"]) == pytest.approx(42.0, abs=0.01)
    assert said["swivels"] == ["sticks", "locked"]
    assert f"{Hoist().tension_ratio_limit:.2f}" in said["limit"]
    for found, ticks in zip(
        said["round"], ([2.0, 4.0, 6.0, 8.0], [4.5, 5.0, 5.5], [0.0, 0.5, 1.0]), strict=True
    ):
        np.testing.assert_allclose(found, ticks)


@pytest.fixture(scope="module")
def never_began(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """The page of a run without a row, which then asks the network for something."""
    touches = found('querySelector(".stopped").textContent')
    asks = 'fetch("https://example.org/").catch(() => 0); await wait(100);'
    return look(stopped({}, tmp_path_factory.mktemp("never")), f"{touches} {asks}", 800)


def found(probe: str) -> str:
    return f"seen.found = document.{probe};"


def stopped(signals: dict[str, np.ndarray], folder: Path) -> Path:
    """The page of a run that was stopped."""
    ended = result(signals, "no <shape>")
    report = Report("T", judge(ended, Hoist(), [RopeData({}, {}, {})]))
    return run_report(ended, Hoist(), report, folder / "run.html")


def test_a_complaint_of_the_page_would_be_noticed(never_began: SimpleNamespace) -> None:
    assert any("Content Security Policy" in line for line in never_began.console)


def test_a_study_loads_silently_sorts_marks_and_keeps_a_range(seen_study: SimpleNamespace) -> None:
    said = seen_study.said
    assert seen_study.console == [] == said["requests"]
    assert said["width"] <= said["room"]
    # as many columns as have room: all five of a wide page
    assert (said["lines"], said["best"], said["axes"], said["dots"]) == (
        4,
        "3",
        5 if said["room"] > 400 else 3,
        3,
    )
    assert (said["chosen"], said["bounds"]) == (["jerk", "swing"], said["room"] > 400)
    # more is better in both; the fourth is beaten by the first, the second has failed
    assert (sorted(said["front"]), said["fits"]) == (["1", "3"], True)
    # what the packing rounds to zero reads as zero
    assert said["unpacked"] == [-1.0, 0.0, pytest.approx(2.0)]
    assert said["ticks"] == ["0.012320", "0.012322", "0.012324", "0.012326"]
    assert "head rope <b>gone</b>" in said["failed"]
    assert (said["up"], said["down"]) == (
        ["1.000", "4.000", "12.00", "–"],
        ["12.00", "4.000", "1.000", "–"],
    )
    assert said["marked"] == ["2"]
    # jerks of 0.5 to 1.4: the first two; run 3 is marked and stays
    assert sorted(said["kept"]) == ["1", "2", "3"]


def test_a_run_that_never_began_is_shown(never_began: SimpleNamespace) -> None:
    # no complaint but that of the network
    assert all("example.org" in line for line in never_began.console)
    assert "no <shape>" in never_began.said["found"]


def test_a_run_that_stopped_after_one_row_is_shown(tmp_path: Path) -> None:
    signals = {
        name: np.array([value])
        for name, value in (("time", 0.0), ("left.fy", -1e3), ("loop.y", -15.0))
    }
    page = stopped(signals | shaped(curve(0.0)[None]), tmp_path)
    seen = look(page, found('getElementById("loop").dataset.bottom'), 800)
    assert seen.console == []
    assert "0.0000 -15.0000 0.0000" in seen.said["found"]


_SHAFT = """
const slider = document.getElementById("slider"), loop = document.getElementById("loop");
const at = (t) => {
  slider.value = t; slider.dispatchEvent(new Event("input"));
  const circle = loop.querySelector(".contact"), bottom = loop.querySelector(".bottom");
  return {contacts: loop.dataset.contacts, tripped: loop.dataset.tripped,
    label: loop.querySelector(".contact-label")?.textContent ?? "",
    apart: circle && Math.hypot(...["cx", "cy"].map((c) => circle.getAttribute(c) - bottom.getAttribute(c)))};
};
seen.opened = loop.dataset.contacts;
[seen.free, seen.pressed] = [at(1), at(6)];
seen.parts = ["lining", "floor", "divider", "guard"].map((kind) => loop.querySelectorAll("." + kind).length);
const box = new Shaft(DATA.shaft, () => NaN).boxes([-1, 0, 0], [1, 90, 0]).find(({ kind }) => kind === "divider");
seen.distance = distanceFrom(box, [0.5, -13, 7]);
seen.stretch = document.getElementById("stretch").value;
"""


def test_the_shaft_is_drawn_with_its_contacts_and_the_guard_that_tripped(tmp_path: Path) -> None:
    t = np.linspace(0.0, END, STEPS)
    late = (t > 4.0).astype(float)
    signals = {
        "time": t,
        "contact.floor": 50.0 * late,
        "contact.lining": 0.0 * t,
        "loop.rise": 0.01 * t,
    }
    signals |= {"guard.tripped": late, "guard.cause": late, "guard.time": 4.0 * late}
    signals |= shaped(np.array([curve(float(s)) for s in t]))
    parameters = {
        "lining.width": 5.0,
        "lining.depth": 3.0,
        "lining.rounding": 0.5,
        "sump.level": -15.5,
    }
    parameters |= {
        "divider_2.size": 0.2,
        "divider_2.y": -13.0,
        "divider_2.rounding": 1.0,
        "guard.rise": 0.5,
    }
    rope = RopeData({}, parameters, {})
    ended = result(signals)
    page = run_report(
        ended, Hoist(), Report("T", judge(ended, Hoist(), [rope])), tmp_path / "run.html", [rope]
    )
    seen = look(page, _SHAFT, 1000)
    assert seen.console == []
    assert seen.said["opened"] == "floor"  # the page opens on the strike
    assert seen.said["free"] == {"contacts": "", "tripped": "", "label": "", "apart": None}
    assert (seen.said["pressed"]["contacts"], seen.said["pressed"]["tripped"]) == ("floor", "rise")
    assert seen.said["pressed"]["label"].startswith("floor 50.0")
    assert seen.said["pressed"]["apart"] < 0.1  # the lowest point is the nearest to the floor
    assert all(seen.said["parts"])
    assert (seen.said["distance"], seen.said["stretch"]) == (pytest.approx(0.4), "1")
