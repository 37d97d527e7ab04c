"""Run the stability suite: ``make stability``, or ``python -m evidence.stability --only KEY`` for one entry.

Prints a line per entry and writes docs/stability.md and docs/stability with figures and data; ``--only`` keeps what is
there of the other entries.  Exit code 1 when a claim does not hold.  Takes some minutes.
"""

from __future__ import annotations

import argparse
import sys

from tqdm import tqdm

from evidence.pages import PAGES, publish
from evidence.rendering import DOCS
from evidence.tables import read, write

from .entry import Finding
from .page import SECTIONS, claim, illustrate, sides, tables_of
from .suite import entries

DATA = DOCS / "data" / SECTIONS


def main() -> int:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description="Scenes in which plausible methods break.")
    keys = [entry.key for entry in entries()]
    parser.add_argument("--only", metavar="KEY", choices=keys, help=f"one of {', '.join(keys)}")
    only = parser.parse_args().only
    findings: dict[str, Finding] = {}
    bar = tqdm([entry for entry in entries() if only in (None, entry.key)], unit="entry", leave=False)
    for entry in bar:
        bar.set_description(entry.key)
        finding = findings[entry.key] = entry.measure()
        illustrate(entry, finding, DOCS)
        claims = [(side, m) for side, group in sides(finding).items() for m in group]
        failed = [f"{m.what}: {claim(m)}" for _, m in claims if not m.holds]
        tqdm.write(f"{entry.key:<16} {'as claimed' if finding.holds else 'NOT AS CLAIMED  ' + '; '.join(failed)}")
        if only:
            for side, m in claims:
                tqdm.write(f"  {side}  {m.what}: {claim(m)}")
    write(tables_of(findings, read(DATA) if only else None), DATA)
    for page in PAGES.values():
        if page.data == SECTIONS:
            publish(page)
    return 0 if all(finding.holds for finding in findings.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
