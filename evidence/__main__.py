"""Write pages of evidence, and README's and docs/howto/hoist.md's tables of it, from the recorded data, without a run.

``python -m evidence`` writes all, ``python -m evidence chart levels`` these.

Their texts are the templates *.md.j2 in this room.  `make chart` and the like measure anew.
"""

from __future__ import annotations

import argparse

from evidence.pages import BLOCKS, PAGES, fill, publish


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser("python -m evidence", description=__doc__)
    known = [*PAGES, *BLOCKS]
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(known)} (all)")
    names = parser.parse_args().names or known
    if unknown := set(names) - set(known):
        parser.error(f"there is no {', '.join(sorted(unknown))}; choose of {', '.join(known)}")
    for name in names:
        for path in publish(PAGES[name]) if name in PAGES else [fill(BLOCKS[name])]:
            print(path)


if __name__ == "__main__":
    main()
