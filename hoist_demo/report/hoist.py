"""A hoist before it is wound, for people: its values with their sources, and what follows from them."""

from __future__ import annotations

import math
from dataclasses import replace

from hoist_demo.cases.case import Case
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data, scene_parameters
from hoist_demo.design.statics import at_rest, holds, pulls
from hoist_demo.report.rows import SummaryRow, render, table
from hoist_demo.study.provenance import of_host, of_rope
from hoist_demo.study.run import build_trip
from rope_model import EndMotion, RopeSimulator, Scene, balance_rope
from rope_model.simulation.outputs.modal import natural_modes

#: lowest modes of the rope that are told
MODES = 4
_AT_REST = "Rope at rest, left conveyance at"


def scenes(case: Case) -> dict[str, Scene]:
    """Return the ropes of a hoist by name; ValueError where one cannot be."""
    if not case.ropes:
        return {"rope": rope_data(case.rope, case.level)}
    found = {}
    for tail in case.ropes:
        scene = rope_data(tail.parameters, case.level)
        apart = scene.layout.spacing + tail.place.get("x_right", 0.0) - tail.place.get("x_left", 0.0)
        found[tail.name] = scene.with_(layout=replace(scene.layout, spacing=apart))
    return found


def values(case: Case, name: str) -> str:
    """Return the table of all values by status; `name` is how the hoist is found."""
    run = build_trip(name, {})
    known = of_host(run, {})
    for tail, scene in zip(case.tails, scenes(case).values(), strict=True):
        prefix, alone = f"{tail.name}." if case.ropes else "", case.alone(tail)
        known += [one._replace(name=prefix + one.name) for one in of_rope(alone, scene_parameters(scene), {})]
    _, rows = table(known)
    names = max(len(str(row[0])) for row in rows)
    return "\n".join(
        f"{row[0]:<{names}}  {row[1]:>12} {row[2]:<10} {row[3]}  {case.sources.get(str(row[0]), '')}".rstrip()
        for row in rows
    )


def problems(case: Case) -> list[str]:
    """Return a line on each bound that the hoist at rest or in its trip does not keep."""
    return [
        f"slip safety {one.when} is {one.safety:.3g} (tension ratio {one.ratio:.3g}, limit "
        f"{case.hoist.tension_ratio_limit:.3g}), and {one.asked:g} is usually asked for: more weight on the light "
        "side, a better lining, or a gentler trip"
        for one in holds(case.hoist, case.winding)
        if one.safety < one.asked and one.when != "emergency stop"
    ]


def follows(case: Case, name: str) -> tuple[str, list[str]]:
    """Return the table of what follows, and the ropes' warnings at rest; RuntimeError where a rope cannot hang."""
    hoist = case.hoist
    rows = [
        SummaryRow("Hold on the sheave", f"slip safety {one.when}", f"{one.safety:.3g}, asked {one.asked:g}")
        for one in holds(hoist, case.winding)
    ]
    for height in (0.0, hoist.shaft_travel):
        left, right = pulls(hoist, height)
        words = f"{left / 1e3:.4g} and {right / 1e3:.4g} kN"
        rows.append(SummaryRow("Hold on the sheave", f"pulls left and right, left conveyance at {height:g} m", words))
    rows.append(SummaryRow("Hold on the sheave", "all moving masses", hoist.moving_mass, "kg"))
    warned = []
    for rope, scene in scenes(case).items():
        plant, whose = balance_rope(scene), f"{rope}: " if case.ropes else ""
        for height, signals in at_rest(plant, hoist, [0.0, 0.5 * hoist.shaft_travel, hoist.shaft_travel]):
            group = f"{whose}{_AT_REST} {height:g} m"
            rows += [
                SummaryRow(group, "pull left and right", f"{signals['left.fy']:.5g} and {signals['right.fy']:.5g} N"),
                SummaryRow(group, "loop's lowest point", signals["loop.y"], "m"),
                SummaryRow(group, "loop's yaw", math.degrees(signals["loop.yaw"]), "deg"),
                SummaryRow(group, "torque at the left end", abs(signals["left.my"]), "N.m"),
            ]
            rows += [
                SummaryRow(group, key.replace(".", " to ", 1), value, "m")
                for key, value in signals.items()
                if key.startswith("clearance.") and abs(value) < 1e3
            ]
        model = f"{plant.fidelity} with {plant.elements} elements ({plant.fidelity_reason})"
        rows.append(SummaryRow(f"{whose}Model", "fidelity and mesh", model))
        rows.append(SummaryRow(f"{whose}Model", "frequencies, mid-trip", _frequencies(scene, hoist.shaft_travel)))
        warned += [f"{whose}{text}" for text in plant.warnings().values()]
    return render(rows), list(dict.fromkeys(warned))


def _frequencies(scene: Scene, travel: float) -> str:
    rope = RopeSimulator(scene.with_(solver=replace(scene.solver, kernels="portable")))
    status = rope.initialize(0.0, EndMotion(y=0.5 * travel), EndMotion(y=0.5 * travel))
    if not status.valid:
        return status.message
    try:
        modes = natural_modes(rope.system, rope.state.motion.q, MODES)
    except ValueError as error:
        return str(error)
    told = zip(modes.frequencies, modes.out_of_plane, strict=True)
    return ", ".join(f"{f:.3g} Hz {'out of' if out > 0.5 else 'in'} plane" for f, out in told)
