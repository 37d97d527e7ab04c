"""The native FMU's descriptions and packaging, and what its tables hold, on a stand-in for the rope."""

import ctypes
import math
import platform
import shutil
import subprocess
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest
from end_paths import NO_LIMITS
from fmpy.build import build_platform_binary
from lxml import etree
from native_host import Host
from stand_in import stand_in

import rope_model
from fmu_src.interface import variables
from fmu_src.native.build import host_platform, open_library
from fmu_src.native.export import export_native
from fmu_src.profile import FULL
from rope_model.parameters import Inputs, rope_120
from rope_model.simulation.ends.ends import refusal
from rope_model.simulation.ends.paths import EndMotion

SCHEMAS = Path(fmpy.__file__).with_name("schema")
#: the native rope's question for the processor, and what it includes
QUESTION = ("processor.c", "processor.h")


@pytest.mark.parametrize(
    ("name", "schema"),
    [
        ("terminalsAndIcons/terminalsAndIcons.xml", "fmi3/fmi3TerminalsAndIcons.xsd"),
        ("sources/buildDescription.xml", "fmi3/fmi3BuildDescription.xsd"),
    ],
)
def test_other_descriptions_follow_their_schemas(fmi: int, fmus: dict[int, Path], name: str, schema: str) -> None:
    with zipfile.ZipFile(fmus[fmi]) as archive:
        document = etree.fromstring(archive.read(name))
    etree.XMLSchema(file=str(SCHEMAS / schema)).assertValid(document)


def test_same_sources_give_the_same_bytes_and_other_start_values_another_token(
    fmi: int, fmus: dict[int, Path], tmp_path: Path
) -> None:
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
    rebuilt.call("FreeInstance")


def made_by_cc(folder: Path) -> Path:
    """The question's library by the system's compiler."""
    made, source = folder / "processor.so", Path(rope_model.__file__).with_name("csrc") / "numerics" / QUESTION[0]
    subprocess.run(["cc", "-std=c99", "-fPIC", "-shared", str(source), "-o", str(made)], check=True)
    return made


def made_as_in_fmus(folder: Path) -> Path:
    """The same as FMUs are made, by ziglang if that is there: other flags would have it make its own library anew."""
    files = (Path(rope_model.__file__).with_name("csrc") / "numerics" / name for name in QUESTION)
    return open_library({file.name: file.read_text(encoding="utf-8") for file in files}, "processor", host_platform())


@pytest.mark.parametrize("made", [made_by_cc, made_as_in_fmus])
def test_the_wide_form_is_taken_where_the_processor_has_it(made: Callable[[Path], Path], tmp_path: Path) -> None:
    """Whatever compiler made the library: some answer no for every processor when asked by their own function."""
    flags = Path("/proc/cpuinfo")
    if not flags.is_file() or platform.machine() != "x86_64":
        pytest.skip("asks Linux on x86_64 what the processor has")
    if made is made_by_cc and not shutil.which("cc"):
        pytest.skip("no such compiler")
    asked = ctypes.CDLL(str(made(tmp_path))).processor_has_avx2()
    assert bool(asked) == ("avx2" in flags.read_text(encoding="utf-8").split())
