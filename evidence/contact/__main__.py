"""Check contact against what is exact and write docs/contact.md; three minutes.  Exits with 1 where a check misses."""

from __future__ import annotations

import sys

from evidence.pages import PAGES, publish
from evidence.rendering import DOCS
from evidence.tables import write

from .checks import checks
from .page import as_table
from .slack_rod import slack_table


def main() -> int:
    """Run the command."""
    found = []
    for case, m in checks():
        print(
            f"{'holds ' if m.holds else 'MISSES'} {case}: {m.what} {m.value:.3g} {m.relation} {m.bound:g}", flush=True
        )
        found.append((case, m))
    tables = {"checks": as_table(found), "slack": slack_table()}
    write(tables, DOCS / "data" / "contact")
    for path in publish(PAGES["contact"]):
        print(path)
    return int(not all(m.holds for _, m in found))


if __name__ == "__main__":
    sys.exit(main())
