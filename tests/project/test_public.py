"""What users get: the names of rope_model, both forms of the rope, the bill of materials, the wheel."""

import base64
import copy
import hashlib
import importlib.metadata
import json
import pickle
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from documents import EXAMPLES, ROOT, lines_of, readme_code
from numpy.testing import assert_allclose
from shared import Capture, Patch

import fmu_src
import hoist_demo
import rope_model
from fmu_src.interface import variables
from fmu_src.model_description import MODEL
from fmu_src.native.export import rope_sources, shell_sources
from fmu_src.reference_run import reference_files
from fmu_src.shell.build import PLATFORMS
from fmu_src.shell.start import without_start
from fmu_src.shell.table import start_values
from hoist_demo.command_line.main import main
from release.bill import bill_of_materials
from release.libraries import libraries
from release.trial import try_wheel
from release.wheels import PACKAGES, add_bill, build
from rope_model import (
    EndMotion,
    Mesh,
    PointForces,
    Rope,
    Scene,
    Solver,
    balance_rope,
    engine,
    public,
    rope_120,
)
from rope_model.codegen import build as rope_build
from rope_model.codegen.build import library
from rope_model.compiler import cache_folder, find_compiler, last_words
from rope_model.engine import NativeRope

PYTHON = "Use the rope in Python"
SMALL = Scene(rope=Rope(length=60.0), mesh=Mesh("eem", elements=20))
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
    library()
    for made in (
        *cache_folder().glob("processor-*"),
        library(),
        *cache_folder().glob("generated-*.json"),
    ):
        shutil.copy(made, folder)
    monkeypatch.setenv("BALANCE_ROPE_CACHE", str(folder))
    return folder


def compiled(cache: Path) -> list[str]:
    """What is compiled there, but for what was asked about the processor."""
    return [
        file.name
        for file in cache.iterdir()
        if file.suffix != ".json" and not file.name.startswith("processor")
    ]


@needs_compiler
def test_readme_example_prints_the_weight_of_the_left_leg_and_compiles_no_more(
    cache: Path, tmp_path: Path
) -> None:
    force, unit = lines_of(readme_code(PYTHON, tmp_path), cache)[-1].split()
    # the loop hangs at (120 - 90) / 2 m of the rope; its bend is even
    assert_allclose(float(force), -15.0 * WEIGHT, rtol=1e-3)
    assert unit == "N"
    assert compiled(cache) == [library().name]


@needs_compiler
def test_a_host_of_one_s_own_winds_the_rope_and_compiles_nothing_but_the_native_rope(
    cache: Path,
) -> None:
    *told, at_rest, last = lines_of(EXAMPLES / "own_host.py", cache)
    left, right = map(float, re.findall(r"'(?:left|right).fy': (-[\d.]+)", at_rest))
    # half a metre of rope: waves still run through it
    assert_allclose([left, right], [-25.0 * WEIGHT, -95.0 * WEIGHT], atol=0.5 * WEIGHT)
    assert sum("again the same: True" in line for line in (*told, at_rest)) == 9
    assert re.match(r"\d{4} signals;", last)
    assert "no warnings" in last
    assert compiled(cache) == [library().name]


@pytest.mark.parametrize(
    ("module", "unloaded"),
    [
        ("rope_model", "numpy"),
        ("rope_model.parameters", "casadi"),
        # a command's own module comes when the command is asked for
        ("hoist_demo.command_line.main", "numpy"),
    ],
)
def test_importing_loads_no_more_than_it_needs(module: str, unloaded: str) -> None:
    code = f"import sys, {module}; sys.exit({unloaded!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False, cwd=ROOT).returncode == 0


def test_signals_are_read_by_name_in_the_order_asked_for() -> None:
    rope = balance_rope(SMALL)
    assert rope.initialize(2.0, EndMotion(), EndMotion(y=10.0)).valid
    assert (rope.time, rope.fidelity) == (2.0, "torsional")
    every = rope.signals()
    assert [*every] == [name for name in public.SIGNALS if not name.endswith("added_mass")]
    names = ("right.fy", "left.mx", "count.steps")
    some = rope.signals(names)
    assert [*some] == [*names]
    assert some["right.fy"] == every["right.fy"]
    assert rope.signals(["left.added_mass"])["left.added_mass"] == rope.added_mass()[0]
    with pytest.raises(ValueError, match=r"'left\.force' is no signal"):
        rope.signals(["left.fy", "left.force"])
    for read in (rope.signals, rope.reader):
        with pytest.raises(ValueError, match=r"'left\.fy' is one text .* give \['left\.fy'\]"):
            read("left.fy")
    assert rope.advance_to(2.1, EndMotion(), EndMotion(y=10.0)).valid
    assert rope.signals(names)["count.steps"] > some["count.steps"]


NO_NUMBERS = (None, True, np.True_, np.array(60.0), [60.0], 60 + 0j)


@pytest.mark.parametrize("value", NO_NUMBERS, ids=repr)
def test_a_parameter_that_is_no_number_is_refused_with_value_bound_and_cure(value: Any) -> None:
    for make, name in (
        (lambda: Rope(length=value), "length"),
        (lambda: Mesh(elements=value), "elements"),
        (lambda: Mesh(counts=(2, 4, value, 4, 2)), "element count of segment IV"),
        (lambda: Solver(step_max=value), "step_max"),
        (lambda: public.rope("34x7", diameter=value), "diameter"),
        (lambda: public.rope("34x7", 0.046).rope(axial_stiffness=value), "axial_stiffness"),
    ):
        with pytest.raises(ValueError, match=re.escape(f"{name} = {value!r}")) as refused:
            make()
        assert str(refused.value).endswith(
            "must be a number; give one, or leave it out for the default"
        )


def test_numbers_of_numpy_and_whole_numbers_without_a_fraction_are_parameters() -> None:
    assert Rope(length=np.float32(60.0)).length == Rope(length=np.int64(60)).length == 60.0
    assert Mesh(elements=16.0).elements == 16  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"elements = 16\.5 .* a whole number; leave out"):
        Mesh(elements=16.5)  # type: ignore[arg-type]
    for wrong in (None, 5, (2, 4)):
        with pytest.raises(ValueError, match=r"counts = .* must be five numbers"):
            Mesh(counts=wrong)  # type: ignore[arg-type]


def test_a_rope_is_the_engine_by_default_and_keeps_its_data_during_a_run() -> None:
    rope = balance_rope(SMALL)
    assert rope.initialize(0.0, EndMotion(), EndMotion()).valid
    assert rope.form == "native"
    with pytest.raises(ValueError, match="form = 'compiled' must be"):
        balance_rope(SMALL, "compiled")  # type: ignore[arg-type]
    with pytest.raises(
        ValueError, match=r"rope\.EI = 9 must stay .* during a run: make a new rope"
    ):
        rope.retune(replace(SMALL, rope=replace(SMALL.rope, EI=9.0)))


@pytest.fixture
def compiler(monkeypatch: Patch) -> Callable[[tuple[str, ...] | None], None]:
    """A function that gives the rope this compiler, where neither package nor process has its library."""

    def give(command: tuple[str, ...] | None) -> None:
        monkeypatch.setattr(rope_build, "find_compiler", lambda: command)
        monkeypatch.setattr(rope_build, "prebuilt_file", lambda *_: Path("nowhere"))
        monkeypatch.setattr(engine, "library", rope_build.library.__wrapped__)
        monkeypatch.setattr(NativeRope, "_library", staticmethod(engine._load.__wrapped__))

    return give


@pytest.mark.parametrize(
    ("command", "told"),
    [
        (
            None,
            r"needs a C compiler; install one, or ziglang: pip install 'balance-rope\[compiler\]'",
        ),
        (
            ("no-such-cc",),
            r"cannot be had: .*no-such-cc.*; repair the compiler, name another in CC",
        ),
        ((sys.executable,), r"cannot be had: .*; repair the compiler, name another in CC"),
    ],
)
def test_a_rope_without_a_working_compiler_is_refused_in_a_sentence_that_names_the_extra(
    compiler: Callable[[tuple[str, ...] | None], None],
    command: tuple[str, ...] | None,
    told: str,
) -> None:
    compiler(command)
    with pytest.raises(RuntimeError, match=told) as refused:
        balance_rope(SMALL)
    assert "\n" not in str(refused.value)
    assert balance_rope(SMALL, "reference").elements == 20


def test_an_fmu_that_is_exported_without_a_compiler_has_no_reference_run_and_says_so(
    compiler: Callable[[tuple[str, ...] | None], None], caplog: pytest.LogCaptureFixture
) -> None:
    compiler(None)
    # no other test makes the reference run of this level, which is kept in the process
    assert reference_files(rope_120("reference"), "rope", ["left.fy"], native=True) == {}
    assert "the FMU has no reference run to check it by: the native rope needs" in caplog.text


@needs_compiler
@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda rope: pickle.loads(pickle.dumps(rope))]
)
def test_a_copy_of_the_native_rope_goes_on_by_itself(copied: Callable[[Any], Any]) -> None:
    low = EndMotion()
    high = EndMotion(y=20.0)
    rope = balance_rope(SMALL)
    copied(rope)  # not initialised yet
    rope.apply(
        PointForces(np.array([9.0]), np.zeros((1, 3)), np.array([[40.0, 0.0, 0.0]]), 0.0, 0.1)
    )
    assert rope.initialize(0.0, low, high).valid
    other = copied(rope)
    assert other.advance_to(0.1, EndMotion(y=0.01, vy=0.2, ay=2.0), high).valid
    assert rope.time == 0.0
    assert rope.advance_to(0.1, EndMotion(y=0.01, vy=0.2, ay=2.0), high).valid
    expected = rope.signals()
    del rope
    assert other.signals() == expected


PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_every_package_is_typed_and_tells_the_version() -> None:
    for package in (rope_model, fmu_src, hoist_demo):
        assert package.__version__ == importlib.metadata.version("balance-rope")
        assert Path(str(package.__file__)).with_name("py.typed").exists()


def test_a_study_without_its_packages_names_the_extra(
    tmp_path: Path, monkeypatch: Patch, capsys: Capture
) -> None:
    monkeypatch.setitem(sys.modules, "dask.distributed", None)
    monkeypatch.delitem(sys.modules, "hoist_demo.study.cluster", raising=False)
    assert main(["study", str(tmp_path / "study.toml")]) == 2
    assert (
        "a study needs dask.distributed: pip install 'balance-rope[study]'"
        in capsys.readouterr().err
    )


def test_the_bill_names_every_file_with_its_hash_and_every_package_that_is_needed(
    tmp_path: Path,
) -> None:
    (tmp_path / "a.whl").write_bytes(b"wheel")
    bill = json.loads(bill_of_materials([tmp_path / "a.whl"]))
    parts = {part["name"]: part for part in bill["components"]}
    assert parts["a.whl"]["hashes"] == [
        {"alg": "SHA-256", "content": hashlib.sha256(b"wheel").hexdigest()}
    ]
    bounds = set()
    for part in parts.values():
        bounds |= {p["value"] for p in part.get("properties", ())}
    assert bounds == {*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["study"]}
    references = [part["bom-ref"] for part in bill["components"]]
    assert len(set(references)) == len(references)
    assert set(bill["dependencies"][0]["dependsOn"]) == set(references) - {"file:a.whl"}


def test_the_bill_lies_in_the_wheel_and_in_its_record(tmp_path: Path) -> None:
    wheel = tmp_path / "some.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("some.py", "1\n")
        archive.writestr("some-1.dist-info/RECORD", "some.py,,\n")
    add_bill(wheel)
    with zipfile.ZipFile(wheel) as archive:
        name = "some-1.dist-info/sboms/balance-rope.cdx.json"
        data = archive.read(name)
        record = archive.read("some-1.dist-info/RECORD").decode()
    assert json.loads(data)["bomFormat"] == "CycloneDX"
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    assert record == f"some.py,,\n{name},sha256={digest},{len(data)}\n"


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_a_library_of_the_wheel_serves_an_export_of_any_level(fmi: int) -> None:
    table = variables(rope_120("draft"))
    wanted = without_start(
        {**rope_sources(), **shell_sources(table, fmi)}, len(start_values(table, fmi))
    )
    assert [one.identifier for one in libraries() if one.sources == wanted] == [MODEL]


@pytest.mark.slow
def test_the_wheel_needs_no_compiler_and_exports_what_a_checkout_does(tmp_path: Path) -> None:
    _, wheel = sorted(build(tmp_path), key=lambda path: path.suffix == ".whl")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    tops = {name.split("/")[0] for name in names if ".dist-info/" not in name}
    assert tops == {*PACKAGES}
    for one in ("rope_model/csrc/prebuilt/rope", "fmu_src/shell/prebuilt/BalanceRope"):
        for platform in PLATFORMS:
            assert any(name.startswith(f"{one}-{platform}-") for name in names), (one, platform)
    try_wheel(wheel)


def test_of_what_a_compiler_says_its_first_error_is_told() -> None:
    named = "In function 'error_signals':\na.c:1:6: error: no such name\n ^"
    linked = "undefined reference to 'g'\ncollect2: error: ld returned 1"
    for said, first in (
        (named, "a.c:1:6: error: no such name"),
        (linked, "reference to 'g'"),
        ("", "status 1."),
    ):
        assert last_words(subprocess.CalledProcessError(1, "cc", stderr=said)).endswith(first)
