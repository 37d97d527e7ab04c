"""The native FMU's package: descriptions, start values and token in finished libraries, signatures, the export."""

import ctypes
import hashlib
import math
import platform
import shutil
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import fmpy
import pytest
from end_paths import NO_MEASURES
from exports import export_stand_in
from fmpy.build import build_platform_binary
from lxml import etree
from native_host import Host
from native_parts import refusal
from shared import Capture, Patch
from stand_in import stand_in

import rope_model
from fmu_src.interface import variables
from fmu_src.native.export import export_native
from fmu_src.shell import build
from fmu_src.shell.build import (
    PLATFORMS,
    available_platforms,
    host_platform,
    library,
    open_library,
)
from fmu_src.shell.mach_o import parts, universal, with_page_hashes
from fmu_src.shell.start import MAGIC, Start, c_start, with_start, without_start
from hoist_demo.cases.case import Case
from hoist_demo.command_line.main import main
from hoist_demo.export.system import HoistFiles, RopeFmu, SystemOptions
from rope_model import EndMotion, Scene, Swivel, rope_120
from rope_model.codegen.platforms import prebuilt_file
from rope_model.engine import NativeRope

pytestmark = pytest.mark.skipif(
    host_platform() not in available_platforms(), reason="needs a C compiler"
)
SOURCES = {
    "model.h": "#include <stddef.h>\nenum { TOKEN_BYTES = 64 };\ndouble model_start(size_t scalar);\n",
    "seen.c": '#include "model.h"\n#ifdef _WIN32\n__declspec(dllexport)\n#else\n'
    '__attribute__((visibility("default")))\n#endif\ndouble seen(int i) { return model_start(i); }\n',
}
#: the first library for another system takes longer than all others: that for Windows brings the start-up code of MinGW
NEEDS = {
    x: pytest.mark.skipif(x not in available_platforms(), reason="needs ziglang") for x in PLATFORMS
}
SLOW = [pytest.mark.slow]
EVERYWHERE = [pytest.param(x, marks=[NEEDS[x], *SLOW * (x != host_platform())]) for x in PLATFORMS]


def small(start: Start, name: str = host_platform()) -> bytes:
    return library(SOURCES | {"start.c": c_start(start)}, "start", name).read_bytes()


def fill(start: Start, name: str = host_platform()) -> bytes:
    return with_start(
        library(without_start(SOURCES, len(start.values)), "start", name).read_bytes(), start
    )


START = Start("{0b0d8ab1-6e23-5ba9-8b62-1d3d6a1b8e05}", (1.5, -0.0, 1e300, 5e-324), arrays=False)


@pytest.mark.parametrize("name", [n for n in EVERYWHERE if "linux" in str(n.values[0])])
def test_a_library_written_into_is_the_one_that_its_own_sources_make(name: str) -> None:
    assert fill(START, name) == small(START, name) != small(Start("", (0.0,) * 4), name)


@pytest.mark.parametrize("name", EVERYWHERE)
def test_every_platform_has_one_place_for_start_values_and_takes_them(name: str) -> None:
    made = fill(START, name)
    place = made.index(START.block())
    assert made.count(MAGIC) == 1
    assert with_start(made, Start("", (0.0,) * 4)) == fill(Start("", (0.0,) * 4), name)
    assert place % 8 == 0  # as the doubles need it


class CodeDirectory(NamedTuple):
    """Part of a signature of Mach-O libraries: hashes of the pages of code; places and sizes in bytes."""

    first_hash: int
    number_of_hashes: int
    code_limit: int
    page_size: int


def code_directory(library: bytes) -> CodeDirectory:
    signature = library.index(struct.pack(">I", 0xFADE0CC0))
    at = library.index(struct.pack(">I", 0xFADE0C02), signature)
    hashes, _, _, number, limit = struct.unpack_from(">5I", library, at + 16)
    return CodeDirectory(at + hashes, number, limit, page_size=1 << library[at + 39])


def page_hashes(library: bytes) -> tuple[bytes, bytes]:
    """Return the hashes that are right, and those in the library."""
    found = code_directory(library)
    right = b""
    for begin in range(0, found.code_limit, found.page_size):
        end = min(begin + found.page_size, found.code_limit)
        right += hashlib.sha256(library[begin:end]).digest()
    return right, library[found.first_hash : found.first_hash + 32 * found.number_of_hashes]


def oldest_macos(library: bytes) -> tuple[int, int]:
    """The version in the load command LC_BUILD_VERSION of a Mach-O library."""
    at = 32
    for _ in range(struct.unpack_from("<I", library, 16)[0]):
        command, size = struct.unpack_from("<2I", library, at)
        if command == 0x32:
            version: int = struct.unpack_from("<I", library, at + 12)[0]
            return version >> 16, version >> 8 & 255
        at += size
    raise AssertionError("the library states no version")


@pytest.mark.parametrize("name", [x for x in EVERYWHERE if "darwin" in str(x.values[0])])
def test_macos_libraries_load_from_version_11_on(name: str) -> None:
    assert oldest_macos(small(START, name)) == (11, 0)


needs_zig = pytest.mark.skipif(
    "aarch64-darwin" not in available_platforms(), reason="needs ziglang"
)


@needs_zig
@pytest.mark.slow
def test_what_is_written_into_is_signed_anew_alone_and_in_a_universal_library() -> None:
    shared = without_start(SOURCES, 4)
    pair = [
        library(shared, "start", name).read_bytes() for name in ("x86_64-darwin", "aarch64-darwin")
    ]
    whole = with_start(universal(pair), START)
    intel, arm = (whole[begin:end] for begin, end in parts(whole))
    assert (intel, arm) == (with_start(pair[0], START), with_start(pair[1], START))
    right, there = page_hashes(arm)
    assert right == there != page_hashes(pair[1])[1]


def signed(content: bytes, kind: int) -> bytes:
    """A library with nothing but what its signature needs (Mach-O, code directory), its page hashes still zero."""
    code = (
        struct.pack(
            "<8I4I", 0xFEEDFACF, 0x100000C, 0, 6, 1, 16, 0, 0, 0x1D, 16, 48 + len(content), 0
        )
        + content
    )
    slots = -(-len(code) // 4096)
    head = 0xFADE0C02, 40 + 32 * slots, 0x20400, 0, 40, 40, 0, slots, len(code)
    directory = struct.pack(">9I4B", *head, 32, kind, 0, 12)
    return (
        code
        + struct.pack(">5I", 0xFADE0CC0, 20 + len(directory), 1, 0, 20)
        + directory
        + bytes(32 * slots)
    )


def test_a_library_is_signed_anew_over_all_its_pages_and_one_of_another_kind_refused() -> None:
    library = signed(bytes(range(256)) * 40, kind=2)  # the third page ends with the code
    right, there = page_hashes(with_page_hashes(library))
    assert right == there
    assert len(right) == 3 * 32
    with pytest.raises(RuntimeError, match="kind 1"):  # SHA-1
        with_page_hashes(signed(b"", kind=1))


@pytest.mark.usefixtures("no_reference_run")
@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_exports_with_other_values_compile_once(
    fmi: int, tmp_path: Path, monkeypatch: Patch
) -> None:
    monkeypatch.setattr(build.kernels, "cache_folder", lambda: tmp_path / "cache")
    tokens = set()
    for length in (120.0, 130.0):
        path = tmp_path / f"{length}.fmu"
        start = {"rope.length": length}
        export_native(
            path, level="draft", fmi=fmi, platforms=(host_platform(),), rope=stand_in(), start=start
        )
        host = Host(path, fmpy.extract(str(path), str(tmp_path / str(length))))
        assert host.get("rope.length") == [length]
        host.free()
        tokens.add(host.description.guid or host.description.instantiationToken)
        with zipfile.ZipFile(path) as archive:
            assert f"        {length!r},\n" in archive.read("sources/start.c").decode()
    assert len(tokens) == 2
    assert len(list((tmp_path / "cache").glob("fmu-*"))) == 1


@pytest.fixture
def no_compiler(monkeypatch: Patch, tmp_path: Path) -> Path:
    monkeypatch.setattr(build, "_PACKAGE", tmp_path)
    monkeypatch.setattr(build, "_compilable", lambda: set[str]())
    monkeypatch.setattr(build.kernels, "find_compiler", lambda: None)
    return tmp_path


def test_a_library_of_the_package_is_taken_for_its_own_sources_only(no_compiler: Path) -> None:
    sources = {"a.c": "int a;", "fmi2Functions.h": "/* of FMI */"}
    path = prebuilt_file(no_compiler, sources, "rope", "x86_64-windows")
    path.parent.mkdir()
    path.write_bytes(b"MZ")
    assert library(sources, "rope", "x86_64-windows").read_bytes() == b"MZ"
    assert available_platforms() == ("x86_64-windows",)
    for other in (
        {"a.c": "int b;"},
        {"b.c": "int a;"},
        sources | {"fmi2Functions.h": "/* of another FMI */"},
    ):
        with pytest.raises(
            ValueError, match=r"no compiled rope for 'x86_64-windows'.*'balance-rope\[compiler\]'"
        ):
            library(other, "rope", "x86_64-windows")


SCHEMAS = Path(fmpy.__file__).with_name("schema")
#: the native rope's question for the processor, and what it includes
QUESTION = ("processor.c", "processor.h")


def test_other_descriptions_follow_their_schemas(fmi: int, fmu_of: Callable[[str], Path]) -> None:
    names = ["sources/buildDescription"]
    if fmi == 3:
        names.append("terminalsAndIcons/terminalsAndIcons")
    with zipfile.ZipFile(fmu_of(f"stand-in-{fmi}")) as archive:
        documents = {
            name.partition("/")[2]: etree.fromstring(archive.read(f"{name}.xml")) for name in names
        }
    for what, document in documents.items():
        etree.XMLSchema(
            file=str(SCHEMAS / "fmi3" / f"fmi3{what[0].upper()}{what[1:]}.xsd")
        ).assertValid(document)


def test_same_sources_give_the_same_bytes(
    fmi: int, fmu_of: Callable[[str], Path], tmp_path: Path
) -> None:
    assert (
        export_stand_in(tmp_path / "again.fmu", fmi).read_bytes()
        == fmu_of(f"stand-in-{fmi}").read_bytes()
    )


def test_bounds_of_the_inputs_are_those_of_the_rope() -> None:
    inputs = [v for v in variables(rope_120()) if v.causality == "input"]
    assert len(inputs) == 26
    clamped = Scene(left=Swivel(attachment="clamped"), right=Swivel(attachment="clamped"))
    for v in inputs:
        side, name = v.name.split(".")
        for bound in (v.minimum, v.maximum):
            assert bound is not None
            assert refusal(clamped, EndMotion(**{name: bound}), NO_MEASURES, side) == ""
            beyond = EndMotion(**{name: math.nextafter(bound, math.inf * bound)})
            assert "beyond" in refusal(clamped, beyond, NO_MEASURES, side)


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_sources_rebuild_with_fmpy_compile(
    fmi: int, fmu_of: Callable[[str], Path], tmp_path: Path
) -> None:
    if shutil.which("cmake") is None:
        pytest.skip("needs cmake")
    fmu = fmu_of(f"stand-in-{fmi}")
    folder = fmpy.extract(str(fmu), str(tmp_path))
    shutil.rmtree(tmp_path / "binaries")
    build_platform_binary(folder)
    rebuilt = Host(fmu, folder)
    rebuilt.start()
    assert rebuilt.get("left.fy") == [pytest.approx(-15.0 * 8.0 * 9.81)]
    rebuilt.free()


def test_the_widest_form_that_the_processor_has_is_taken() -> None:
    """Whatever compiler made the library: some answer no for every processor when asked by their own function."""
    flags = Path("/proc/cpuinfo")
    if not flags.is_file() or platform.machine() != "x86_64":
        pytest.skip("asks Linux on x86_64 what the processor has")
    # made as FMUs are, by ziglang if that is there: other flags would have it make its own library anew
    files = (Path(rope_model.__file__).with_name("csrc") / "numerics" / name for name in QUESTION)
    texts = {file.name: file.read_text(encoding="utf-8") for file in files}
    has = {*flags.read_text(encoding="utf-8").split()}
    lanes = 2
    if "avx2" in has:
        lanes = 4
    if {"avx512f", "avx512vl", "avx512vbmi"} <= has:
        lanes = 8
    for made in (
        ctypes.CDLL(str(open_library(texts, "processor", host_platform()))),
        NativeRope._library(),
    ):
        assert made.processor_lanes() == lanes


@pytest.mark.usefixtures("no_reference_run")
def test_start_values_are_set_on_the_command_line(
    tmp_path: Path, monkeypatch: Patch, capsys: Capture
) -> None:
    monkeypatch.setattr("fmu_src.native.export.rope_sources", stand_in)
    path = tmp_path / "rope.fmu"
    options = ["export", "--native", "--platform", "host", "--out", str(path)]
    assert main([*options, "--set", "rope.EI=250", "--set", "model.fidelity=torsional"]) == 0
    starts = {v.name: v.start for v in fmpy.read_model_description(str(path)).modelVariables}
    assert [float(starts[name]) for name in ("rope.EI", "model.fidelity", "rope.length")] == [
        250.0,
        1.0,
        120.0,
    ]
    for wrong, told in (
        ("air.density=-1", "air.density = -1.0 must be within 0 and 100: give it in kg/m3"),
        ("rope.length=-1", "rope.length = -1.0 must be within 1e-15 and 10000: give it in m"),
        ("hoist.payload_left=1", "--set hoist.payload_left: the FMU has the rope alone: add --ssp"),
    ):
        assert main([*options, "--set", wrong]) == 2
        assert told in capsys.readouterr().err
    assert main([*options, "--ssp", "--set", "coupling.step=0.02"]) == 2
    assert "--set coupling.step: a system leaves this to its master" in capsys.readouterr().err


def test_a_system_takes_values_of_the_hoist_from_the_command_line(
    tmp_path: Path, monkeypatch: Patch
) -> None:
    exported = dict[str, Any]()

    def keep(
        folder: Path, case: Case, _: object, fmu: RopeFmu, options: SystemOptions
    ) -> HoistFiles:
        exported.update(
            case=case,
            data={one.name: one for one in options.data},
            trajectory=options.trajectory,
            flavour=fmu.flavour,
        )
        (folder / "hoist.ssp").write_text("")
        return HoistFiles(folder / "hoist.ssp", {})

    monkeypatch.setattr("hoist_demo.command_line.export.export_hoist", keep)
    monkeypatch.setattr(
        "hoist_demo.command_line.export.export_rope", lambda path, *_: path.write_text("")
    )
    options = ["export", "--ssp", "--platform", "host", "--out", str(tmp_path)]
    assert main([*options, "--set", "hoist.payload_left=1234", "--set", "rope.EI=250"]) == 0
    assert exported["case"].hoist.payload_left == 1234.0
    assert exported["case"].rope["rope.EI"] == 250.0
    assert [exported["data"][name].value for name in ("hoist.payload_left", "rope.EI")] == [
        1234.0,
        250.0,
    ]


@pytest.mark.parametrize(
    ("options", "files"),
    [
        ([], {"balance_rope_native.fmu": ("native", 2)}),
        (["--fmi", "3"], {"balance_rope_native_fmi3.fmu": ("native", 3)}),
        (["--python"], {"balance_rope.fmu": ("Python", 2)}),
        (
            ["--python", "--native"],
            {"balance_rope.fmu": ("Python", 2), "balance_rope_native.fmu": ("native", 2)},
        ),
    ],
)
def test_an_export_is_native_unless_the_python_flavour_is_chosen(
    options: list[str],
    files: dict[str, tuple[str, int]],
    tmp_path: Path,
    monkeypatch: Patch,
) -> None:
    exported = dict[str, tuple[str, int]]()

    def keep(path: Path, case: Case, parameters: object, fmu: RopeFmu) -> None:
        exported[path.name] = (fmu.flavour, fmu.fmi)
        path.write_text("")

    monkeypatch.setattr("hoist_demo.command_line.export.export_rope", keep)
    assert main(["export", *options, "--platform", "host", "--out", str(tmp_path)]) == 0
    assert exported == files


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--native", "--fmi", "2", "3", "--out", "x.fmu"], "give a folder"),
        (["--python", "--fmi", "3"], "leave out --python"),
        (["--out", "file/x.fmu"], "file cannot be written to"),
        (["--out", "x.txt"], "--out x.txt must end in .fmu or name a folder: give x.fmu"),
        (["--out", "x.ssp"], "--out x.ssp is a system: add --ssp, or give x.fmu"),
        (["--native", "--scalar"], "add --native --fmi 3"),
    ],
)
def test_an_export_that_cannot_be_meant_is_refused_before_anything_is_built(
    options: list[str], words: str, tmp_path: Path, monkeypatch: Patch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    assert main(["export", *options]) == 2
    assert words in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
