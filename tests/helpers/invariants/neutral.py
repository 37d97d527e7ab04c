"""What has no effect: features that are switched on without effect, and looking at a rope.

Nothing that the rope computes with changes, so no bit may.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from invariants.books import require
from invariants.case import Case
from invariants.features import Draws
from invariants.runs import READ, Compared, Record, wind
from invariants.symmetries import (
    ALL,
    Values,
    both,
    both_of,
    compared,
    meshes_agree,
    values_of,
    with_changes,
)
from rope_model import BalanceRope, PointForces

#: changes that leave every bit alone, and the values that a scene must have so that each has no
#: effect
WITHOUT_EFFECT: Mapping[str, tuple[Mapping[str, float], Mapping[str, float]]] = {
    "air that is not there": (
        {"air.drag": 3.0, "air.buffet": 0.5, "air.vx": 5.0},
        {"air.density": 0.0},
    ),
    "friction of wires that do not rub": (
        {"rope.slip_moment": 7.0, "rope.slip_factor": 0.05},
        {"rope.EI_stick": 0.0},
    ),
    "contact with nothing": (
        {
            "contact.stiffness": 3e5,
            "contact.damping": 1.0,
            "contact.friction": 0.7,
            "contact.slip_speed": 0.1,
        },
        {
            "lining.width": 0.0,
            "conveyance.width": 0.0,
            "head_ropes.diameter": 0.0,
            "sump.level": -1e6,
        }
        | {f"divider_{k}.size": 0.0 for k in (1, 2, 3, 4)}
        | {"contact.rope_stiffness": 0.0},
    ),
    "sizes of bodies that are absent": (
        {"lining.depth": 3.0, "lining.rounding": 0.3, "lining.x": 0.1, "lining.z": 0.2},
        {"lining.width": 0.0},
    ),
    "a beam of no size": (
        {"divider_4.y": -7.0, "divider_4.offset": 0.1, "divider_4.rounding": 0.0},
        {"divider_4.size": 0.0},
    ),
    "guards that never trip": (
        {"guard.rise": 1e6, "guard.window": 1e6, "guard.turns": 1e6, "guard.torque": 1e6},
        {f"guard.{name}": 0.0 for name in ("rise", "window", "turns", "torque", "clearance")},
    ),
    "other stations": ({"station.first": 0.3, "station.last": 0.4}, {}),
    "bounds that are not reached": (
        {"inputs.misfit_max": 50.0, "inputs.acceleration_max": 1e4, "inputs.hold_max": 50.0},
        {},
    ),
    "friction of a held swivel": (
        {
            f"left.swivel.{name}": 0.1
            for name in ("mu_kinetic", "mu_static", "seal_moment", "release_time")
        },
        {"left.swivel.mode": 0},
    ),
    "elements of another kind of mesh": (
        {"mesh.elements": 77, "mesh.coarse_length": 1.5},
        {"mesh.kind": 2},
    ),
}


def _equal(one: Record, other: Record, names: tuple[str, ...] = READ) -> Iterator[Compared]:
    for name in names:
        yield Compared(name, float(np.abs(other[name] - one[name]).max()), 0.0)


def _one_change(case: Case, draws: Draws) -> tuple[str, Case, Values]:
    values = values_of(case.scene)
    name = draws.one_of(*WITHOUT_EFFECT)
    changes, needed = WITHOUT_EFFECT[name]
    case = case.with_(scene=with_changes(case.scene, {**values, **needed}))
    return name, case, {**values_of(case.scene), **changes}


def switched_on(case: Case, draws: Draws) -> Iterator[Compared]:
    name, case, values = _one_change(case, draws)
    one, two = both(case, case.with_(scene=with_changes(case.scene, values)))
    for compared_ in _equal(one, two):
        yield Compared(f"{name}: {compared_.what}", compared_.difference, 0.0)


def bodies_far_away(case: Case, draws: Draws) -> Iterator[Compared]:
    """Bodies a kilometre away, none nearer: the code for contact runs and finds nothing."""
    values = values_of(case.scene)
    none: Values = {
        "lining.width": 0.0,
        "conveyance.width": 0.0,
        "head_ropes.diameter": 0.0,
        "sump.level": -1e6,
    }
    none |= {f"divider_{k}.size": 0.0 for k in (1, 2, 3, 4)} | {
        "guard.clearance": 0.0,
        "contact.stiffness": 1e6,
    }
    case = case.with_(scene=with_changes(case.scene, {**values, **none}))
    far: Values = draws.one_of(
        {"lining.width": 5e3, "lining.depth": 5e3, "lining.rounding": 0.0},
        {"sump.level": -9e3},
        {"divider_2.size": 0.2, "divider_2.y": -7.0, "divider_2.offset": 9e3},
        {"divider_2.size": 0.2, "divider_2.y": 9e3},
    )
    one, two = both(
        case, case.with_(scene=with_changes(case.scene, {**values_of(case.scene), **far}))
    )
    # the mesh is fitted before the ends have heights: a divider between the legs has finer
    # elements, however high it is
    require(meshes_agree(one, two), "another mesh")
    yield from compared(one, two, {name: one[name] for name in ALL})


def legs_that_do_not_meet(case: Case, draws: Draws) -> Iterator[Compared]:
    """Contact of the rope with itself where its legs stay apart."""
    values = values_of(case.scene)
    case = case.with_(scene=with_changes(case.scene, {**values, "contact.rope_stiffness": 0.0}))
    pressing = {**values_of(case.scene), "contact.rope_stiffness": 1e6, "model.fidelity": 1}
    case = case.with_(
        scene=with_changes(case.scene, {**values_of(case.scene), "model.fidelity": 1})
    )
    alone = wind(case)
    met = alone.rope.signals(("loop.overlap", "loop.crossings"))
    require(met["loop.overlap"] == 0.0, "legs that meet")
    require(met["loop.crossings"] == 0.0, "a rope that has passed through itself")
    one, two = both_of(alone, case.with_(scene=with_changes(case.scene, pressing)))
    require(float(two["contact.rope"].max()) == 0.0, "legs that meet")
    yield from compared(one, two, {name: one[name] for name in ALL})


def forces_of_nothing(case: Case, draws: Draws) -> Iterator[Compared]:
    """A point force of 0 N."""
    case = case.with_(force=None)
    other = case.with_(force=(0.3 * case.scene.rope.length, np.zeros(3)))
    values = values_of(case.scene)
    if values["model.fidelity"] in (0, 4):  # a rigid rope refuses point forces, as it says
        scene = with_changes(case.scene, {**values, "model.fidelity": 1})
        case = case.with_(scene=scene)
        other = other.with_(scene=scene)
    one, two = both(case, other)
    yield from _equal(one, two)


def looked_at(case: Case, draws: Draws) -> Iterator[Compared]:
    """Signals, warnings, rows, derivatives and copies of the state before a few of the steps."""
    chosen = {2 + int(draws.evenly(0.0, len(case.times) - 2)) for _ in range(4)}
    place = np.array([0.5 * case.scene.rope.length])
    probe = PointForces(place, np.array([[1.0, 0.0, 0.0]]), np.array([[1.0, 0.0, 0.0]]), 0.0, 1.0)

    def look(rope: BalanceRope, k: int) -> BalanceRope:
        if k not in chosen:
            return rope
        rope.warnings()
        rope.signals()
        rope.rows()
        rope.save()
        if rope.fidelity != "rigid":
            rope.added_mass()
            rope.displacement(probe)
        rope.retune(rope.scene)
        return rope

    one = wind(case)
    two = wind(one.case, look, work=np.inf)
    yield from _equal(one, two)


RELATIONS: tuple[Callable[[Case, Draws], Iterator[Compared]], ...] = (
    switched_on,
    bodies_far_away,
    legs_that_do_not_meet,
    forces_of_nothing,
    looked_at,
)
