"""No label of a study's report covers another or leaves its picture, in a headless browser."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pandas as pd
import pytest
from browser import BROWSER, look

from hoist_demo.report.html.study import study_report

pytestmark = pytest.mark.skipif(BROWSER is None, reason="no Chromium found: apt-get install chromium")

VARIANTS = [
    "healthy",
    *(f"{k} times the healthy friction" for k in (3, 10, 20, 40, 80, 160)),
    "left one seized",
    "both",
]
#: boxes of the labels, those of a group on one line, and how far the picture reaches
LABELS = """
const boxes = (svg, labels) => [...document.querySelectorAll(`${svg} ${labels}`)].map((label) => {
  const box = label.getBoundingClientRect();
  return [box.left, box.right, box.top, box.bottom];
});
const frame = (svg) => boxes("", svg)[0];
seen.names = boxes("#parallel", ".axis .name");
seen.parallel = frame("#parallel");
seen.across = boxes("#scatter", '.tick[text-anchor="middle"]');
seen.up = boxes("#scatter", '.tick[text-anchor="end"]');
seen.scatter = frame("#scatter");
byId("up").value = byId("across").value;
drawScatter();
seen.words = boxes("#scatter", '.tick[text-anchor="end"]');
"""


@pytest.mark.parametrize("width", [1280, 390])
def test_labels_stand_apart_and_within_their_picture(width: int, tmp_path: Path) -> None:
    runs = len(VARIANTS)
    parameters = [f"{side}.swivel.{name}" for side in ("left", "right") for name in ("mu_static", "mu_kinetic")]
    parameters += ["rope.installed_twist", "hoist.tail_rope_number", "rope.initial_curvature_angle"]
    table = pd.DataFrame({"variant": VARIANTS} | {name: [0.01 * k for k in range(runs)] for name in parameters})
    table["torque_limited_time"] = [1.0 + k for k in range(runs)]
    table["status"], table["cause"] = "completed", ""
    meta = {"parameters": ["variant", *parameters], "title": "Swivels"}
    page = study_report(table, dict.fromkeys(parameters, "kg.m2"), meta, tmp_path / "study.html")
    seen = look(page, LABELS, width).said
    for labels, frame in (("names", "parallel"), ("across", "scatter"), ("up", "scatter"), ("words", "scatter")):
        left, right, top, bottom = seen[frame]
        assert len(seen[labels]) > 1
        for box in seen[labels]:
            assert left <= box[0], labels
            assert box[1] <= right, labels
            assert top <= box[2], labels
            assert box[3] <= bottom, labels
    for labels in ("names", "across"):
        boxes = sorted(seen[labels])
        assert all(box[1] <= other[0] for box, other in pairwise(boxes)), labels
