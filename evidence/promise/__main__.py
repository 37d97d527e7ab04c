"""Wind seeded scenes with the accuracy that the defaults ask for, each against a much finer run; write docs/promise.md.

Twenty minutes on two cores.  Exits with 1 where a target is missed.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor

from tqdm import tqdm

from evidence.options import add_out
from evidence.pages import PAGES, publish
from evidence.tables import table, write

from .judging import claims
from .scenes import JUDGE, draw
from .wind import COLUMNS, judge

PAGE = PAGES["promise"]
SCENES = 200


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line; 1 where a target is missed."""
    parser = argparse.ArgumentParser("python -m evidence.promise", description=__doc__)
    add_out(parser)
    parser.add_argument("--scenes", type=int, default=SCENES, metavar="N", help=f"of the seed ({SCENES})")
    parser.add_argument("--seed", type=int, default=JUDGE, help=f"another one than the page's ({JUDGE})")
    options = parser.parse_args(arguments)
    samples = list(draw(options.seed, options.scenes))
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        rows = list(tqdm(pool.map(judge, samples), desc="promise", unit="scene", total=len(samples), leave=False))
    found = table(COLUMNS, rows)
    write({"scenes": found}, options.out / "data" / PAGE.data)
    for path in publish(PAGE, options.out):
        print(path)
    missed = [claim for claim in claims(found) if not claim.holds]
    for claim in missed:
        print(f"missed: {claim.what} is {claim.value:.3g}, wanted {claim.relation} {claim.bound:.3g}", file=sys.stderr)
    return int(bool(missed))


if __name__ == "__main__":
    sys.exit(main())
