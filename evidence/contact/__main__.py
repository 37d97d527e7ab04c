"""Check contact against what is exact and write docs/contact.md; three minutes.  Exits with 1 where a check misses."""

from __future__ import annotations

import sys

from evidence.claims import text
from evidence.contact.checks import CASES
from evidence.contact.page import as_table
from evidence.pages import PAGES, publish
from evidence.rendering import DOCS
from evidence.tables import write


def main() -> int:
    """Run the command."""
    found = []
    for case, measure in CASES.items():
        for m in measure():
            print("holds " if m.holds else "MISSES", f"{case}: {m.what} {text(m)}", flush=True)
            found.append((case, m))
    write({"checks": as_table(found)}, DOCS / "data" / "contact")
    for path in publish(PAGES["contact"]):
        print(path)
    return int(not all(m.holds for _, m in found))


if __name__ == "__main__":
    sys.exit(main())
