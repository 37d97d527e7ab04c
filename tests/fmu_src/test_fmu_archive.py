"""What a reviewer of components checks in an FMU, on every kind that is exported."""

import importlib.util
import os
import posixpath
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import pytest
from checkout import ROOT
from exports import ARCHIVES, ARCHIVES_EVERYWHERE
from fmpy.validation import validate_fmu
from lark import Lark
from native_parts import WARNINGS

from fmu_src.interface import variables
from fmu_src.native.export import HEADERS_IN_FMU
from fmu_src.profile import ALL, ALWAYS, DEFAULT, output_group
from fmu_src.shell.build import PLATFORMS, available_platforms, host_platform
from fmu_src.shell.sources import HEADERS
from hoist_demo.cases.table import find_case
from hoist_demo.drive_fmu.description import drive_model
from rope_model.cases import rope_120
from rope_model.reference.outputs import COMPUTED_NAMES

#: what may lie in an archive, FMI 2.0.4 section 2.3 and FMI 3.0 section 2.5
LAYOUT = re.compile(
    r"modelDescription\.xml|model\.png|binaries/[^/]+/[^/]+\.(so|dll|dylib)|sources/(fmi/fmi\w+\.h|[^/]+\.(c|h|inc|xml))|"
    r"documentation/(index\.html|externalDependencies\.txt|licenses/[^/]+\.txt)|extra/[^/]+\.[^/]+/.+|resources/.+|"
    r"terminalsAndIcons/(terminalsAndIcons\.xml|[^/]+\.(png|svg))"
)
STRAY = re.compile(r"__pycache__|\.pyc$|\.DS_Store|Thumbs\.db|~$|/\.")


class Archive:
    """An FMU and its model description; variables alike for FMI 2 and 3."""

    def __init__(self, kind: str, path: Path) -> None:
        self.kind = kind.removesuffix(" everywhere")
        self.path = path
        self.everywhere = kind in ARCHIVES_EVERYWHERE
        with zipfile.ZipFile(path) as archive:
            self.entries = archive.infolist()
            self.files = {entry.filename: archive.read(entry) for entry in self.entries}
        self.root: Element = ElementTree.fromstring(self.files["modelDescription.xml"])
        self.fmi = int(self.root.get("fmiVersion", "")[0])
        self.native = any(name.startswith("sources/") for name in self.files)

    @property
    def variables(self) -> list[dict[str, Any]]:
        """Attributes of each variable, those of its type included, and the ``kind``."""
        listed = self.root.find("ModelVariables")
        if self.fmi == 2:
            return [{**v.attrib, **v[0].attrib, "kind": v[0].tag} for v in listed]
        out = []
        for v in listed:
            attributes = {**v.attrib, "kind": v.tag}
            starts = v.findall("Start")
            if starts:
                attributes["start"] = starts[0].get("value")
            out.append(attributes)
        return out

    def structure(self, section: str) -> list[Element]:
        structure = self.root.find("ModelStructure")
        if self.fmi == 2:
            return structure.findall(f"{section}/*")
        return structure.findall(section)


EVERYWHERE = [pytest.param(kind, marks=pytest.mark.slow) for kind in sorted(ARCHIVES_EVERYWHERE)]


@pytest.fixture(scope="module", params=[*sorted(ARCHIVES), *EVERYWHERE])
def fmu(request: Any, fmu_of: Callable[[str], Path]) -> Archive:
    if request.param != "python" and not available_platforms():
        pytest.skip("no C compiler: pip install ziglang")
    return Archive(request.param, fmu_of(request.param))


def test_archive_is_deflated_with_relative_forward_names_and_nothing_stray(fmu: Archive) -> None:
    names = [entry.filename for entry in fmu.entries]
    assert names == sorted(set(names))
    for entry in fmu.entries:
        name = entry.filename
        assert entry.compress_type == zipfile.ZIP_DEFLATED, name
        assert name == posixpath.normpath(name), name
        assert name.isascii(), name
        assert LAYOUT.fullmatch(name), name
        assert not STRAY.search(name), name
        assert entry.date_time == (1980, 1, 1, 0, 0, 0), name
        assert not entry.flag_bits & 1, f"{name} is encrypted"
    with zipfile.ZipFile(fmu.path) as archive:
        assert archive.testzip() is None


def test_no_text_names_a_folder_of_the_exporting_machine(fmu: Archive) -> None:
    here = [str(ROOT), str(Path.home()), tempfile.gettempdir() + os.sep]
    for name, data in fmu.files.items():
        assert [place for place in here if place != "/" and place.encode() in data] == [], name


@cache
def parser_of_names(grammar: str, start: str) -> SimpleNamespace:
    """Parses names that differ in an index once: fmpy's parser takes milliseconds for each of hundreds."""
    parse = cache(Lark(grammar, start=start).parse)
    return SimpleNamespace(parse=lambda name: parse(re.sub(r"(\d)\d+", r"\1", name)))


def test_description_and_its_structured_names_are_valid_for_fmpy_and_its_schema(
    fmu: Archive, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lark.Lark", parser_of_names)
    assert fmu.root.get("variableNamingConvention") == "structured"
    assert validate_fmu(str(fmu.path)) == []


def test_every_variable_is_described_and_every_number_has_a_declared_unit(fmu: Archive) -> None:
    units = {unit.get("name"): unit for unit in fmu.root.iter("Unit")}
    displayed = set()
    for name, unit in units.items():
        assert unit.find("BaseUnit") is not None, name
        displayed |= {(name, display.get("name")) for display in unit.iter("DisplayUnit")}
    types = {}
    for node in fmu.root.findall("TypeDefinitions/*"):
        if fmu.fmi == 3:
            types[node.get("name")] = node
        else:
            types[node.get("name")] = node[0]
    for v in fmu.variables:
        assert v.get("description") or v["causality"] == "independent", v["name"]
        if v["kind"] not in ("Real", "Float64") or v["causality"] == "independent":
            continue
        declared = types.get(v.get("declaredType"))
        unit = v.get("unit")
        if declared is not None:
            unit = unit or declared.get("unit")
            assert declared.get("unit") == unit, v["name"]
            assert (
                declared.get("displayUnit") is None
                or (unit, declared.get("displayUnit")) in displayed
            ), v["name"]
        assert unit in units, v["name"]


def test_start_values_are_there_exactly_where_the_standard_wants_them_and_within_bounds(
    fmu: Archive,
) -> None:
    for v in fmu.variables:
        given = v["causality"] in ("parameter", "input")
        if v["causality"] in ("output", "independent"):
            assert "start" not in v, v["name"]
        assert ("start" in v) == given, v["name"]
        if v["causality"] == "output":
            assert v["initial"] == "calculated", v["name"]
        if given and v["kind"] in ("Real", "Integer", "Float64", "Int32"):
            for start in v["start"].split():
                assert float(v.get("min", start)) <= float(start) <= float(v.get("max", start)), v[
                    "name"
                ]


def test_outputs_are_listed_in_order_and_depend_on_nothing_at_their_instant(fmu: Archive) -> None:
    """FMI 2.0.4, section 2.2.8; FMI 3.0, section 2.4.8.  test_dependencies shows that it is so, and what starts act."""
    if fmu.fmi == 2:
        at = "index"
        sections = ("Outputs", "InitialUnknowns")
        places = [str(i) for i, _ in enumerate(fmu.variables, start=1)]
    else:
        at = "valueReference"
        sections = ("Output", "InitialUnknown")
        places = [v["valueReference"] for v in fmu.variables]
    outputs = {
        v["name"]: place
        for place, v in zip(places, fmu.variables, strict=True)
        if v["causality"] == "output"
    }
    for section, dependencies in zip(sections, ("", None), strict=True):
        unknowns = fmu.structure(section)
        assert [unknown.get(at) for unknown in unknowns] == list(outputs.values()), section
        listed = {unknown.get(at): unknown.get("dependencies") for unknown in unknowns}
        # FMI Library says that there is no information, where no output depends on anything
        assert listed.pop(outputs["status.message"]) is None
        # the rope's outputs depend on everything while initialising
        if dependencies == "" or not fmu.kind.startswith("drive"):
            assert set(listed.values()) == {dependencies}, section
        assert {unknown.get("dependenciesKind") for unknown in unknowns} == {None}, section


def test_variables_have_the_value_references_of_the_whole_table_whatever_is_described(
    fmu: Archive,
) -> None:
    if fmu.kind.startswith("drive"):
        # equal names: one rope
        whole = [v.name for v in drive_model(find_case("rope-120")).variables]
    else:
        whole = [v.name for v in variables(rope_120())]
    for v in fmu.variables:
        if v["causality"] == "independent":
            expected = len(whole)
        elif v["name"] in whole:
            expected = whole.index(v["name"])
        else:
            expected = whole.index(f"{v['name']}[1]")
        assert int(v["valueReference"]) == expected, v["name"]


def test_variables_are_listed_by_use(fmu: Archive) -> None:
    """Inputs, outputs, parameters: a tool shows them in this order, and the forces are on its first page."""
    causalities = [v["causality"] for v in fmu.variables if v["causality"] != "independent"]
    assert causalities == sorted(causalities, key=["input", "output", "parameter"].index)
    names = [v["name"] for v in fmu.variables]
    assert names.index("left.y") < 30
    if not fmu.kind.startswith("drive"):
        parameters = [v["name"] for v in fmu.variables if v["causality"] == "parameter"]
        assert parameters[0] == "rope.length"
        assert max(
            map(parameters.index, ("left.swivel.mode", "inputs_at_step_end"))
        ) < parameters.index("mesh.kind")


def test_outputs_are_those_of_the_profile(fmu: Archive) -> None:
    if fmu.kind.startswith("drive"):
        pytest.skip("the drive has one profile")
    groups = {output_group(v["name"]) for v in fmu.variables if v["causality"] == "output"}
    lean = {*DEFAULT}
    least = {*ALWAYS}
    shown = {"python-lean": lean, "native-2-lean": lean, "native-3-least": least}
    computed = {*ALL}
    if not fmu.native:
        computed = {*map(output_group, COMPUTED_NAMES), "status"}
    assert groups == shown.get(fmu.kind, {*ALL}) & computed
    arrays = [v.get("name") for v in fmu.root.iter() if v.find("Dimension") is not None]
    # parameters are scalars: importers without arrays read them all, and print an error for each array
    assert bool(arrays) == (fmu.kind == "native-3")
    # nothing beside the description names what is not described
    names = {v["name"] for v in fmu.variables}
    # FMI Library refuses terminals of FMI 2, whose fmiVersion the schema wants to be 3.0
    assert ("terminalsAndIcons/terminalsAndIcons.xml" in fmu.files) == (fmu.fmi == 3)
    if fmu.fmi == 3:
        terminals = ElementTree.fromstring(fmu.files["terminalsAndIcons/terminalsAndIcons.xml"])
        assert {
            member.get("variableName") for member in terminals.iter("TerminalMemberVariable")
        } <= names
    results = next(data for name, data in fmu.files.items() if name.endswith("_ref.csv"))
    head = results.decode().partition("\n")[0]
    assert set(re.findall(r'"([^"]+)"', head)) - {"time"} <= names | {
        head.partition(",")[0].strip('"')
    }
    assert ("shape.tension" in fmu.files["documentation/index.html"].decode()) == (
        "shape" in groups
    )


def test_reader_finds_documentation_licence_and_picture(fmu: Archive) -> None:
    page = fmu.files["documentation/index.html"].decode()
    assert page.startswith("<!DOCTYPE html>")
    inputs = [v["name"].partition("[")[0] for v in fmu.variables if v["causality"] == "input"]
    assert [name for name in inputs if name not in page] == []
    assert "120 m rope" not in page, "the start values are this export's"
    assert re.search(r"(src|href)=\"https?://", page) is None, "the page loads from the network"
    assert any(name.startswith("documentation/licenses/") for name in fmu.files)
    assert fmu.root.get("license")
    pictures = [name for name in fmu.files if name.endswith(".png")]
    assert pictures
    for name in pictures:
        assert fmu.files[name].startswith(b"\x89PNG\r\n\x1a\n"), name
    assert fmu.fmi == 3 or "model.png" in pictures
    assert fmu.native or "documentation/externalDependencies.txt" in fmu.files


def test_default_experiment_and_build_are_stated(fmu: Archive) -> None:
    experiment = fmu.root.find("DefaultExperiment")
    assert float(experiment.get("stopTime", "0")) > float(experiment.get("startTime", "0"))
    assert float(experiment.get("stepSize", "0")) > 0
    starts = {v["name"]: v.get("start") for v in fmu.variables}
    tolerance = None
    if "accuracy.end_force" in starts:
        tolerance = f"{float(starts['accuracy.end_force']):g}"
    assert experiment.get("tolerance") == tolerance
    assert fmu.root.get("version")
    assert fmu.root.get("generationTool")
    assert re.fullmatch(
        r"[0-9a-f-]{36}", fmu.root.get("guid") or fmu.root.get("instantiationToken") or ""
    )


def test_binary_of_every_promised_platform_exports_every_function(fmu: Archive) -> None:
    identifier = fmu.root.find("CoSimulation").get("modelIdentifier")
    binaries = {name: data for name, data in fmu.files.items() if name.startswith("binaries/")}
    assert {name.rpartition("/")[2].partition(".")[0] for name in binaries} == {identifier}
    folders = {host_platform()}
    if fmu.everywhere:
        folders = {*available_platforms()}
    if fmu.fmi == 2:
        folders = {PLATFORMS[platform].folder2 for platform in folders}
    assert {name.split("/")[1] for name in binaries} == folders
    header = (HEADERS / f"fmi{fmu.fmi}Functions.h").read_text(encoding="utf-8")
    promised = set(
        re.findall(rf"^#define (fmi{fmu.fmi}\w+)\s+fmi{fmu.fmi}FullName", header, re.MULTILINE)
    )
    assert len(promised) > 30
    checked = [name for name in binaries if exported_symbols(fmu, name) is not None]
    for name in checked:
        assert (exported_symbols(fmu, name) or set()) == promised, name
    if shutil.which("nm"):
        assert any(name.endswith(".so") for name in checked)


def exported_symbols(fmu: Archive, name: str) -> set[str] | None:
    """Defined dynamic symbols; None where no tool here reads the format."""
    for command in (
        ["nm", "-D", "--defined-only"],
        ["llvm-nm", "--defined-only", "--extern-only"],
        ["objdump", "-p"],
    ):
        if shutil.which(command[0]):
            found = set(re.findall(r"\b_?(fmi[23]\w+)", inspect_binary(fmu, name, command)))
            if found:
                return found
    return None


def inspect_binary(fmu: Archive, name: str, command: list[str]) -> str:
    """What a tool says of a binary; '' when it cannot read it."""
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(fmu.path) as archive:
        path = archive.extract(name, folder)
        return subprocess.run([*command, path], capture_output=True, text=True, check=False).stdout


@pytest.mark.skipif(shutil.which("readelf") is None, reason="readelf is not installed")
def test_library_needs_the_c_library_alone(fmu: Archive) -> None:
    """Python's functions, too, are looked up when the library runs; it loads in tools that have none."""
    libraries = [
        name for name in fmu.files if name.startswith("binaries/") and name.endswith(".so")
    ]
    assert libraries
    allowed = {"libc.so.6", "libm.so.6", "ld-linux-aarch64.so.1", "ld-linux-x86-64.so.2"}
    if not fmu.native:
        # parts of the C library of their own before glibc 2.34; ziglang 0.13 names both
        allowed |= {"libdl.so.2", "libpthread.so.0"}
    for name in libraries:
        dynamic = inspect_binary(fmu, name, ["readelf", "-d"])
        needed = set(re.findall(r"\(NEEDED\).*\[(.+)\]", dynamic))
        assert needed <= allowed, name
        assert "RPATH" not in dynamic, name
        assert "RUNPATH" not in dynamic, name
        # of 2013: runs wherever a tool runs
        versions = re.findall(r"GLIBC_2\.(\d+)", inspect_binary(fmu, name, ["readelf", "-V"]))
        assert max(map(int, versions)) <= 17, name
        open_ = re.findall(r"UND (\w+)", inspect_binary(fmu, name, ["readelf", "--dyn-syms", "-W"]))
        assert [
            symbol for symbol in open_ if symbol.startswith(("Py", "_Py", "fmi2", "fmi3"))
        ] == [], name


def test_sources_are_complete(fmu: Archive) -> None:
    if not fmu.native:
        pytest.skip("the Python FMU's code is in its resources")
    listed = ElementTree.fromstring(fmu.files["sources/buildDescription.xml"])
    shared, static = listed.findall("BuildConfiguration")
    files = {str(node.get("name")) for node in shared.iter("SourceFile")}
    assert files == {str(node.get("name")) for node in static.iter("SourceFile")}
    assert files == {
        name.removeprefix("sources/") for name in fmu.files if re.fullmatch(r"sources/.+\.c", name)
    }
    if fmu.fmi == 2:
        assert {node.get("name") for node in fmu.root.find("CoSimulation").iter("File")} == files
    identifier = fmu.root.find("CoSimulation").get("modelIdentifier")
    for one, expected in (
        (shared, (f"FMI{fmu.fmi}_OVERRIDE_FUNCTION_PREFIX", "1")),
        (static, (f"FMI{fmu.fmi}_FUNCTION_PREFIX", f"{identifier}_")),
    ):
        assert one.get("modelIdentifier") == identifier
        assert [
            (node.get("name"), node.get("value")) for node in one.iter("PreprocessorDefinition")
        ] == [expected]
    for name, data in fmu.files.items():
        if name.startswith("sources/"):
            for header in re.findall(r'(?m)^#include "(.+)"', data.decode()):
                # the standard has no headers of FMI beside the sources
                folder = "sources"
                if (HEADERS / header).exists():
                    folder = f"sources/{HEADERS_IN_FMU}"
                assert f"{folder}/{header}" in fmu.files, (name, header)


@pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason="ziglang is not installed")
@pytest.mark.parametrize(
    "fmu", ["drive-2", pytest.param("native-3", marks=pytest.mark.slow)], indirect=True
)
@pytest.mark.parametrize(
    "platform", ["x86_64-windows", pytest.param("aarch64-darwin", marks=pytest.mark.slow)]
)
def test_sources_compile_for_other_systems(platform: str, fmu: Archive, tmp_path: Path) -> None:
    """Without a warning, with their headers and types, to no machine code: the slow tests make that everywhere.

    The drive has the sources of FMI 2.0, the rope of FMI 3.0 all others.
    """
    sources = {
        name.removeprefix("sources/"): data
        for name, data in fmu.files.items()
        if name.startswith("sources/")
    }
    for name, data in sources.items():
        (tmp_path / Path(name).name).write_bytes(data)
    headers = Path(importlib.import_module("ziglang").__file__ or "").parent / "lib"
    folders = [
        headers / "include",
        headers / "libc" / "include" / f"any-{platform.partition('-')[2]}-any",
    ]
    clang = [
        sys.executable,
        "-m",
        "ziglang",
        "clang",
        f"--target={PLATFORMS[platform].target}",
        "-std=c99",
    ]
    # CasADi's text is not ours to warn of, and what fills its array is no text
    quiet = (
        "unused-parameter",
        "unused-function",
        "unused-variable",
        "unterminated-string-initialization",
    )
    # older compilers have not all of these warnings
    quiet = (*quiet, "unknown-warning-option")
    clang += [*WARNINGS, *(f"-Wno-{kind}" for kind in quiet)]
    command = [
        *clang,
        "-fsyntax-only",
        "-nostdlibinc",
        *(f"-isystem{folder}" for folder in folders),
    ]
    # the narrower forms are the same text as the widest
    narrower = ("chains_plain.c", "chains_wide.c")
    command += [name for name in sources if name.endswith(".c") and name not in narrower]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
