"""Write pages of evidence, and the tables of it in hand-written pages, from the recorded data, without a run.

``python -m evidence`` writes all, ``python -m evidence accuracy levels`` these.  ``--measure accuracy`` first measures
a package, ``--measure accuracy:depth`` a part of it; the exit code is 1 where a claim about it is missed.
The texts are the templates *.md.j2 of the packages.  ``python -m evidence.promise`` is apart.
"""

import argparse
import sys
from importlib import import_module

from evidence.claims import missed
from evidence.pages import BLOCKS, PAGES, fill, publish
from evidence.rendering import DOCS
from evidence.tables import read, write

#: packages that ``--measure`` knows: the module ``measure`` of each has MEASURES, and may have ``missed``
PACKAGES = (
    *("accuracy", "choice", "contact", "coupling", "discrete_rod", "assumed_data"),
    *("latency", "exudyn", "reproduction", "shaking", "signals", "stability", "validation"),
)


def measure(package: str, part: str) -> list[str]:
    """Measure all parts of a package, or one, and write their tables; return the claims that are missed."""
    module = import_module(f"evidence.{package}.measure")
    for name, tables in module.MEASURES.items():
        if part in ("", name):
            write(tables(), DOCS / "data" / package)
    found = read(DOCS / "data" / package)
    return [*missed(found), *(module.missed(found) if hasattr(module, "missed") else ())]


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser("python -m evidence", description=__doc__)
    known = [*PAGES, *BLOCKS]
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(known)} (all)")
    packages = f"{', '.join(PACKAGES)}; a colon and the name of a part measures that alone"
    parser.add_argument("--measure", nargs="+", default=[], metavar="PACKAGE", help=packages)
    options = parser.parse_args()
    if unknown := set(options.names) - set(known):
        parser.error(f"there is no {', '.join(sorted(unknown))}; choose one of {', '.join(known)}")
    asked = [x.partition(":")[::2] for x in options.measure]
    if unknown := {package for package, _ in asked} - set(PACKAGES):
        parser.error(
            f"there is no package {', '.join(sorted(unknown))}; choose one of {', '.join(PACKAGES)}"
        )
    told = [claim for package, part in asked for claim in measure(package, part)]
    for name in options.names or known:
        for path in publish(PAGES[name]) if name in PAGES else [fill(BLOCKS[name])]:
            print(path)
    for claim in told:
        print(f"missed: {claim}", file=sys.stderr)
    return int(bool(told))


if __name__ == "__main__":
    sys.exit(main())
