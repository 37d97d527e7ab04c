"""Write pages of evidence from the recorded data, without a run: ``python -m evidence [PAGE ...]``.

Their texts are the templates *.md.j2 in this room.  `make chart` and the like measure anew.
"""

from __future__ import annotations

import argparse

from evidence.pages import PAGES, publish


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser("python -m evidence", description=__doc__)
    parser.add_argument("pages", nargs="*", metavar="PAGE", help=f"{', '.join(PAGES)} (all)")
    names = parser.parse_args().pages or list(PAGES)
    if unknown := set(names) - set(PAGES):
        parser.error(f"there is no page {', '.join(sorted(unknown))}; choose of {', '.join(PAGES)}")
    for name in names:
        for path in publish(PAGES[name]):
            print(path)


if __name__ == "__main__":
    main()
