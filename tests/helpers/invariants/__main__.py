"""Hunt for broken relations: python -m invariants --seed 7 --minutes 60, or one case again."""

from __future__ import annotations

import argparse
import json
import logging
import subprocess
import sys
import time

from checkout import ROOT

from invariants.hunt import MOST_REFUSED, RELATIONS, Hunt, Outcome

LOG = ROOT / "docs" / "data" / "hunts.json"


def main() -> int:
    """Exit with 1 if a relation is broken or too many scenes are refused."""
    parser = argparse.ArgumentParser("make hunt", description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--case", type=int, help="this case alone")
    parser.add_argument(
        "--relation", default="", choices=["", *RELATIONS], help="this relation alone"
    )
    parser.add_argument("--without", default="", help="features to be left out, between commas")
    parser.add_argument(
        "--log", action="store_true", help=f"add what was found to {LOG.relative_to(ROOT)}"
    )
    options = parser.parse_args()
    logging.disable(logging.WARNING)  # of trips whose results need care
    hunt = Hunt(options.seed)
    begun = time.monotonic()
    if options.case is not None:
        names = [options.relation] if options.relation else list(RELATIONS)
        without = frozenset(filter(None, options.without.split(",")))
        for name in names:
            hunt.case(options.case, name, without, shrink=False)
        _tell(hunt.findings)
        print(hunt.table())
        print("\n".join(f"refused: {words}" for words in hunt.refusals))
        return int(bool(hunt.findings))
    number = 0
    told = begun
    while time.monotonic() - begun < 60.0 * options.minutes:
        known = len(hunt.findings)
        hunt.case(number, options.relation)
        _tell(hunt.findings[known:])
        number += 1
        if time.monotonic() - told > 60.0:
            told = time.monotonic()
            minutes = (told - begun) / 60.0
            print(
                f"{minutes:.0f} min: cases to {number - 1}, {len(hunt.findings)} findings",
                flush=True,
            )
    print(hunt.table())
    for words, times in hunt.refusals.most_common(12):
        print(f"refused {times} times: {words}")
    too_many = hunt.drawn > 20 and hunt.share_refused > MOST_REFUSED
    if too_many:
        print(f"{hunt.share_refused:.0%} of the scenes are refused, more than {MOST_REFUSED:.0%}")
    if options.log:
        _log(hunt, options.minutes)
    return int(bool(hunt.findings) or too_many)


def _tell(findings: list[Outcome]) -> None:
    for found in findings:
        print(f"FINDING {found.relation}: {found.words}")
        print(f"    features: {', '.join(found.features) or 'none'}")
        print(f"    {found.command}", flush=True)


def _log(hunt: Hunt, minutes: float) -> None:
    """Add the hunt to the log of all."""
    call = ["git", "-C", str(ROOT), "rev-parse", "--short=8", "HEAD"]
    commit = subprocess.run(call, capture_output=True, text=True, check=False).stdout.strip()
    entry = {
        "seed": hunt.seed,
        "commit": commit,
        "minutes": minutes,
        "cases": hunt.drawn,
        "refused": hunt.scenes_refused,
        "relations": {name: row.cases for name, row in hunt.rows.items()},
        "findings": [
            {
                "relation": x.relation,
                "case": x.number,
                "without": sorted(x.without),
                "what": x.words.splitlines()[-1][:200],
            }
            for x in hunt.findings
        ],
    }
    known = []
    if LOG.exists():
        known = json.loads(LOG.read_text(encoding="utf-8"))
    LOG.write_text(json.dumps([*known, entry], indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
