"""What is handed out: its bill of materials, and the wheel in a fresh environment without a compiler."""

import base64
import hashlib
import importlib.metadata
import json
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

import fmu_src
import hoist_demo
import rope_model
from balance_rope import main
from fmu_src.model_description import MODEL
from fmu_src.native.build import PLATFORMS
from fmu_src.native.export import native_table, rope_sources, shell_sources
from fmu_src.native.start import without_start
from fmu_src.native.table import start_values
from release.bill import bill_of_materials
from release.libraries import libraries
from release.trial import try_wheel
from release.wheels import PACKAGES, add_bill, build
from rope_model.parameters import rope_120

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_every_package_is_typed_and_tells_the_version() -> None:
    for package in (rope_model, fmu_src, hoist_demo):
        assert package.__version__ == importlib.metadata.version("balance-rope")
        assert Path(str(package.__file__)).with_name("py.typed").exists()


def test_a_study_without_its_packages_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "dask.distributed", None)
    monkeypatch.delitem(sys.modules, "hoist_demo.study.cluster", raising=False)
    assert main(["study", str(tmp_path / "study.toml")]) == 2
    assert "a study needs dask.distributed: pip install 'balance-rope[study]'" in capsys.readouterr().err


def test_the_bill_names_every_file_with_its_hash_and_every_package_that_is_needed(tmp_path: Path) -> None:
    (tmp_path / "a.whl").write_bytes(b"wheel")
    bill = json.loads(bill_of_materials([tmp_path / "a.whl"]))
    parts = {part["name"]: part for part in bill["components"]}
    assert parts["a.whl"]["hashes"] == [{"alg": "SHA-256", "content": hashlib.sha256(b"wheel").hexdigest()}]
    bounds = {p["value"] for part in parts.values() for p in part.get("properties", ())}
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
        data, record = archive.read(name), archive.read("some-1.dist-info/RECORD").decode()
    assert json.loads(data)["bomFormat"] == "CycloneDX"
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    assert record == f"some.py,,\n{name},sha256={digest},{len(data)}\n"


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_library_of_the_wheel_serves_an_export_of_any_level(fmi: int) -> None:
    table = native_table(rope_120("draft"))
    wanted = without_start({**rope_sources(), **shell_sources(table, fmi)}, len(start_values(table, fmi)))
    assert [one.identifier for one in libraries() if one.sources == wanted] == [MODEL]


@pytest.mark.slow
def test_the_wheel_needs_no_compiler_and_exports_what_a_checkout_does(tmp_path: Path) -> None:
    _, wheel = sorted(build(tmp_path), key=lambda path: path.suffix == ".whl")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    tops = {name.split("/")[0] for name in names if ".dist-info/" not in name}
    assert tops == {*PACKAGES, "balance_rope.py", "hoist_export.py"}
    for one in ("rope_model/csrc/prebuilt/rope", "fmu_src/native/prebuilt/BalanceRope"):
        assert all(any(name.startswith(f"{one}-{platform}-") for name in names) for platform in PLATFORMS)
    try_wheel(wheel)
