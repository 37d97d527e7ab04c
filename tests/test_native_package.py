"""The native FMU's descriptions, packaging and tables, and the command that exports it, on a stand-in for the rope."""

import ctypes
import math
import platform
import shutil
import zipfile
from pathlib import Path

import fmpy
import pytest
from end_paths import NO_LIMITS
from fmpy.build import build_platform_binary
from lxml import etree
from native_host import Host
from stand_in import stand_in

import rope_model
from balance_rope import main
from fmu_src.interface import variables
from fmu_src.native.build import host_platform, open_library
from fmu_src.native.export import export_native
from fmu_src.profile import FULL
from rope_model import EndMotion, Inputs, rope_120
from rope_model.engine import NativeRope
from rope_model.simulation.ends.ends import refusal

SCHEMAS = Path(fmpy.__file__).with_name("schema")
#: the native rope's question for the processor, and what it includes
QUESTION = ("processor.c", "processor.h")


@pytest.mark.parametrize("name", ["terminalsAndIcons/terminalsAndIcons", "sources/buildDescription"])
def test_other_descriptions_follow_their_schemas(fmi: int, fmus: dict[int, Path], name: str) -> None:
    what = name.partition("/")[2]
    with zipfile.ZipFile(fmus[fmi]) as archive:
        document = etree.fromstring(archive.read(f"{name}.xml"))
    etree.XMLSchema(file=str(SCHEMAS / "fmi3" / f"fmi3{what[0].upper()}{what[1:]}.xsd")).assertValid(document)


def test_same_sources_give_the_same_bytes_others_another_token(fmi: int, fmus: dict[int, Path], tmp_path: Path) -> None:
    again = export_native(tmp_path / "again.fmu", fmi=fmi, platforms=(host_platform(),), rope=stand_in(), profile=FULL)
    assert again.read_bytes() == fmus[fmi].read_bytes()
    long = export_native(tmp_path / "long.fmu", "rope-240", fmi=fmi, platforms=(host_platform(),), rope=stand_in())
    tokens = {fmpy.read_model_description(str(path)).guid for path in (again, long)}
    assert len(tokens) == 2


def test_bounds_of_the_inputs_are_those_of_the_rope() -> None:
    inputs = [v for v in variables(rope_120()) if v.causality == "input"]
    assert len(inputs) == 22
    for v in inputs:
        side, name = v.name.split(".")
        for bound in (v.minimum, v.maximum):
            assert bound is not None
            assert refusal(Inputs(), EndMotion(**{name: bound}), NO_LIMITS, side) == ""
            beyond = EndMotion(**{name: math.nextafter(bound, math.inf * bound)})
            assert "beyond" in refusal(Inputs(), beyond, NO_LIMITS, side)


def test_sources_rebuild_with_fmpy_compile(fmi: int, fmus: dict[int, Path], tmp_path: Path) -> None:
    if shutil.which("cmake") is None:
        pytest.skip("needs cmake")
    folder = fmpy.extract(str(fmus[fmi]), str(tmp_path))
    shutil.rmtree(tmp_path / "binaries")
    build_platform_binary(folder)
    rebuilt = Host(fmus[fmi], folder)
    rebuilt.start()
    assert rebuilt.get("left.fy") == [pytest.approx(-15.0 * 8.0 * 9.81)]
    rebuilt.free()


def test_the_wide_form_is_taken_where_the_processor_has_it() -> None:
    """Whatever compiler made the library: some answer no for every processor when asked by their own function."""
    flags = Path("/proc/cpuinfo")
    if not flags.is_file() or platform.machine() != "x86_64":
        pytest.skip("asks Linux on x86_64 what the processor has")
    # made as FMUs are, by ziglang if that is there: other flags would have it make its own library anew
    files = (Path(rope_model.__file__).with_name("csrc") / "numerics" / name for name in QUESTION)
    texts = {file.name: file.read_text(encoding="utf-8") for file in files}
    for library in (ctypes.CDLL(str(open_library(texts, "processor", host_platform()))), NativeRope._library()):
        assert bool(library.processor_has_avx2()) == ("avx2" in flags.read_text(encoding="utf-8").split())


def test_start_values_are_set_on_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("fmu_src.native.export.rope_sources", stand_in)
    path = tmp_path / "rope.fmu"
    options = ["export", "--native", "--platform", "host", "--out", str(path)]
    assert main([*options, "--set", "air.density=1.2", "--set", "model.fidelity=torsional"]) == 0
    starts = {v.name: v.start for v in fmpy.read_model_description(str(path)).modelVariables}
    assert [float(starts[name]) for name in ("air.density", "model.fidelity", "rope.length")] == [1.2, 1.0, 120.0]
    for wrong, told in (
        ("air.density=-1", "air.density = -1.0 must be within 0 and 100: give it in kg/m3"),
        ("rope.length=-1", "rope.length = -1.0 must be within 1e-15 and 10000: give it in m"),
        ("hoist.payload_left=1", "--set hoist.payload_left: the FMU has the rope alone: give it to wind"),
    ):
        assert main([*options, "--set", wrong]) == 2
        assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--native", "--fmi", "2", "3", "--out", "x.fmu"], "give a folder"),
        (["--out", "file/x.fmu"], "file cannot be written to"),
        (["--out", "x.txt"], "--out x.txt must end in .fmu or name a folder: give x.fmu"),
        (["--native", "--scalar"], "add --native --fmi 3"),
    ],
)
def test_an_export_that_cannot_be_meant_is_refused_before_anything_is_built(
    options: list[str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    assert main(["export", *options]) == 2
    assert words in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
