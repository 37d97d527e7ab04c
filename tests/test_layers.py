"""The house: imports point down, no cycles, each third-party library has its rooms."""

import ast
import sys
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("rope_model", "fmu_src", "hoist_demo")


def rules(text: str) -> dict[str, set[str]]:
    """Sets of names by the name before the colon; one that begins with a point is of the same package."""
    found: dict[str, set[str]] = {}
    for line in text.replace("\n    ", " ").split("\n"):
        name, _, rest = line.partition(":")
        found[name] = {name.partition(".")[0] + x if x.startswith(".") else x for x in rest.split()}
    return found


#: package: packages of ours that it may import from (itself always)
MAY_IMPORT = rules(
    """\
rope_model.parameter_table:
rope_model.solver_parameters: .parameter_table
rope_model.parameters: .parameter_table .shaft_parameters .solver_parameters
rope_model.shaft_parameters: .parameter_table
rope_model.cases: .parameters .solver_parameters
rope_model.scene_names: .parameter_table .parameters .solver_parameters .shaft_parameters
rope_model.catalogue: .parameter_table .parameters
rope_model.physics:
rope_model.numerics:
rope_model.simulation: .parameter_table .parameters .scene_names .solver_parameters .shaft_parameters .physics
    .numerics
rope_model.codegen: .parameter_table .parameters .solver_parameters .shaft_parameters .physics .numerics
    rope_model.simulation rope_model.texts
rope_model.engine: .parameters .solver_parameters .numerics .simulation .texts .codegen
rope_model.public: .cases .catalogue .parameters .solver_parameters .shaft_parameters .numerics .simulation .engine
rope_model.version:
rope_model.texts:
rope_model: .public .version
fmu_src.native: rope_model.cases rope_model.parameters rope_model.scene_names rope_model.shaft_parameters
    rope_model.simulation rope_model.numerics rope_model.codegen rope_model.texts fmu_src
fmu_src.export: rope_model.cases rope_model.parameters rope_model.scene_names rope_model.simulation rope_model.version
    fmu_src .native
fmu_src: rope_model.cases rope_model.parameter_table rope_model.parameters rope_model.scene_names
    rope_model.shaft_parameters rope_model.simulation rope_model.texts rope_model.version
hoist_demo.parameters: rope_model.physics
hoist_demo.drive: .parameters rope_model.numerics
hoist_demo.control: .parameters .drive rope_model.physics
hoist_demo.recording: rope_model
hoist_demo.design: .parameters .drive .control .cases .cosimulation.participants rope_model rope_model.simulation
hoist_demo.drive_fmu: .parameters .drive .control .cases rope_model rope_model.parameter_table rope_model.scene_names
    rope_model.texts
hoist_demo.files: .parameters .control .cases rope_model rope_model.catalogue rope_model.scene_names
    rope_model.texts
hoist_demo.cases: .parameters .control .files rope_model
hoist_demo.cosimulation.schemes: rope_model
hoist_demo.cosimulation.participants: .parameters .drive .cases .recording .cosimulation.schemes rope_model
    rope_model.physics rope_model.scene_names
hoist_demo.cosimulation: .parameters .drive .control .recording .cosimulation.schemes .cosimulation.participants
    rope_model rope_model.numerics
hoist_demo.report: .parameters .cases .design .files .recording .cosimulation .cosimulation.participants .study .ropes
    rope_model rope_model.simulation rope_model.texts
hoist_demo.study: .files .parameters .control .design .cases .recording .cosimulation .cosimulation.participants
    .cosimulation.schemes rope_model rope_model.scene_names rope_model.texts
hoist_demo.duty: .cases .files .parameters .design .recording .cosimulation .cosimulation.participants
    .cosimulation.schemes .study rope_model rope_model.texts
hoist_demo.ropes: .cases .files .parameters .recording .cosimulation .cosimulation.participants
    .cosimulation.schemes .study rope_model
hoist_demo.calibration: .files .parameters .control .cases .cosimulation.participants .report .study rope_model
    rope_model.catalogue rope_model.numerics rope_model.parameters rope_model.physics rope_model.scene_names
    rope_model.simulation rope_model.texts
hoist_demo.uncertainty: .files .parameters .calibration .cases .recording .cosimulation
    .cosimulation.participants .report .study rope_model rope_model.texts
hoist_demo.command_line: .files .parameters .cases .recording .cosimulation .cosimulation.participants
    .cosimulation.schemes .report .study .duty .ropes .calibration .uncertainty .design
    rope_model rope_model.scene_names
hoist_demo:"""
)
#: library: modules or packages in which it may be imported; numpy is welcome everywhere
HOMES = rules(
    """\
casadi: rope_model.physics.element rope_model.physics.air_element rope_model.physics.wire_element
    rope_model.physics.curved_element rope_model.physics.bending_element rope_model.physics.contact_element
    rope_model.physics.elementary rope_model.numerics rope_model.codegen.elements rope_model.codegen.rules
    rope_model.codegen.expressions rope_model.codegen.formula_functions rope_model.codegen.tables
    rope_model.simulation.outputs.linear hoist_demo.design
    hoist_demo.drive hoist_demo.control.kernel
    hoist_demo.drive_fmu.kernels
scipy: rope_model.simulation.outputs.modal rope_model.simulation.outputs.linear
    hoist_demo.design hoist_demo.control.trajectory hoist_demo.study.sampling
    hoist_demo.calibration.fit hoist_demo.calibration.tracks hoist_demo.uncertainty.spread
    hoist_demo.recording.exposure
pythonfmu: fmu_src.slave fmu_src.export
fmpy: hoist_demo.cosimulation.participants.fmi_versions hoist_demo.cosimulation.participants.fmu_description
matplotlib: hoist_demo.report.figures hoist_demo.report.linear_figures
control: hoist_demo.design.reduction
rainflow: hoist_demo.recording.exposure
pint: hoist_demo.files.values
pydantic: hoist_demo.files hoist_demo.duty hoist_demo.calibration hoist_demo.uncertainty hoist_demo.study
tqdm: hoist_demo.cosimulation.progress hoist_demo.command_line.study hoist_demo.command_line.uncertain
dask: hoist_demo.study.cluster
pandas: hoist_demo.report.html.study hoist_demo.study.store
pyarrow: hoist_demo.study.store"""
)


@cache
def modules() -> dict[str, Path]:
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
        for package in PACKAGES
        for path in sorted((ROOT / package).rglob("*.py"))
    }


@cache
def imports(name: str, path: Path) -> frozenset[str]:
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            target = ".".join([*base, *([node.module] if node.module else [])])
            found |= {full if (full := f"{target}.{alias.name}") in modules() else target for alias in node.names}
    return frozenset(found)


def room(name: str) -> str:
    """The package of MAY_IMPORT that a module belongs to; rope_model itself is what users import, and no more."""
    rooms = (r for r in MAY_IMPORT if name == r or (r != "rope_model" and name.startswith(r + ".")))
    return next(rooms, name)


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
    users = {n for n, path in modules().items() if any(i.split(".")[0] == library for i in imports(n, path))}
    assert users
    assert {user for user in users if not within(user, HOMES[library])} == set()


def test_no_other_third_party_library_is_imported() -> None:
    known = set(HOMES) | set(PACKAGES) | {"numpy", "balance_rope"} | set(sys.stdlib_module_names)
    used = {i.split(".")[0] for name, path in modules().items() for i in imports(name, path)}
    assert used <= known


def test_benchmarks_know_nothing_of_evidence_and_one_module_of_templates() -> None:
    rooms = {room: sorted((ROOT / room).rglob("*.py")) for room in ("benchmarks", "evidence")}
    found = {path: imports("", path) for paths in rooms.values() for path in paths}
    assert not [path for path in rooms["benchmarks"] if any(within(name, {"evidence"}) for name in found[path])]
    assert [path for path in found if "jinja2" in found[path]] == [ROOT / "evidence" / "rendering.py"]


def test_no_import_cycles() -> None:
    graph = {n: {i for i in imports(n, p) if i in modules() and i != n} for n, p in modules().items()}
    assert len([*TopologicalSorter(graph).static_order()]) == len(graph)  # or it raises, and names the cycle


def test_nothing_the_fmu_imports_needs_scipy() -> None:
    graph = {n: imports(n, p) for n, p in modules().items()}
    reached, waiting = set(), ["fmu_src.slave"]
    while waiting:
        name = waiting.pop()
        if name not in reached:
            reached.add(name)
            waiting += graph.get(name, ())
    assert "rope_model.simulation.simulator" in reached
    assert not any(name.split(".")[0] == "scipy" for name in reached)


def test_no_test_of_the_product_imports_evidence_or_benchmarks() -> None:
    paths = [p for p in sorted((ROOT / "tests").rglob("*.py")) if "evidence" not in p.relative_to(ROOT).parts]
    assert len(paths) > 50
    used = {path.name: {name.partition(".")[0] for name in imports("", path)} for path in paths}
    assert [name for name, found in used.items() if found & {"evidence", "benchmarks"}] == []
