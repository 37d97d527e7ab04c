"""Source FMUs linked statically into one program, as their buildDescription.xml says."""

import re
import shutil
import subprocess
import zipfile
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import pytest
from checkout import NATIVE
from exports import FLAVOURS, export_drive
from native_host import H, Host
from stand_in import stand_in

from fmu_src.native.export import HEADERS_IN_FMU, export_native
from fmu_src.native.prefix import LONGEST_IDENTIFIER, checked_identifier, shared_names, with_prefix
from fmu_src.shell.build import host_platform
from fmu_src.shell.sources import HEADERS
from hoist_demo.command_line.main import main

pytestmark = [
    pytest.mark.skipif("native-2" not in FLAVOURS, reason="needs a C compiler"),
    pytest.mark.skipif(shutil.which("cmake") is None, reason="needs cmake"),
]
CMAKE = """\
cmake_minimum_required(VERSION 3.15)
project(linked C)
set(CMAKE_C_STANDARD 99)
{libraries}
add_executable(linked {host})
target_include_directories(linked PRIVATE {headers})
target_link_libraries(linked {names} m)
"""
LIBRARY = """\
add_library({name} STATIC {files})
target_compile_definitions({name} PRIVATE {definitions})
target_include_directories({name} PRIVATE {headers})
"""


def static_library(folder: Path) -> str:
    """Commands of CMake for the sources of an unpacked FMU, from its build description alone."""
    built = ElementTree.parse(folder / "sources" / "buildDescription.xml").getroot()
    (static,) = (one for one in built if str(one.get("description")).startswith("static"))
    files = [str(folder / "sources" / str(file.get("name"))) for file in static.iter("SourceFile")]
    definitions = [
        f"{one.get('name')}={one.get('value')}" for one in static.iter("PreprocessorDefinition")
    ]
    return LIBRARY.format(
        name=static.get("modelIdentifier"),
        files=" ".join(files),
        definitions=" ".join(definitions),
        headers=folder / "sources" / HEADERS_IN_FMU,
    )


def export(folder: Path, rope: Mapping[str, str] | None) -> dict[str, Path]:
    here = (host_platform(),)
    fmus = {"HoistDrive": export_drive(folder / "drive.fmu")}
    for k, name in enumerate(("RopeA", "RopeB")):
        fmus[name] = export_native(
            folder / f"{name}.fmu",
            level="draft",
            platforms=here,
            rope=rope,
            start={"rope.mass_per_length": 8.0 + k},
            identifier=name,
        )
    return fmus


@pytest.mark.usefixtures("no_reference_run")
@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_drive_two_ropes_and_a_host_link_into_one_program_that_gives_what_the_libraries_give(
    whole: bool, tmp_path: Path
) -> None:
    """With the stand-in for the rope, and with the rope's own 200 functions."""
    rope = None
    if not whole:
        rope = stand_in()
    fmus = export(tmp_path, rope)
    signals = {"HoistDrive": "left.y", "RopeA": "left.fy", "RopeB": "left.fy"}
    tokens = []
    references = {}
    libraries = []
    expected = []
    for name, fmu in fmus.items():
        folder = tmp_path / name
        host = Host(fmu, fmpy.extract(str(fmu), str(folder)))
        assert host.binary.stem == name
        host.start()
        for k in range(200):
            assert host.step(k * H) == ""
        expected += host.get(signals[name])
        tokens.append(host.description.guid)
        references[signals[name]] = host.variables[signals[name]].valueReference
        libraries.append(static_library(folder))
        host.free()
    text = CMAKE.format(
        libraries="".join(libraries),
        host=NATIVE / "linked.c",
        headers=HEADERS,
        names=" ".join(fmus),
    )
    (tmp_path / "CMakeLists.txt").write_text(text)
    build = tmp_path / "build"
    for command in (
        ["cmake", "-S", str(tmp_path), "-B", str(build)],
        ["cmake", "--build", str(build), "-j2"],
    ):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    places = [str(references[name]) for name in ("left.y", "left.fy")]
    done = subprocess.run(
        [str(build / "linked"), *tokens, *places], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    # another compiler and no optimisation: rounding, of tensions of 1e4 N
    assert [*map(float, done.stdout.split())] == pytest.approx(expected, rel=1e-9, abs=1e-6)
    assert expected[1] != expected[2]


def test_shared_names_are_those_that_the_linker_sees() -> None:
    sources = {
        "a.h": "#ifndef A_H\nextern const int TABLE[2];\nint run(int x);\n#define own(x) x\n",
        "a.c": "const int TABLE[2] = {1, 2};\nstatic int inner(int x) {\n    return outer(x);\n}\n\nint run(int x) {\n"
        "    return inner(x);\n}\nstatic const double UNSEEN[] = {0.0};\nstruct Point *point_of(\n    int i) {\n"
        "typedef int (*Function)(int);\nint own(x) {\nfmi2Status fmi2DoStep(int x) {\n",
        "fmi2Functions.h": "int not_ours(int x);\n",
    }
    assert shared_names(sources) == ["TABLE", "point_of", "run"]
    made = with_prefix(sources, "Mine", 2)
    assert made["a.c"].startswith('#include "prefix.h"\n')
    assert "#define run Mine_run\n" in made["prefix.h"]
    assert "#define FMI2_FUNCTION_PREFIX Mine_\n" in made["prefix.h"]


@pytest.mark.parametrize(
    "identifier", ["", "2nd", "my-rope", "Seil_ü", "a" * (LONGEST_IDENTIFIER + 1)]
)
def test_model_identifier_that_c_cannot_have_is_refused(identifier: str) -> None:
    with pytest.raises(ValueError, match="give a name such as MyRope"):
        checked_identifier(identifier)


@pytest.mark.usefixtures("no_reference_run")
def test_command_line_gives_the_model_identifier(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fmu_src.native.export.rope_sources", stand_in)
    options = [
        "export",
        "--platform",
        "host",
        "--out",
        str(tmp_path / "x.fmu"),
        "--model-identifier",
        "RopeA",
    ]
    assert main([*options, "--python"]) == 2
    assert main(options) == 0
    with zipfile.ZipFile(tmp_path / "x.fmu") as archive:
        names = archive.namelist()
        text = archive.read("modelDescription.xml").decode()
    assert re.findall(r'modelIdentifier="(\w+)"', text) == ["RopeA"]
    assert any(name.endswith("/RopeA.so") for name in names) or not host_platform().endswith(
        "linux"
    )
