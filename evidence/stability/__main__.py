"""Run the stability suite: ``make stability``, or ``python -m evidence.stability --only KEY`` for one entry.

Prints a line per entry and writes docs/stability.md and docs/stability with figures and data; ``--only`` leaves the
pages alone.  Exit code 1 when a claim does not hold.  Takes some minutes.
"""

from __future__ import annotations

import argparse
import sys

from tqdm import tqdm

from .entry import Finding
from .page import COUNTEREXAMPLE, claim, illustrate, write_pages
from .suite import chapters, entries


def main() -> int:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description="Scenes in which plausible methods break.")
    keys = [entry.key for entry in entries()]
    parser.add_argument("--only", metavar="KEY", choices=keys, help=f"one of {', '.join(keys)}")
    only = parser.parse_args().only
    chosen = [entry for entry in entries() if only in (None, entry.key)]
    findings: dict[str, Finding] = {}
    bar = tqdm(chosen, unit="entry", leave=False)
    for entry in bar:
        bar.set_description(entry.key)
        finding = findings[entry.key] = entry.measure()
        illustrate(entry, finding)
        failed = [f"{m.what}: {claim(m)}" for m in (*finding.counterexample, *finding.ours) if not m.holds]
        tqdm.write(f"{entry.key:<16} {'as claimed' if finding.holds else 'NOT AS CLAIMED  ' + '; '.join(failed)}")
        if only:
            for side, claims in ((COUNTEREXAMPLE, finding.counterexample), ("ours", finding.ours)):
                for m in claims:
                    tqdm.write(f"  {side}  {m.what}: {claim(m)}")
    if only is None:
        write_pages(chapters(), findings)
    return 0 if all(finding.holds for finding in findings.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
