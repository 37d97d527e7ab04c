"""Row of the verdict, and the heads of its columns."""

from dataclasses import dataclass

NO_BOUND = "none asked"
_WHERE = "when and where: x, z from midway between the conveyances, y from the lower landing"
COLUMNS = ("", "value", "bound", "kept", _WHERE)


@dataclass(frozen=True)
class VerdictRow:
    """Row of the verdict: a quantity, its value, its bound and whether that holds.

    None without a bound.
    """

    quantity: str
    value: str
    bound: str = NO_BOUND
    holds: bool | None = None
    where: str = ""

    @property
    def cells(self) -> tuple[str, ...]:
        """Texts in the order of COLUMNS."""
        kept = {None: "", True: "yes", False: "NO"}[self.holds]
        return self.quantity, self.value, self.bound, kept, self.where
