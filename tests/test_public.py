"""What a user imports from rope_model: documented, typed, quick to load, and the same for both forms of the rope."""

import copy
import pickle
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from numpy.testing import assert_allclose
from test_examples import EXAMPLES, ROOT, lines_of, readme_code

import rope_model
from rope_model import EndMotion, Mesh, Rope, Scene, Solver, balance_rope, public
from rope_model.codegen.build import library
from rope_model.numerics.kernels import cache_folder, find_compiler

PYTHON = "Use the rope in Python"
SMALL = Scene(rope=Rope(length=60.0), mesh=Mesh("eem", elements=20), solver=Solver(kernels="portable"))
#: N/m of rope_120
WEIGHT = 8.0 * 9.81
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


def test_every_public_name_is_imported_from_the_package() -> None:
    assert {*public.__all__} <= {*dir(rope_model)}
    assert all(getattr(rope_model, name) is getattr(public, name) for name in public.__all__)
    with pytest.raises(AttributeError, match="has no attribute 'rope_simulator'"):
        rope_model.rope_simulator  # type: ignore[attr-defined]  # noqa: B018


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    folder.mkdir()
    for made in (library(), *cache_folder().glob("generated-*.json")):
        shutil.copy(made, folder)
    monkeypatch.setenv("BALANCE_ROPE_CACHE", str(folder))
    return folder


@needs_compiler
def test_readme_example_prints_the_weight_of_the_left_leg_and_compiles_no_more(cache: Path, tmp_path: Path) -> None:
    force, unit = lines_of(readme_code(PYTHON, tmp_path), cache)[-1].split()
    # the loop hangs at (120 - 90) / 2 m of the rope; its bend is even
    assert_allclose(float(force), -15.0 * WEIGHT, rtol=1e-3)
    assert unit == "N"
    assert [file.name for file in cache.iterdir() if file.suffix != ".json"] == [library().name]


@needs_compiler
def test_a_host_of_one_s_own_winds_the_rope_and_compiles_nothing_but_the_native_rope(cache: Path) -> None:
    *told, at_rest, last = lines_of(EXAMPLES / "own_host.py", cache)
    left, right = map(float, re.findall(r"'(?:left|right).fy': (-[\d.]+)", at_rest))
    # half a metre of rope: waves still run through it
    assert_allclose([left, right], [-25.0 * WEIGHT, -95.0 * WEIGHT], atol=0.5 * WEIGHT)
    assert sum("again the same: True" in line for line in (*told, at_rest)) == 9
    assert re.match(r"\d{3} signals;", last)
    assert "no warnings" in last
    assert [file.name for file in cache.iterdir() if file.suffix != ".json"] == [library().name]


@pytest.mark.parametrize(("module", "unloaded"), [("rope_model", "numpy"), ("rope_model.parameters", "casadi")])
def test_importing_loads_no_more_than_it_needs(module: str, unloaded: str) -> None:
    code = f"import sys, {module}; sys.exit({unloaded!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False, cwd=ROOT).returncode == 0


@pytest.fixture(params=[pytest.param("native", marks=needs_compiler), "python"])
def form(request: pytest.FixtureRequest) -> public.Form:
    chosen: public.Form = request.param
    return chosen


def test_signals_are_read_by_name_in_the_order_asked_for(form: public.Form) -> None:
    rope = balance_rope(SMALL, form)
    assert rope.initialize(2.0, EndMotion(), EndMotion(y=10.0)).valid
    assert (rope.time, rope.fidelity) == (2.0, "torsional")
    every = rope.signals()
    assert [*every] == [name for name in public.SIGNALS if not name.endswith("added_mass")]
    names = ("right.fy", "left.added_mass", "count.steps")
    some = rope.signals(names)
    assert [*some] == [*names]
    assert some["right.fy"] == every["right.fy"]
    assert some["left.added_mass"] == rope.added_mass()[0]
    with pytest.raises(ValueError, match=r"'left\.force' is no signal"):
        rope.signals(["left.fy", "left.force"])
    assert rope.advance_to(2.1, EndMotion(), EndMotion(y=10.0)).valid
    assert rope.signals(names)["count.steps"] > some["count.steps"]


def test_auto_takes_the_native_form_unless_kernels_are_asked_for_by_name() -> None:
    ends = EndMotion(), EndMotion()
    choices = [SMALL, SMALL.with_(solver=Solver())] if find_compiler() else [SMALL]
    ropes = [balance_rope(scene) for scene in choices]
    assert all(rope.initialize(0.0, *ends).valid for rope in ropes)
    assert [rope.form for rope in ropes] == ["portable", "native"][: len(ropes)]
    with pytest.raises(ValueError, match="form = 'compiled' must be"):
        balance_rope(SMALL, "compiled")  # type: ignore[arg-type]


@needs_compiler
@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda rope: pickle.loads(pickle.dumps(rope))])
def test_a_copy_of_the_native_rope_goes_on_by_itself(copied: Callable[[Any], Any]) -> None:
    low, high = EndMotion(), EndMotion(y=20.0)
    rope = balance_rope(replace(SMALL, solver=Solver()), "native")
    copied(rope)  # not initialised yet
    assert rope.initialize(0.0, low, high).valid
    other = copied(rope)
    assert other.advance_to(0.1, EndMotion(y=0.01, vy=0.2, ay=2.0), high).valid
    assert rope.time == 0.0
    assert rope.advance_to(0.1, EndMotion(y=0.01, vy=0.2, ay=2.0), high).valid
    expected = rope.signals()
    del rope
    assert other.signals() == expected
