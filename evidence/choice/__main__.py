"""Write docs/choice.md with its data: ``make choice``.  ``--estimates`` first compares estimates and errors anew."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from tqdm import tqdm

from .fidelity import VARIED, calibrations, measure_choice
from .page import DATA, DOCS, page, read_csv, terms, write_csv
from .scenes import CASES
from .terms import SCENES, VARIANTS, measure


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description="Which rung of the model a scene needs, and which terms.")
    parser.add_argument("--estimates", action="store_true", help="compare the error estimates too: some ten minutes")
    if parser.parse_args().estimates:
        windings = tqdm(calibrations(), total=6 * len(VARIED) + 1, unit="winding", leave=False)
        write_csv(DATA / "estimates.csv", [asdict(row) for row in windings])
    results = []
    for case in tqdm(CASES, unit="scene", leave=False):
        results.append(measure_choice(case))
        tqdm.write(f"{case.title}: {results[-1].fidelity}, {results[-1].reason}")
    fidelities = [
        {
            "scene": x.case.title,
            "rung": x.fidelity,
            "reason": x.reason,
            "raised": "; ".join(x.switches),
            "force_rms": x.force,
            "force_largest": x.peak,
            "loop_m": x.bottom,
            "time": x.time,
        }
        for x in results
    ]
    write_csv(DATA / "rungs.csv", fidelities)
    with tqdm(total=len(SCENES) * (len(VARIANTS) + 1), unit="run", leave=False) as bar:

        def advance(what: str) -> None:
            bar.set_description(what)
            bar.update()

        bases, changes = measure(advance)
    rows = [
        {
            "scene": x.scene,
            "term": x.variant.term,
            "change": x.variant.change,
            "force_rms": x.force,
            "loop_m": x.bottom,
            "theta_rad": x.theta,
            "torque_Nm": x.torque,
            "steps": x.steps,
        }
        for x in changes
    ]
    write_csv(DATA / "terms.csv", rows)
    text = page(results, read_csv(DATA / "estimates.csv"), terms(bases, changes))
    (DOCS / "choice.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
