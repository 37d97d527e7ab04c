"""Random shafts: the independent look at the shapes sees what came through, and contact lets nothing through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from random_shafts import Case, depths, draw, run, windings

from rope_model import Contact, Divider, Shaft, Sump
from rope_model.numerics.kernels import find_compiler

ARC = np.linspace(np.pi, 2.0 * np.pi, 40)
#: legs of 5 m above a half circle of 1 m about the origin
LOOP = np.vstack([[-1.0, 5.0, 0.0], np.stack([np.cos(ARC), np.sin(ARC), 0.0 * ARC], axis=-1), [1.0, 5.0, 0.0]])


def test_a_rope_winds_once_about_what_its_loop_holds_and_not_about_what_is_beside() -> None:
    assert windings(LOOP, Divider(size=0.2)) == 1
    assert windings(LOOP, Divider(size=0.2, y=3.0, offset=0.9)) == 1
    assert windings(LOOP, Divider(size=0.2, y=3.0, offset=1.1)) == 0
    assert windings(LOOP, Divider(size=0.2, y=-1.2)) == 0


def test_depths_are_those_of_the_centre_line() -> None:
    scene = draw(0).scene.with_(shaft=Shaft(divider_1=Divider(size=0.2, y=-1.05), sump=Sump(level=-0.8)))
    found = depths(scene, LOOP)
    # the polygon's sides are 0.0008 m within the arc
    assert found == pytest.approx({"floor": 0.2, "divider 1": 0.05}, abs=1e-3)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("seed", [28, 37])
def test_contact_holds_what_would_come_through(seed: int) -> None:
    case = draw(seed)
    ending, through, deepest = run(case)
    assert ending == "completed, having struck something"
    assert through == []
    assert deepest < 0.0
    without = case.scene.with_(shaft=replace(case.scene.shaft, contact=Contact(stiffness=0.0)))
    ending, through, _ = run(Case(without, case.trip))
    assert "having struck something" in ending
    assert any(text.startswith("through divider") for text in through)
