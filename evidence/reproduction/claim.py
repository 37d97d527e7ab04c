"""What the source states in words, and the number of ours that decides whether we see it too."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from evidence.claims import Measurement
from evidence.tables import Tables


@dataclass(frozen=True)
class Claim:
    """``because`` says why ours differs; it is printed where the claim does not hold."""

    source: str
    measured: Measurement
    because: str = ""


@dataclass(frozen=True)
class Section:
    """A title of the page, its claims and the tables that they are made from."""

    title: str
    claims: Callable[[Tables], Sequence[Claim]]
    data: Sequence[str]
