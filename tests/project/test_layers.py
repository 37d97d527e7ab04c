"""The house: imports point down, no cycles, each third-party library has its rooms."""

import ast
import re
import sys
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from fnmatch import fnmatch
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
from checkout import ROOT

PACKAGES = ("rope_model", "fmu_src", "hoist_demo")
_LAYERS = tomllib.loads(Path(__file__).with_name("layers.toml").read_text(encoding="utf-8"))
_MAY_IMPORT, _MAY_INCLUDE, _HOMES = _LAYERS.values()
MAY_IMPORT = {name: set(names) for name, names in _MAY_IMPORT.items()}
MAY_INCLUDE = {name: set(names) for name, names in _MAY_INCLUDE.items()}
HOMES = {name: set(names) for name, names in _HOMES.items()}


@cache
def modules() -> dict[str, Path]:
    found: dict[str, Path] = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            found[name.removesuffix(".__init__")] = path
    return found


def imported_from(node: ast.ImportFrom, package: str) -> Iterator[str]:
    """Yield modules by their full names; for a name that is no module, the module that has it."""
    target = node.module or ""
    if node.level:
        parts = package.split(".")
        base = ".".join(parts[: len(parts) - node.level + 1])
        target = f"{base}.{target}".rstrip(".")
    for alias in node.names:
        full = f"{target}.{alias.name}"
        if full in modules():
            yield full
        else:
            yield target


#: a statement with all that its parentheses hold; ruff wants each on lines of its own
_IMPORT = re.compile(r"^[ \t]*((?:import|from)\b(?:[^(\n]*\([^)]*\)|[^\n]*))", re.MULTILINE)


def import_statements(text: str) -> list[ast.AST]:
    """Return the statements of a module that import; the rest of it takes most of the time to parse."""
    quoted = text.split('"""')[1::2]
    if not any(_IMPORT.search(part) for part in quoted):
        text = "\n".join(_IMPORT.findall(text))
    return [*ast.walk(ast.parse(text))]


@cache
def imports(name: str, path: Path) -> frozenset[str]:
    package = name
    if path.name != "__init__.py":
        package = name.rpartition(".")[0]
    found: set[str] = set()
    for node in import_statements(path.read_text(encoding="utf-8")):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {*imported_from(node, package)}
    return frozenset(found)


def room(name: str) -> str:
    """The package of layers.toml that a module belongs to; rope_model itself is what users import, and no more."""
    return next(
        (r for r in MAY_IMPORT if name == r or (r != "rope_model" and name.startswith(r + "."))),
        name,
    )


def tops(names: Iterable[str]) -> set[str]:
    """Return the top-level package of each module."""
    return {name.partition(".")[0] for name in names}


def within(name: str, places: set[str]) -> bool:
    return any(name == place or name.startswith(place + ".") for place in places)


@pytest.mark.parametrize("name", sorted(modules()))
def test_imports_point_down(name: str) -> None:
    ours = {i for i in imports(name, modules()[name]) if i.split(".")[0] in PACKAGES}
    allowed = MAY_IMPORT.get(room(name), set()) | {room(name)}
    assert {i for i in ours if room(i) not in allowed and i not in allowed} == set()


def test_every_module_of_the_hoist_is_in_a_room() -> None:
    assert [name for name in modules() if room(name) == "hoist_demo"] == ["hoist_demo"]


@pytest.mark.parametrize("library", sorted(HOMES))
def test_third_party_library_stays_in_its_rooms(library: str) -> None:
    users = {name for name, path in modules().items() if library in tops(imports(name, path))}
    assert users
    assert {user for user in users if not within(user, HOMES[library])} == set()


def test_no_other_third_party_library_is_imported() -> None:
    known = set(HOMES) | set(PACKAGES) | {"numpy"} | set(sys.stdlib_module_names)
    for name, path in modules().items():
        assert tops(imports(name, path)) <= known, name


def test_benchmarks_know_nothing_of_evidence_and_one_module_of_templates() -> None:
    benchmarks = sorted((ROOT / "benchmarks").rglob("*.py"))
    evidence = sorted((ROOT / "evidence").rglob("*.py"))
    assert [path for path in benchmarks if "evidence" in tops(imports("", path))] == []
    assert [path for path in [*benchmarks, *evidence] if "jinja2" in imports("", path)] == [
        ROOT / "evidence" / "rendering.py"
    ]


def test_no_import_cycles() -> None:
    graph = {name: imports(name, p) & modules().keys() - {name} for name, p in modules().items()}
    order = [*TopologicalSorter(graph).static_order()]  # or it raises, and names the cycle
    assert len(order) == len(graph)


def folder(name: str) -> str:
    """The package whose folder holds a module; a module beside rope_model's packages stands alone."""
    if modules()[name].name == "__init__.py":
        return name
    parent = name.rpartition(".")[0]
    if parent == "rope_model":
        return name
    return parent


def folder_graph(imports_of: Mapping[str, Iterable[str]]) -> dict[str, set[str]]:
    """Return the folders from which each folder imports."""
    graph: dict[str, set[str]] = {}
    for name, found in imports_of.items():
        below = graph.setdefault(folder(name), set())
        below |= {folder(i) for i in found if i in modules()} - {folder(name)}
    return graph


def test_no_cycles_between_folders() -> None:
    imports_of = {name: imports(name, path) for name, path in modules().items()}
    assert [*TopologicalSorter(folder_graph(imports_of)).static_order()]
    # one import upwards between two modules that know nothing of each other is found
    upwards = {"hoist_demo.files.values": {"hoist_demo.cases.table"}}
    with pytest.raises(CycleError, match="hoist_demo"):
        [*TopologicalSorter(folder_graph({**imports_of, **upwards})).static_order()]


CSRC = ROOT / "rope_model" / "csrc"
C_FILES = {
    path.name: path for path in sorted(CSRC.rglob("*")) if path.suffix in (".c", ".h", ".inc")
}


def c_module(file: str) -> str:
    """A C file and the header beside it are one module; a template alone is another."""
    return file.removesuffix(".h").removesuffix(".c")


def c_includes() -> dict[str, set[str]]:
    """Return the written modules of C that each of them includes."""
    graph: dict[str, set[str]] = {}
    for name, path in C_FILES.items():
        found = re.findall(r'^#include "([\w.]+)"', path.read_text(encoding="utf-8"), re.MULTILINE)
        below = graph.setdefault(c_module(name), set())
        below |= {c_module(file) for file in found if file in C_FILES} - {c_module(name)}
    return graph


def c_folders(includes_of: Mapping[str, Iterable[str]]) -> dict[str, set[str]]:
    """Return the folders of C that each of them includes; rope.h alone is in none."""
    home = {
        c_module(name): path.parent.relative_to(CSRC).as_posix() for name, path in C_FILES.items()
    }
    graph: dict[str, set[str]] = {}
    for name, found in includes_of.items():
        below = graph.setdefault(home[name], set())
        below |= {home[i] for i in found} - {home[name], "."}
    return graph


def test_no_cycles_between_modules_of_c() -> None:
    graph = c_includes()
    assert [*TopologicalSorter(graph).static_order()]
    with pytest.raises(CycleError, match="stepping"):  # as when a module of outputs is included
        [*TopologicalSorter({**graph, "stepping": {"sensitivity"}}).static_order()]


def test_no_cycles_between_folders_of_c() -> None:
    graph = c_includes()
    assert [*TopologicalSorter(c_folders(graph)).static_order()]
    # one inclusion upwards between two modules that know nothing of each other is found
    upwards = c_folders({**graph, "bodies": {"loop"}})
    with pytest.raises(CycleError, match="contact"):
        [*TopologicalSorter(upwards).static_order()]


def test_inclusions_of_c_point_down_as_listed() -> None:
    folders = c_folders(c_includes())
    assert folders.pop(".") == set()
    assert folders == MAY_INCLUDE


def test_every_c_file_but_the_interface_of_the_engine_is_in_a_layer() -> None:
    assert [name for name, path in C_FILES.items() if path.parent == CSRC] == ["rope.h"]


def test_no_room_is_allowed_what_it_does_not_import() -> None:
    used: dict[str, set[str]] = {name: set() for name in MAY_IMPORT}
    for name, path in modules().items():
        used[room(name)] |= {room(i) for i in imports(name, path) if i.split(".")[0] in PACKAGES}
    unused = {name: allowed - used[name] for name, allowed in MAY_IMPORT.items()}
    assert {name: rooms for name, rooms in unused.items() if rooms} == {}


ARCHITECTURE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")


def rows_below(heading: str) -> list[list[str]]:
    """Return the cells of the table of the architecture page whose first heading this is."""
    _, _, table = ARCHITECTURE.partition(f"\n| {heading} | holds |\n|---|---|\n")
    table, _, _ = table.partition("\n\n")
    return [line.strip("| ").split(" | ", 1) for line in table.splitlines()]


def test_the_page_lists_each_room_of_the_hoist_once() -> None:
    rows = rows_below("room")
    first = [name for cell, _ in rows for name in re.findall(r"`([\w/]+)`", cell)]
    within_rooms = re.findall(r"`(participants|schemes)`", " ".join(cell for _, cell in rows))
    listed = [*first, *(f"cosimulation/{name}" for name in within_rooms)]
    folders = [path.parent for path in (ROOT / "hoist_demo").rglob("__init__.py")]
    rooms = [path.relative_to(ROOT / "hoist_demo").as_posix() for path in folders]
    assert sorted(listed) == sorted(set(rooms) - {"."})


def test_the_page_lists_each_folder_of_c_once() -> None:
    listed = [name for cell, _ in rows_below("folder") for name in re.findall(r"`(\w+)`", cell)]
    assert sorted(listed) == sorted(MAY_INCLUDE)


def test_the_page_lists_each_room_of_the_rope_once() -> None:
    lines = re.findall(r"^ {4}rope_model\.(\S.*?)(?:  +.*)?$", ARCHITECTURE, re.MULTILINE)
    patterns = [name for line in lines for name in re.split(r" \| |, ", line) if name != "csrc"]
    rooms = {name.partition(".")[2] for name in MAY_IMPORT if name.startswith("rope_model.")}
    for name in sorted(rooms - {"version"}):
        assert len([pattern for pattern in patterns if fnmatch(name, pattern)]) == 1, name
    assert [p for p in patterns if not any(fnmatch(name, p) for name in rooms)] == []


def reached_from(start: str) -> set[str]:
    """Return what a module imports, and what that imports."""
    reached = set[str]()
    waiting = [start]
    while waiting:
        name = waiting.pop()
        if name not in reached:
            reached.add(name)
            if name in modules():
                waiting += imports(name, modules()[name])
    return reached


@pytest.mark.parametrize(
    "command", ["wind", "duty", "hoist", "export", "identify", "uncertain", "linear"]
)
def test_only_the_command_of_studies_imports_studies(command: str) -> None:
    reached = reached_from(f"hoist_demo.command_line.{command}")
    assert "hoist_demo.run.data" in reached
    assert {name for name in reached if within(name, {"hoist_demo.study"})} == set()


def test_the_python_fmu_imports_the_reference_rope_without_the_engine_or_another_form() -> None:
    reached = reached_from("fmu_src.python.slave")
    assert "rope_model.reference.rope" in reached
    others = ("rope_model.engine", "rope_model.codegen")
    assert not [name for name in reached if name.startswith(others)]


def test_every_statement_that_imports_is_found() -> None:
    text = "import a\ndef f():\n    from b import (\n        c,  # why\n        d,\n    )\n"
    names = [x.name for x in import_statements(text) if isinstance(x, ast.alias)]
    assert names == ["a", "c", "d"]
    assert not any(isinstance(x, ast.alias) for x in import_statements(f'A = """\n{text}"""\n'))


def test_no_test_of_the_product_imports_evidence_or_benchmarks() -> None:
    paths = [
        p
        for p in sorted((ROOT / "tests").rglob("*.py"))
        if "evidence" not in p.relative_to(ROOT).parts
    ]
    assert len(paths) > 50
    used = {path.name: tops(imports("", path)) for path in paths}
    assert [name for name, found in used.items() if found & {"evidence", "benchmarks"}] == []


def test_tests_import_helpers_and_not_each_other() -> None:
    paths = sorted((ROOT / "tests").rglob("*.py"))
    others = {path.stem for path in paths if path.name.startswith("test_")}
    assert len(others) > 80
    users = {path.name: imports("", path) & (others - {path.stem}) for path in paths}
    assert {name: found for name, found in users.items() if found} == {}
