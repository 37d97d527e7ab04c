"""Wind seeded scenes with the accuracy that is asked for, each against a much finer run; write docs/promise.md.

Half an hour on two cores that do nothing else.  Each scene's rows are kept in build/promise as soon as they are there,
so that a run that was cut goes on.  Cheap scenes come first.  Exits with 1 where a target is missed.
"""

import argparse
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from evidence.claims import text
from evidence.pages import PAGES, publish
from evidence.promise.judging import claims
from evidence.promise.scenes import JUDGE, REQUESTED, SCENES, Sample, draw
from evidence.promise.wind import COLUMNS, REQUESTS, SETTLE, judge
from evidence.rendering import DOCS
from evidence.tables import read, table, write
from rope_model import balance_rope
from rope_model.codegen.platforms import text_hash

PAGE = PAGES["promise"]


def main() -> int:
    """The command line; 1 where a target is missed."""
    parser = argparse.ArgumentParser("python -m evidence.promise", description=__doc__)
    parser.add_argument(
        "--scenes", type=int, default=SCENES, metavar="N", help=f"of the seed ({SCENES})"
    )
    parser.add_argument(
        "--seed", type=int, default=JUDGE, help=f"another one than {JUDGE}, which judges: no page"
    )
    options = parser.parse_args()
    folder = (
        Path("build")
        / "promise"
        / f"{options.seed}-{text_hash(Path(__file__).parents[2] / 'rope_model')}"
    )
    begun = time.monotonic()
    samples = draw(options.seed, options.scenes)
    cheap_first = sorted(
        samples, key=lambda s: (s.trajectory.duration + SETTLE) * balance_rope(s.scene).elements
    )
    with ProcessPoolExecutor() as pool:
        rest = [s for s in cheap_first if not (folder / f"{s.number:03d}.csv").exists()]
        for number in pool.map(_keep, rest, [folder] * len(rest)):
            print(f"scene {number}: {time.monotonic() - begun:.0f} s", flush=True)
    parts = read(folder).values()
    found = {name: np.concatenate([t[name] for t in parts]) for name in COLUMNS}
    if options.seed == JUDGE:
        write({"scenes": found}, DOCS / "data" / PAGE.data)
        for path in publish(PAGE):
            print(path)
    told = claims(found)
    for claim in told:
        print(f"{'' if claim.holds else 'MISSED '}{claim.what}: {text(claim)}")
    return int(not all(claim.holds for claim in told))


def _keep(sample: Sample, folder: Path) -> int:
    """Judge a scene and keep its rows; return its number."""
    asked = [*REQUESTS] if sample.number < REQUESTED else [*REQUESTS][:1]
    write({f"{sample.number:03d}": table(COLUMNS, judge(sample, asked))}, folder)
    return sample.number


if __name__ == "__main__":
    sys.exit(main())
