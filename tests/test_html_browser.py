"""The HTML reports in a headless browser: they load in silence, without network, and do what they are touched for.

Each page is opened once, by tests/browser.py; the claims below read what it saw.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from browser import BROWSER, END, Seen, bottom, look, run

from hoist_demo.parameters import Hoist
from hoist_demo.report.html.along import ROPE_ROWS
from hoist_demo.report.html.study import study_report

pytestmark = pytest.mark.skipif(BROWSER is None, reason="no Chromium found: apt-get install chromium")

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
const brush = document.querySelectorAll(".brush")[0], box = brush.getBoundingClientRect();
const point = (kind, part, target) => target.dispatchEvent(new PointerEvent(kind,
  {clientX: box.left + 5, clientY: box.bottom - part * box.height, bubbles: true, buttons: 1}));
point("pointerdown", 0, brush); point("pointermove", 0.6, window); point("pointerup", 0.6, window);
seen.kept = column(1);
"""


@pytest.fixture(scope="module", params=[1280, 390])
def seen_run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Seen:
    return look(run(tmp_path_factory.mktemp("run")), _RUN, request.param, "t=4.5")


@pytest.fixture(scope="module", params=[1280, 390])
def seen_study(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Seen:
    table = pd.DataFrame(
        {
            "jerk": [0.5, 1.0, 1.5, 2.0],
            "controller": ["PI", "PI", "shaped", "PI"],
            "swing": [4.0, math.nan, 12.0, 1.0],
            "status": ["completed", "failed", "completed", "completed"],
            "cause": ["", "head rope <b>gone</b>", "", ""],
        }
    )
    meta = {"parameters": ["jerk", "controller"], "best": {"metric": "swing", "sense": "min"}, "title": "Jerks"}
    folder = tmp_path_factory.mktemp("study")
    return look(study_report(table, {"swing": "mm"}, meta, folder / "study.html"), _STUDY, request.param)


def test_a_run_loads_without_a_word_on_the_console(seen_run: Seen) -> None:
    assert seen_run.console == []


def test_a_study_loads_without_a_word_on_the_console(seen_study: Seen) -> None:
    assert seen_study.console == []


def test_no_page_asks_the_network_for_anything(seen_run: Seen, seen_study: Seen) -> None:
    assert seen_run.said["requests"] == [] == seen_study.said["requests"]


def test_no_page_is_wider_than_the_window(seen_run: Seen, seen_study: Seen) -> None:
    for seen in (seen_run, seen_study):
        assert seen.said["width"] <= seen.said["room"]


def test_the_address_opens_the_page_at_an_instant(seen_run: Seen) -> None:
    assert float(seen_run.said["address"]["t"]) == 4.5
    assert seen_run.said["address"]["slider"] == 4.5


@pytest.mark.parametrize(("when", "t"), [("early", 3.0), ("late", 9.0)])
def test_the_slider_moves_the_rope_to_where_it_was_recorded(seen_run: Seen, when: str, t: float) -> None:
    # a tenth of a millimetre for packing, as much for four decimals
    np.testing.assert_allclose(seen_run.said[when]["bottom"], bottom(t), atol=2e-4)


def test_another_instant_is_another_drawing(seen_run: Seen) -> None:
    assert seen_run.said["early"]["path"] != seen_run.said["late"]["path"]


def test_the_cursors_of_the_plots_follow_the_slider(seen_run: Seen) -> None:
    early, late = seen_run.said["cursor"]
    assert late > early + 50.0


def test_a_click_in_a_plot_moves_slider_and_rope(seen_run: Seen) -> None:
    pressed = seen_run.said["pressed"]
    # the middle of the picture lies right of the plot's middle by half the margins' difference, 20 px of at least 240
    assert END / 2.0 - 1.2 < pressed["slider"] < END / 2.0
    assert float(pressed["t"]) == pytest.approx(pressed["slider"], abs=1e-3)


def test_another_view_shows_the_same_instant_otherwise(seen_run: Seen) -> None:
    front, pressed = seen_run.said["front"], seen_run.said["pressed"]
    assert front["t"] == pressed["t"]
    assert front["path"] != pressed["path"]


def test_playing_at_speed_1_takes_a_second_for_a_second(seen_run: Seen) -> None:
    # a frame of 20 ms to begin with, and one at the end
    assert seen_run.said["played"]["slider"] == pytest.approx(1.0, abs=0.05)


def test_every_recorded_quantity_has_its_plot(seen_run: Seen) -> None:
    expected = {"Height in the shaft", "Tension ratio on the sheave", "Pull on the conveyances"}
    expected |= {"Largest nominal stress of the rope", "Bending stress along the rope", "Tension along the rope"}
    assert expected <= set(seen_run.said["titles"])
    assert seen_run.said["curves"] >= 8


def test_what_never_moves_is_a_number_and_no_plot(seen_run: Seen) -> None:
    assert "Clearance between the legs (clearance 2.000 m)" in seen_run.said["quiet"]
    assert "Clearance between the legs" not in seen_run.said["titles"]


def test_bending_along_the_rope_is_dark_where_it_was_recorded(seen_run: Seen) -> None:
    # at the start the left leg is 14 m long, the right one 104 m, and the half circle between them 3.1 m
    at = (14.0 + math.pi / 2.0) / (14.0 + 104.0 + math.pi)
    assert seen_run.said["bending"]["at"] == pytest.approx(at, abs=1.0 / ROPE_ROWS)
    assert seen_run.said["bending"]["scale"] == "040.00 MPa"


def test_torsion_that_is_zero_all_along_is_a_number_and_no_picture(seen_run: Seen) -> None:
    assert "Torsional stress along the rope (0 MPa)" in seen_run.said["quiet"]
    assert "Torsional stress along the rope" not in seen_run.said["titles"]


def test_slip_transformations_and_the_emergency_stop_are_marked(seen_run: Seen) -> None:
    # a narrow plot has no room for both names
    assert seen_run.said["marks"] in (["emergency stop", "reference at rest"], ["emergency stop +1"])
    assert seen_run.said["transformations"] == 6
    assert seen_run.said["slips"] == 1


def test_the_loop_is_drawn_at_eight_instants(seen_run: Seen) -> None:
    assert seen_run.said["instants"] == 8


def test_numbers_at_the_cursor_are_those_recorded(seen_run: Seen) -> None:
    assert float(seen_run.said["reading"]) == pytest.approx(42.0, abs=0.01)


def test_a_swivel_that_cannot_turn_is_locked_and_does_not_stick(seen_run: Seen) -> None:
    assert seen_run.said["swivels"] == ["sticks", "locked"]


def test_the_limit_is_named_above_the_plot_and_no_name_lies_in_it(seen_run: Seen) -> None:
    limit = Hoist().tension_ratio_limit
    assert seen_run.said["limit"].startswith(f"ropes slip at exp(µα) = {limit:.2f}")


def test_no_axis_has_a_single_tick(seen_run: Seen) -> None:
    coarse, narrow, usual = seen_run.said["round"]
    np.testing.assert_allclose(coarse, [2.0, 4.0, 6.0, 8.0])
    np.testing.assert_allclose(narrow, [4.5, 5.0, 5.5])
    np.testing.assert_allclose(usual, [0.0, 0.5, 1.0])


def test_a_short_window_shows_a_second_around_the_cursor(seen_run: Seen) -> None:
    t, ticks = seen_run.said["played"]["slider"], seen_run.said["ticks"]
    assert all(t - 0.51 <= tick <= max(1.0, t + 0.51) for tick in ticks)
    assert len(ticks) >= 2


def test_a_complaint_of_the_page_would_be_noticed(tmp_path: Path) -> None:
    seen = look(run(tmp_path), 'fetch("https://example.org/").catch(() => 0); await wait(100);', 800)
    assert any("Content Security Policy" in line for line in seen.console)


def test_every_run_of_a_study_is_a_line_and_the_best_is_marked(seen_study: Seen) -> None:
    assert seen_study.said["lines"] == 4
    assert seen_study.said["best"] == "3"


def test_a_study_opens_with_what_was_varied_against_what_was_asked_for(seen_study: Seen) -> None:
    assert seen_study.said["chosen"] == ["jerk", "swing"]
    assert seen_study.said["axes"] == 3


def test_what_the_packing_rounds_to_zero_reads_as_zero(seen_study: Seen) -> None:
    low, zero, high = seen_study.said["unpacked"]
    assert (low, zero) == (-1.0, 0.0)
    assert high == pytest.approx(2.0)


def test_ticks_that_lie_close_are_told_apart(seen_study: Seen) -> None:
    assert seen_study.said["ticks"] == ["0.012320", "0.012322", "0.012324", "0.012326"]


def test_failed_runs_are_listed_with_their_causes(seen_study: Seen) -> None:
    assert "head rope <b>gone</b>" in seen_study.said["failed"]


def test_the_table_sorts_by_number_both_ways_with_missing_ones_last(seen_study: Seen) -> None:
    assert seen_study.said["up"] == ["1.000", "4.000", "12.00", "–"]
    assert seen_study.said["down"] == ["12.00", "4.000", "1.000", "–"]


def test_a_row_marks_its_run_in_the_pictures(seen_study: Seen) -> None:
    assert seen_study.said["marked"] == ["2"]
    assert seen_study.said["dots"] == 3


def test_a_range_on_an_axis_keeps_the_runs_within(seen_study: Seen) -> None:
    # jerks of 0.5 to 1.4: the first two; run 3 is marked and stays
    assert sorted(seen_study.said["kept"]) == ["1", "2", "3"]
