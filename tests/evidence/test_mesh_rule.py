"""Constants of the 'auto' mesh against the recorded data of evidence.mesh_rule, and those against the rope."""

import itertools
import math
from dataclasses import replace
from functools import cache, partial
from itertools import islice

import numpy as np
import pytest
from native_parts import fit_mesh, partition
from numpy.testing import assert_allclose

from evidence.mesh_rule import laws, rule, statics
from evidence.mesh_rule.scenes import JUDGE, KINDS, draw
from evidence.promise.scenes import Sample
from evidence.promise.scenes import draw as samples
from evidence.promise.wind import REQUESTS, errors, wind
from evidence.rendering import DOCS
from evidence.tables import read, rows
from hoist_demo.parameters import Winding
from rope_model import Accuracy, Layout, Rope, Scene
from rope_model.compiler import find_compiler
from rope_model.method.mesh_fit import (
    BEND_SHARE,
    LEG_GRADING,
    LEG_WAVES,
    PUMPED_LEG,
    pumped_grading,
)
from rope_model.physics.estimates import axial_frequency

TABLES = read(DOCS / "data" / "mesh_rule")
FOUND = laws.fit(TABLES)
shares = cache(partial(rule.shares, FOUND))


@pytest.mark.parametrize("asked", [0.05, 5e-3, 1e-3, 2e-4])
def test_the_loop_s_elements_take_their_share_of_what_is_asked_and_at_least_a_third_of_it(
    asked: float,
) -> None:
    share = shares(asked).loop / BEND_SHARE
    assert share.max() < 1.05  # the constants are the law's, rounded
    assert asked > 1e-3 or np.median(share) > 1 / 3  # no longer elements than MAX_LENGTH


def test_the_longest_elements_are_the_longest_on_which_the_loop_does_not_slip_aside() -> None:
    used, longer = rule.slip(TABLES["loop"])
    assert used < 0.4 < 0.6 < longer


@pytest.mark.parametrize("asked", [0.05, 5e-3, 1e-3, 2e-4])
def test_what_fades_out_above_takes_less_than_a_tenth_of_what_is_asked(asked: float) -> None:
    assert shares(asked).cover.max() < 0.1


def test_end_elements_keep_the_clamp_moment_to_a_percent_at_5_mm() -> None:
    assert 0.005 < shares(5e-3).moment.max() < 0.015


def test_legs_take_a_quarter_of_what_is_asked_and_after_a_stop_some_times_what_steps_do() -> None:
    assert 0.15 < LEG_GRADING * FOUND.legs.values[0] < 0.45
    steps = np.median(rows(TABLES["parts"], what="steps", trip=KINDS[1])["off [m]"])
    assert 1.5 < LEG_WAVES * FOUND.legs_stopped.values[0] / steps < 4


@pytest.mark.parametrize("length", [600.0, 800.0])
def test_waves_that_an_emergency_stop_pumps_have_four_elements_on_long_ropes(length: float) -> None:
    scene = Scene(Rope(length=length))
    bottom = PUMPED_LEG * length
    lengths = partition(fit_mesh(scene), length, bottom).lengths
    middles = np.cumsum(lengths) - 0.5 * lengths
    height = bottom - middles
    leg = (height > 0.05 * length) & (height < 0.7 * length)
    frequency = 0.5 * axial_frequency(scene.rope, bottom)
    waves = 2 * math.pi * np.sqrt(scene.layout.gravity * height[leg]) / frequency
    assert (waves / lengths[leg]).min() > 3.5


@pytest.mark.parametrize("length", [60.0, 100.0, 120.0])
def test_on_ropes_whose_longitudinal_waves_fade_before_that_they_need_none(length: float) -> None:
    scene = Scene(Rope(length=length))
    assert pumped_grading(scene) > fit_mesh(scene).grading_length


def pumped_errors(sample: Sample, asked: Accuracy, coarser: float) -> list[tuple[float, float]]:
    """Errors of end forces and loop of the mesh by the rule and of one with legs that much coarser."""
    mesh = fit_mesh(sample.scene.with_(accuracy=asked))
    finer, *found = (
        wind(
            sample,
            sample.interval,
            accuracy=asked,
            mesh=replace(mesh, grading_length=share * mesh.grading_length),
        )
        for share in (0.4, 1.0, coarser)
    )
    return [errors(one, finer) for one in found]


@pytest.mark.slow
def test_after_an_emergency_stop_pumped_waves_leave_the_end_forces_of_a_long_rope_right() -> None:
    rope = Rope(
        length=596.488,
        mass_per_length=11.8576,
        EI=600.7,
        Qa=2.250751e8,
        Qb=147094.7,
        Qc=147094.7,
        Qd=5180.572,
        rhoJ=4.253205e-3,
        diameter=0.053568,
    )
    trip = Winding(
        travel=351.404,
        speed=17.54,
        acceleration=1.044,
        jerk=2.5643,
        start_delay=0.0,
        emergency_at=20.5691,
        emergency_deceleration=4.9024,
    )
    sample = Sample(0, Scene(rope, Layout(2.6084)), trip, 0.01)
    by_rule, coarser = pumped_errors(sample, sample.scene.accuracy, 3.3)
    assert by_rule[0] < 0.5 * sample.scene.accuracy.end_force < 0.5 * coarser[0]


@pytest.mark.slow
def test_pumped_waves_leave_the_loop_right_where_a_tenth_of_the_default_error_is_asked_for() -> (
    None
):
    sample = next(islice(samples(733, 27), 26, None))  # 356 m, an emergency stop
    by_rule, coarser = pumped_errors(sample, REQUESTS["tight"], 10**0.5)
    assert by_rule[1] < 0.5 * REQUESTS["tight"].loop < 0.5 * coarser[1]


@pytest.mark.parametrize("place", [0.0, 0.03, 1.0])
def test_a_fitted_mesh_follows_the_loop_to_the_end_of_the_rope(place: float) -> None:
    for length, EI in itertools.product((30.0, 60.0, 90.0, 150.0), (50.0, 300.0, 3000.0)):
        mesh = fit_mesh(Scene(Rope(length=length, EI=EI)))
        if mesh.kind == "tmn":
            cells = partition(mesh, length, place * length)
            # the outermost element stays, and of IV the half and less than another such length
            assert abs(cells.centre - place * length) < 2 * cells.coarse


@pytest.mark.skipif(not find_compiler(), reason="slow without a C compiler")
def test_a_rope_of_the_judging_seed_hangs_too_low_by_the_law() -> None:
    drawn = next(statics.long_enough(draw(JUDGE, 9)))
    for length in (0.28, 0.5):
        fine, finest = (statics.pattern(drawn, x) for x in (length, statics.FINEST))
        found = -statics.shift(drawn, fine, finest, 0.1)[1]
        law = float(
            laws.loop_error(FOUND.loop.values, np.array(length * drawn.w), np.array(drawn.w))
        )
        assert_allclose(found, law, rtol=math.exp(3 * FOUND.loop.spread) - 1)
