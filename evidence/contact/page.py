"""What docs/contact.md says, from the recorded checks."""

from __future__ import annotations

from evidence.claims import Measurement
from evidence.rendering import number, render
from evidence.tables import Table, Tables, table
from rope_model.parameters import Rope, Scene
from rope_model.physics import contact, contact_places, rope_on_rope
from rope_model.shaft_parameters import Contact, Divider, Shaft
from rope_model.simulation.mesh import mesh_fit
from rope_model.simulation.mesh.partition import fit_mesh, partition

from . import brushed, brushes, plectoneme
from .scenes import GRAVITY
from .slack_rod import BEND, DIAMETER, LENGTH, SLACK, TORSION

#: columns of a slack rod, and how they are shown
_RODS = {
    "turns": "g",
    "elements": "g",
    "torque": ".5g",
    "pull": ".5g",
    "pressed": ".0f",
    "first": ".3g",
    "second": ".3g",
}
#: columns of a plectoneme, and how they are shown
_PLECTONEME = {"tension": ".4g", "torque": ".4g", "nearer": ".4g", "angle": ".4g", "radius": ".4g"}
#: columns of a brush, and how they are shown
_BRUSHES = {"step": "g", "stiffness": ".3g", "peak": ".3f", "impulse": ".5g", "told": ".2g"}
_COLUMNS = ("case", "what", "value", "unit", "relation", "bound")


def as_table(found: list[tuple[str, Measurement]]) -> Table:
    """One row per check."""
    return table(_COLUMNS, [(case, m.what, m.value, m.unit, m.relation, m.bound) for case, m in found])


def page(tables: Tables) -> str:
    """The whole page."""
    t = tables["checks"]
    found = [Measurement(*(t[name][k] for name in _COLUMNS[1:])) for k in range(len(t["case"]))]
    rows = [
        (str(case), m.what, number(m.value), f"{m.relation} {number(m.bound)}", "holds" if m.holds else "misses")
        for case, m in zip(t["case"], found, strict=True)
    ]
    data = {
        "rows": rows,
        "slack": sorted([*_rods("PyElastica", tables["elastica"]), *_rods("ours", tables["slack"])], key=_turns),
        "rod": {"length": LENGTH, "slack": SLACK, "bend": BEND, "torsion": TORSION, "diameter": DIAMETER},
        "brushes": _brushes(tables["brushes"]),
        "orders": {name: number(x, ".2g") for name, x in brushes.orders(tables["brushes"]).items()},
        "brush": {"size": brushed.SIZE, "below": -brushed.HEIGHT, "left": -brushed.OFFSET, "rise": brushed.RISE},
        "fit": mesh_fit,
        "prices": [_price(length) for length in (60.0, 120.0, 400.0, 1000.0)],
        "wound": _plectonemes(tables["plectoneme"]),
        "winds": {
            "length": plectoneme.LENGTH,
            "bend": plectoneme.BEND,
            "torsion": plectoneme.TORSION,
            "diameter": plectoneme.DIAMETER,
            "elements": plectoneme.ELEMENTS,
            "stiffness": plectoneme.STIFFNESS,
            "tension": plectoneme.TENSION,
            "wound": plectoneme.WOUND,
            "grown": plectoneme.GROWN,
            "mass": plectoneme.MASS,
        },
        "law": Contact(),
        "onset": contact.ONSET,
        "own": contact.OWN_LENGTH,
        "cells": contact_places.CELLS,
        "points": len(contact_places.PARTS),
        "gravity": GRAVITY,
        "spacing": rope_on_rope.SPACING,
        "apart": number(rope_on_rope.APART),
        # the integral of k p^2 / 2 over the places of a string that goes right through another, D the diameter
        "cross_energy": number(1e6 * Rope().diameter ** 3 / 3.0),
    }
    return render("contact/contact.md.j2", data)


def _rods(code: str, t: Table) -> list[tuple[str, ...]]:
    """Turns first, then the code."""
    columns = [[number(x, form) for x in t[name]] for name, form in _RODS.items()]
    return [(turns, code, *rest) for turns, *rest in zip(*columns, strict=True)]


def _price(length: float) -> tuple[str, ...]:
    """The fitted mesh of a rope without a divider and with one."""
    beam = Divider(size=brushed.SIZE, y=brushed.HEIGHT, offset=brushed.OFFSET)
    scenes = (Scene(Rope(length=length), shaft=shaft) for shaft in (Shaft(), Shaft(divider_1=beam)))
    free, pressed = (partition(fit_mesh(scene), length, 0.5 * length).lengths for scene in scenes)
    return number(length), number(free.size), number(pressed.size), number(pressed.max(), ".2f")


def _brushes(t: Table) -> list[tuple[str, ...]]:
    columns = [[number(x, form) for x in t[name]] for name, form in _BRUSHES.items()]
    meshes = [f"{n:g} equal" if n else "fitted" for n in t["elements"]]
    return [(mesh, *rest) for mesh, *rest in zip(meshes, *columns, strict=True)]


def _plectonemes(t: Table) -> list[tuple[str, ...]]:
    columns = [[number(x, form) for x in t[name]] for name, form in _PLECTONEME.items()]
    return [(str(of), *rest) for of, *rest in zip(t["of"], *columns, strict=True)]


def _turns(cells: tuple[str, ...]) -> float:
    return float(cells[0])
