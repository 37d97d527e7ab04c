"""What docs/contact.md says, from the recorded checks."""

from __future__ import annotations

from evidence.claims import Measurement
from evidence.contact import wall
from evidence.contact.brush import FINEST, HEIGHTS, MESHES, STIFFNESS, orders, past
from evidence.rendering import number, quantity, render
from evidence.tables import Table, Tables, records, table
from rope_model.parameters import Rope, Scene
from rope_model.shaft_parameters import Shaft
from rope_model.simulation.mesh import mesh_fit, mesh_pattern
from rope_model.simulation.mesh.partition import faced_by, fit_mesh, mesh_elements, partition

_COLUMNS = ("case", "what", "value", "unit", "relation", "bound")


def as_table(found: list[tuple[str, Measurement]]) -> Table:
    """One row per check."""
    return table(_COLUMNS, [(case, m.what, m.value, m.unit, m.relation, m.bound) for case, m in found])


def page(tables: Tables) -> str:
    """The whole page."""
    checks = records(tables["checks"])
    brushes = {(r["elements"], r["step"], r["stiffness"]): r for r in records(tables["brushes"])}
    data = {
        "cases": len({r.pop("case") for r in checks}),
        "checks": len(checks),
        "held": sum(Measurement(**r).holds for r in checks),
        "fitted": brushes[0, 2e-3, STIFFNESS],
        "fine": brushes[480, 2e-3, STIFFNESS],
        "base": brushes[480, 5e-3, STIFFNESS],
        "stiff": brushes[480, 5e-3, 4.0 * STIFFNESS],
        "orders": {name: number(x, ".2g") for name, x in orders(tables["brushes"]).items()},
        "worst": [_worst(tables["heights"], mesh) for mesh in MESHES],
        "heights": HEIGHTS,
        "finest": FINEST,
        "fit": mesh_fit,
        "fitted_elements": mesh_elements(past().scene),
        "pattern": mesh_pattern,
        "prices": [_price(length) for length in (60.0, 120.0, 400.0, 1000.0)],
        "wall": wall,
    }
    return render("contact/contact.md.j2", data)


def _worst(heights: Table, mesh: str) -> tuple[str, str]:
    """A mesh, and by how much its peak is off at most."""
    off = max(abs(r["peak off by"]) for r in records(heights) if r["mesh"] == mesh)
    return mesh, quantity(off, "%", ".1f")


def _price(length: float) -> tuple[str, ...]:
    """The fitted mesh of a rope without a divider and with one."""
    scenes = (Scene(Rope(length=length), shaft=shaft) for shaft in (Shaft(), past().scene.shaft))
    free, pressed = (
        partition(fit_mesh(scene), length, 0.5 * length, faced_by(scene, 0.0, 0.0)).lengths for scene in scenes
    )
    return number(length), number(free.size), number(pressed.size), number(pressed.max(), ".2f")
