"""The checks of contact, and the brushes of a divider: three minutes each."""

from tqdm import tqdm

from evidence.claims import as_table
from evidence.contact.brush import brushes, heights
from evidence.contact.checks import CASES
from evidence.tables import Measures, Tables


def checks() -> Tables:
    """Make the checks of all cases."""
    cases = tqdm(CASES.items(), desc="contact", unit="case", leave=False)
    return {
        "checks": as_table(("case",), [((case,), m) for case, measure in cases for m in measure()])
    }


MEASURES: Measures = {
    "checks": checks,
    "brushes": lambda: {"brushes": brushes(), "heights": heights()},
}
