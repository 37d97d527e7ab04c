"""What docs/contact.md says, from the recorded checks."""

from evidence.claims import recorded
from evidence.contact import wall
from evidence.contact.brush import FINEST, HEIGHTS, MESHES, STIFFNESS, orders, past
from evidence.rendering import number, quantity, render
from evidence.ropes import at_rest
from evidence.tables import Table, Tables, records
from rope_model.method import mesh_fit, mesh_pattern
from rope_model.parameters import Rope, Scene
from rope_model.shaft_parameters import Shaft
from rope_model.solver_parameters import Model


def page(tables: Tables) -> str:
    """The whole page."""
    checks = recorded(tables["checks"])
    brushes = {(r["elements"], r["step"], r["stiffness"]): r for r in records(tables["brushes"])}
    data = {
        "cases": len({about for about, _ in checks}),
        "checks": len(checks),
        "held": sum(m.holds for _, m in checks),
        "base": brushes[480, 5e-3, STIFFNESS],
        "stiff": brushes[480, 5e-3, 4.0 * STIFFNESS],
        "orders": {name: number(x, ".2g") for name, x in orders(tables["brushes"]).items()},
        "worst": [_worst(tables["heights"], mesh) for mesh in MESHES],
        "heights": HEIGHTS,
        "finest": FINEST,
        "fit": mesh_fit,
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
    # a rigid rope has the mesh of the others, and needs no equilibrium
    scenes = (
        Scene(Rope(length=length), shaft=shaft, model=Model("rigid"))
        for shaft in (Shaft(), past().scene.shaft)
    )
    free, pressed = (at_rest(scene).state.partition.lengths for scene in scenes)
    return number(length), number(free.size), number(pressed.size), number(pressed.max(), ".2f")
