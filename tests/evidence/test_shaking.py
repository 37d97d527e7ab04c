"""Ends that shake sideways: errors against equal elements, their estimates and the warning."""

from functools import cache
from typing import NamedTuple

import pytest
from numpy.testing import assert_allclose

from evidence.errors import end_error, place_error
from evidence.rendering import DOCS
from evidence.shaking.measure import ESTIMATES, Shaken, Shaking, exact, shake
from evidence.tables import Table, read, rows, where
from rope_model import Mesh, Rope, Scene

SCENE = Scene(rope=Rope(length=60.0))
TABLES = read(DOCS / "data" / "shaking")
FASTEST = 4.5  #: Hz
WRONG = 1e-4  #: error of the end forces from which on the estimate is judged
HEIGHTS = (40.0, 10.0)  # m
LASTING = 4.0  # s
FINE = 0.2  # m
#: of the estimate where it is tuned, and on another rope
FACTOR = 3.0
OTHER_FACTOR = 5.0
UNRESOLVED = (
    Shaking(HEIGHTS, "x", 2.0, 0.02, LASTING),
    Shaking(HEIGHTS, "z", 3.5, 0.01, LASTING),
    Shaking(HEIGHTS, "x", 5.0, 0.003, LASTING),
)


class Judged(NamedTuple):
    """Errors, their estimates and the warning."""

    force: float
    force_estimate: float
    loop: float  # m
    loop_estimate: float  # m
    warning: str


@cache
def truth(shaking: Shaking) -> Shaken:
    """The rope on equal elements that resolve the waves."""
    return exact(SCENE, shaking, FINE)


def judged(scene: Scene, shaking: Shaking) -> Judged:
    """Errors against equal elements, and what the rope tells."""
    run = shake(scene, shaking)
    force, loop = run.rope.signals(ESTIMATES).values()
    right = truth(shaking)
    return Judged(
        end_error(run.forces, right.forces),
        force,
        place_error(run.places, right.places),
        loop,
        run.rope.warnings().get("unresolved_waves", ""),
    )


@pytest.mark.parametrize("shaking", UNRESOLVED, ids=str)
def test_an_end_that_shakes_faster_than_the_legs_resolve_is_estimated_and_told(
    shaking: Shaking,
) -> None:
    found = judged(SCENE, shaking)
    assert found.force > 2 * SCENE.accuracy.end_force
    assert 1 / OTHER_FACTOR < found.force_estimate / found.force < OTHER_FACTOR
    assert 1 / OTHER_FACTOR < found.loop_estimate / found.loop < OTHER_FACTOR
    assert "an end shakes sideways" in found.warning
    told = float(found.warning.split("its waves of ")[1].split(" Hz")[0])
    assert_allclose(told, shaking.frequency, rtol=0.15)


@pytest.mark.parametrize("shaking", UNRESOLVED, ids=str)
def test_the_mesh_for_its_frequency_keeps_what_is_asked(shaking: Shaking) -> None:
    scene = SCENE.with_(mesh=Mesh("auto", lateral_frequency=shaking.frequency))
    found = judged(scene, shaking)
    assert found.force < 0.5 * scene.accuracy.end_force
    assert found.loop < scene.accuracy.loop
    assert not found.warning


def recorded(part: str) -> Table:
    """A part of the recorded map, of the default mesh, where the end forces err by more than ``WRONG``."""
    table = rows(TABLES[part], mesh="default")
    return where(table, table["force error"] > WRONG)


@pytest.mark.parametrize("part", ["long_leg", "short_leg"])
def test_on_the_map_of_the_default_mesh_the_force_estimate_is_within_a_factor_of_three(
    part: str,
) -> None:
    table = recorded(part)
    ratio = table["force estimate"] / table["force error"]
    assert len(ratio) > 8
    assert (ratio > 1 / FACTOR).all()
    assert (ratio < FACTOR).all()


@pytest.mark.parametrize("part", ["long_leg", "short_leg", "deep"])
def test_on_the_map_all_default_meshes_that_err_by_more_than_asked_warn(part: str) -> None:
    table = recorded(part)
    wrong = table["force error"] > 2 * SCENE.accuracy.end_force
    assert wrong.any()
    assert table["warned"][wrong].all()


@pytest.mark.parametrize("part", ["long_leg", "short_leg", "deep"])
def test_on_the_map_the_mesh_for_the_frequency_keeps_what_is_asked_of_it(part: str) -> None:
    """Up to FASTEST; at 5 Hz the end forces err by up to 0.5 %, and steps of the exact run have a part of it."""
    waves = rows(TABLES[part], mesh="waves")
    table = where(waves, waves["frequency [Hz]"] < FASTEST)
    assert (table["force error"] < SCENE.accuracy.end_force).all()
    assert (table["loop error [m]"] < SCENE.accuracy.loop).all()
