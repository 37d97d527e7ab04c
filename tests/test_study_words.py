"""Sentences and differences of the page on drive controllers say what their tables hold."""

from __future__ import annotations

import pandas as pd

from evidence.rendering import render
from evidence.studies.page import creep_pays, draft_error, winner, with_differences

CREEP = pd.DataFrame(
    {
        "variant": ["none", "none", "1 m/s, 2 m", "1 m/s, 2 m"],
        "controller": ["pi", "input-shaping", "pi", "input-shaping"],
        "winding.jerk": [1.0, 1.0, 1.0, 1.0],
        "cycle_time": [26.0, 22.0, 28.0, 23.5],
        "swing_right": [4e-3, 1e-3, 2e-3, 2e-3],
        "rope_force_ripple": [20.0, 10.0, 30.0, 20.0],
        "torque_rms": [7e4, 7e4, 7e4, 7e4],
    }
)


def test_each_winding_with_creep_is_held_against_the_same_without() -> None:
    found = with_differences(CREEP)
    assert list(found["added"]) == [0.0, 0.0, 2.0, 1.5]
    assert list(found["swing_right_ratio"]) == [1.0, 1.0, 0.5, 2.0]


def test_what_creep_costs_is_told_over_the_creeping_windings_only() -> None:
    told = " ".join(render("studies/creep.md.j2", {"creep": creep_pays(with_differences(CREEP))}).split())
    assert "adds 1.50 to 2.00 s" in told
    assert "smaller in 1 of 2 windings" in told
    assert "without creep: input shaping, ZVD, jerk 1 m/s^3, 22.00 s with 1.00 mm" in told
    assert "with it: 1 m/s, 2 m: input shaping, ZVD, jerk 1, 23.50 s with 2.00 mm." in told


def test_the_winner_is_the_fastest_and_the_gentlest_of_its_jerk_ripples_least() -> None:
    ripples = [9.0, 30.0, 20.0, 8.0]
    table = CREEP.assign(slip_safety=[1.1, 1.2, 1.3, 1.4], variant=list("abcd"), rope_force_ripple=ripples)
    table["winding.jerk"] = [3.0, 3.0, 3.0, 1.0]
    told = " ".join(render("studies/winner.md.j2", {"winner": winner(table)}).split())
    assert "First is: **b**, 22.00 s with 1.0 mm" in told
    assert "1.50 s (d), 4.00 s (a), 6.00 s (c)" in told
    assert "is: **a**. The rope's force ripples by 9 N with it, by 30 N with the first" in told


def test_a_draft_winding_is_compared_with_the_complete_one_of_its_case_and_jerk() -> None:
    draft = pd.DataFrame(
        {
            "variant": ["PI", "PI", "ZV"],
            "winding.jerk": [1.0, 3.0, 3.0],
            "cycle_time": [26.0, 27.0, 22.0],
            "swing_left": [1e-3, 1e-3, 1e-3],
            "swing_right": [1e-3, 1e-3, 1e-3],
        }
    )
    complete = draft[1:].assign(variant=["PI, jerk 3", "ZV"], cycle_time=[27.0, 22.1], swing_left=[1.3e-3, 1e-3])
    # rounded up
    assert draft_error(draft, complete) == {"time": "0.10", "swing": "0.30", "count": 2}
