"""Wind seeded scenes with the accuracy that the defaults ask for, each against a much finer run; write docs/promise.md.

Twenty minutes on two cores.  Exits with 1 where a target is missed.  Another draw, or another accuracy, is judged and
printed without a page; its table is written where --out says.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial

from tqdm import tqdm

from evidence.options import add_out
from evidence.pages import PAGES, publish
from evidence.rendering import DOCS
from evidence.tables import Table, table, write
from rope_model import Accuracy

from . import scenes, wide
from .judging import TARGETS, claims, completed, over_asked
from .wind import ASKED, COLUMNS, judge

PAGE = PAGES["promise"]
SCENES = 200
DRAWS = {"first": scenes, "wide": wide}
#: columns that are printed of the worst scenes, and how many of these
SHOWN, WORST = ("end force", "end force, estimated", "loop [m]", "loop, estimated [m]"), 10


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line; 1 where a target is missed."""
    parser = argparse.ArgumentParser("python -m evidence.promise", description=__doc__)
    add_out(parser)
    parser.add_argument("--draw", choices=DRAWS, default="first", help="ranges of the scenes (first, that of the page)")
    parser.add_argument("--scenes", type=int, default=SCENES, metavar="N", help=f"of the seed ({SCENES})")
    parser.add_argument("--seed", type=int, help="another one than the draw's judging seed")
    parser.add_argument(
        "--asked", type=float, nargs=2, metavar=("FORCE", "LOOP"), default=(ASKED.end_force, ASKED.loop)
    )
    parser.add_argument("--workers", type=int, default=os.cpu_count(), metavar="N", help="processes (one per core)")
    options = parser.parse_args(arguments)
    draw, asked = DRAWS[options.draw], Accuracy(*options.asked)
    samples = list(draw.draw(draw.JUDGE if options.seed is None else options.seed, options.scenes))
    with ProcessPoolExecutor(options.workers) as pool:
        rows = pool.map(partial(judge, asked=asked), samples)
        found = table(COLUMNS, list(tqdm(rows, desc="promise", unit="scene", total=len(samples), leave=False)))
    is_page = draw is scenes and asked == ASKED
    if is_page or options.out != DOCS:
        write({"scenes": found}, options.out / "data" / PAGE.data)
    if is_page:
        for path in publish(PAGE, options.out):
            print(path)
    told = claims(found, TARGETS[options.draw], asked)
    if not is_page:
        _print(found, asked)
        for claim in told:
            print(f"{claim.what}: {claim.value:.3g}")
    missed = [claim for claim in told if not claim.holds]
    for claim in missed:
        print(f"missed: {claim.what} is {claim.value:.3g}, wanted {claim.relation} {claim.bound:.3g}", file=sys.stderr)
    return int(bool(missed))


def _print(found: Table, asked: Accuracy) -> None:
    """The worst scenes, and all that did not complete."""
    t = completed(found)
    over = over_asked(t, asked)
    for k in (-over).argsort()[:WORST]:
        errors = ", ".join(f"{name} {t[name][k]:.2g}" for name in SHOWN)
        print(f"scene {t['scene'][k]:.0f}, {t['kind'][k]}: {over[k]:.2g} times what was asked; {errors}")
    print("\n".join(sorted({str(x) for x in found["failure"] if str(x) not in ("", "nan")})), end="")


if __name__ == "__main__":
    sys.exit(main())
