"""Measure what docs/choice.md tells, and write page and data: ``make choice``.

``--estimates`` compares estimates and errors anew before that (some ten minutes).
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import astuple, fields

from tqdm import tqdm

from evidence.pages import PAGES, publish
from evidence.rendering import DOCS
from evidence.tables import Table, table, write

from .fidelity import VARIED, Calibration, Choice, calibrations, measure_choice
from .scenes import CASES
from .terms import SCENES, VARIANTS, Base, Change, measure

DATA = DOCS / "data" / "choice"


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--estimates", action="store_true", help="compare the error estimates too: some ten minutes")
    if parser.parse_args().estimates:
        windings = tqdm(calibrations(), total=6 * len(VARIED) + 1, unit="winding", leave=False)
        write({"estimates": table([f.name for f in fields(Calibration)], [astuple(row) for row in windings])}, DATA)
    results = []
    for case in tqdm(CASES, unit="scene", leave=False):
        results.append(measure_choice(case))
        tqdm.write(f"{case.title}: {results[-1].fidelity}, {results[-1].reason}")
    with tqdm(total=len(SCENES) * (len(VARIANTS) + 1), unit="run", leave=False) as bar:

        def advance(what: str) -> None:
            bar.set_description(what)
            bar.update()

        bases, changes = measure(advance)
    write({"fidelity": choices_table(results), "bases": bases_table(bases), "terms": terms_table(changes)}, DATA)
    publish(PAGES["choice"])


def choices_table(results: Sequence[Choice]) -> Table:
    """What 'auto' took, why, and what that changed."""
    names = ("scene", "fidelity", "reason", "raised", "force_rms", "force_largest", "loop_m", "time")
    rows = [
        (x.case.title, x.fidelity, x.reason, "; ".join(x.switches), x.force, x.peak, x.bottom, x.time) for x in results
    ]
    return table(names, rows)


def bases_table(bases: Sequence[Base]) -> Table:
    """What the changes are compared with."""
    return table(("scene", "force_N", "theta_rad", "torque_Nm", "steps"), [astuple(x) for x in bases])


def terms_table(changes: Sequence[Change]) -> Table:
    """What each term changes in each scene."""
    names = ("scene", "term", "change", "force_rms", "loop_m", "theta_rad", "torque_Nm", "steps", "message")
    rows = [
        (x.scene, x.variant.term, x.variant.change, x.force, x.bottom, x.theta, x.torque, x.steps, x.message)
        for x in changes
    ]
    return table(names, rows)


if __name__ == "__main__":
    main()
