"""Run the comparison and write docs/peer.md, docs/data/peer and docs/images/peer: ten minutes on a free machine."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from tqdm import tqdm

from evidence.options import add_out
from evidence.pages import PAGES, publish
from evidence.tables import Table, Tables, table, write

from .cases import OPTIONS, OPTIONS_AT, REFERENCE_OURS, REFERENCE_PEER, SPACE, planar_cases, space_cases
from .exudyn_rope import VERSION, Method
from .page import PLANAR, PYTHON, SPATIAL, SYMBOLIC
from .runs import UNCOUPLED, Error, Run, error, exudyn, measure_times, ours
from .statics import MODES, Frequencies, Yaw, frequencies, yaws

PAGE = PAGES["peer"]
ROUNDS, SHORT = 3, 3.0  # s
NAN = float("nan")


def main(arguments: Sequence[str] | None = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser("python -m evidence.peer", description=__doc__)
    add_out(parser)
    options = parser.parse_args(arguments)
    write(compute(), options.out / "data" / PAGE.data)
    for path in publish(PAGE, options.out):
        print(path)


def compute() -> Tables:
    """Everything."""
    with tqdm(desc="runs", unit="run", leave=False) as bar:

        def tell(key: str) -> None:
            bar.set_postfix_str(key)
            bar.update()

        mine = ours(REFERENCE_OURS.group, REFERENCE_OURS.label, REFERENCE_OURS.scene)
        theirs = exudyn(*REFERENCE_PEER)
        element, count = OPTIONS_AT
        cases = {
            f"{1e3 * m.step:g} ms, {m.newton} Newton, radius {m.spectral_radius:g}": partial(exudyn, element, count, m)
            for m in OPTIONS
        }
        options = measure_times(cases, ROUNDS, SHORT, tell)
        method = Method(0.01, "full")
        forms = {
            name: partial(exudyn, element, count, method, symbolic=name == SYMBOLIC) for name in (SYMBOLIC, PYTHON)
        }
        times = {name: run.cost for name, run in measure_times(forms, ROUNDS, SHORT, tell).items()}
        undamped = {
            PLANAR: difference_without_damping(element, count, method),
            SPATIAL: difference_without_damping("beam-3d", 120, Method(0.02, "full")),
        }
        planar = measure_times(planar_cases(), ROUNDS, SHORT, tell)
        space = [(scene.title, measure_times(space_cases(scene), ROUNDS, SHORT, tell)) for scene in SPACE]
    return {
        "setup": setup_table(),
        "frequencies": frequencies_table(frequencies()),
        "yaw": yaw_table(yaws()),
        "winding": winding_table([mine, *planar.values()], mine, theirs),
        "options": options_table(options, mine, theirs),
        "checks": checks_table(undamped, times),
        "space": space_table(space),
    }


def difference_without_damping(element: str, count: int, method: Method) -> Error:
    """What beta_K changes in Exudyn."""
    undamped = UNCOUPLED.with_(rope=replace(UNCOUPLED.rope, beta_K=0.0))
    return error(exudyn(element, count, method), exudyn(element, count, method, undamped))


def setup_table() -> Table:
    """What the page must know of the runs."""
    element, count, method = REFERENCE_PEER
    rows = [
        ("version of Exudyn", VERSION),
        ("our reference", REFERENCE_OURS.label),
        ("Exudyn's reference", f"{element}, {count} elements, {1e3 * method.step:g} ms"),
        ("element of the options", OPTIONS_AT[0]),
        ("elements of the options", str(OPTIONS_AT[1])),
    ]
    return table(("what", "value"), rows)


def frequencies_table(found: Sequence[Frequencies]) -> Table:
    """Of every code, in both planes and at both heights."""
    names = ("height_m", "plane", "code", *(f"f{k + 1}_Hz" for k in range(MODES)))
    return table(names, [(x.height, x.plane, x.code, *x.values) for x in found])


def yaw_table(found: Sequence[Yaw]) -> Table:
    """The twisted rope."""
    names = ("code", "twist_rad", "torque_Nm", "yaw_deg", "left_z_m", "right_z_m")
    return table(names, [(x.code, x.twist, x.torque, x.yaw, x.left, x.right) for x in found])


def winding_table(runs: Sequence[Run], mine: Run, theirs: Run) -> Table:
    """Errors of every planar winding against our finest mesh and against Exudyn's."""
    names = (
        *("code", "group", "variant", "elements", "step_s", "cpu_s_per_s"),
        *("force_error_vs_ours", "force_error_vs_exudyn", "loop_error_vs_ours_m", "loop_error_vs_exudyn_m", "failure"),
    )
    rows = []
    for r in runs:
        a, b = error(r, mine), error(r, theirs)
        errors = a.force, b.force, a.loop, b.loop
        rows.append((r.code, r.group, r.label, r.elements, r.step, r.cost, *errors, r.failure))
    return table(names, rows)


def options_table(runs: dict[str, Run], mine: Run, theirs: Run) -> Table:
    """Of both errors the larger."""
    rows = []
    for name, r in runs.items():
        a, b = error(r, mine), error(r, theirs)
        rows.append((name, max(a.force, b.force), max(a.loop, b.loop), r.cost))
    return table(("option", "force_error", "loop_error_m", "cpu_s_per_s"), rows)


def checks_table(undamped: dict[str, Error], times: dict[str, float]) -> Table:
    """What damping changes, and what the form of the ends' motion costs."""
    rows = [(what, e.force, e.loop, NAN) for what, e in undamped.items()]
    rows += [(what, NAN, NAN, cost) for what, cost in times.items()]
    return table(("what", "force_error", "loop_error_m", "cpu_s_per_s"), rows)


def space_table(cases: Sequence[tuple[str, dict[str, Run]]]) -> Table:
    """Errors against the first run of each case."""
    names = ("case", "code", "variant", "elements", "step_s", "cpu_s_per_s", "force_error", "loop_error_m", "failure")
    rows = []
    for title, runs in cases:
        reference = next(iter(runs.values()))
        for label, r in runs.items():
            e = error(r, reference)
            rows.append((title, r.code, label, r.elements, r.step, r.cost, e.force, e.loop, r.failure))
    return table(names, rows)


if __name__ == "__main__":
    main()
