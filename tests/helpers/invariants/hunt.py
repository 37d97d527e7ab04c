"""Cases times relations: what holds, what the product refuses, and findings, made smaller by leaving features out."""

from __future__ import annotations

import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from invariants import books, hosts, neutral, states, steps, symmetries
from invariants.case import Case, Sketch, draw
from invariants.features import Draws
from invariants.runs import Compared, Finding, Refused

Relation = Callable[[Case, Draws], Iterator[Compared]]
#: all relations by name
RELATIONS: dict[str, Relation] = {
    relation.__name__: relation
    for relation in (
        *symmetries.RELATIONS,
        *books.RELATIONS,
        *neutral.RELATIONS,
        *states.RELATIONS,
        *steps.RELATIONS,
        *hosts.RELATIONS,
        *hosts.SELDOM,
    )
}
#: relations that are tried on each case, so that many cases are seen
TRIED = 3
#: those that wind a whole hoist are tried in this share of the cases
SELDOM = tuple(relation.__name__ for relation in hosts.SELDOM)
SHARE_OF_SELDOM = 0.05
#: share of cases that the product may refuse
MOST_REFUSED = 0.3


@dataclass(frozen=True)
class Outcome:
    """How a relation was found on a case: the worst comparison, a refusal, or what is wrong."""

    relation: str
    seed: int
    number: int
    features: tuple[str, ...]
    without: frozenset[str] = frozenset()
    worst: Compared | None = None
    refused: str = ""
    broken: str = ""

    @property
    def ratio(self) -> float:
        if self.worst is None:
            return 0.0
        return self.worst.ratio

    @property
    def is_finding(self) -> bool:
        return bool(self.broken) or self.ratio > 1.0

    @property
    def words(self) -> str:
        return self.broken or str(self.worst)

    @property
    def command(self) -> str:
        """The command that shows it again."""
        command = f"make hunt SEED={self.seed} CASE={self.number} RELATION={self.relation}"
        if self.without:
            command += f' WITHOUT="{",".join(sorted(self.without))}"'
        return command


def judge(name: str, seed: int, number: int, without: frozenset[str] = frozenset()) -> Outcome:
    """The outcome of a relation on a case."""
    features = tuple(Sketch(seed, number, without).features)
    known = {
        "relation": name,
        "seed": seed,
        "number": number,
        "features": features,
        "without": without,
    }
    try:
        case = draw(seed, number, without)
        found = list(RELATIONS[name](case, Draws(seed, number, name)))
    except ValueError as error:
        last = traceback.extract_tb(error.__traceback__)[-1].filename
        if "rope_model" not in last and "hoist_demo" not in last:
            return Outcome(**known, broken=traceback.format_exc())
        return Outcome(**known, refused=f"made: {error}")
    except Refused as refusal:
        return Outcome(**known, refused=str(refusal))
    except Finding as finding:
        return Outcome(**known, broken=str(finding))
    except Exception:  # a traceback of any other kind is a finding, not the end of the hunt
        return Outcome(**known, broken=traceback.format_exc())
    return Outcome(**known, worst=max(found, key=lambda x: x.ratio, default=None))


def tried(seed: int, number: int, only: str = "") -> list[str]:
    """Names of the relations that a case is tried with."""
    if only:
        return [only]
    draws = Draws(seed, number, "relations")
    usual = [name for name in RELATIONS if name not in SELDOM]
    names = [usual.pop(int(draws.evenly(0.0, len(usual)))) for _ in range(TRIED)]
    return names + [name for name in SELDOM if draws.chance(SHARE_OF_SELDOM)]


def smaller(outcome: Outcome) -> Outcome:
    """The same finding without the features that it does not need."""
    for feature in outcome.features:
        less = judge(outcome.relation, outcome.seed, outcome.number, outcome.without | {feature})
        if less.is_finding and bool(less.broken) == bool(outcome.broken):
            outcome = less
    return outcome


@dataclass
class Row:
    """Counts of one relation."""

    cases: int = 0
    refused: int = 0
    findings: int = 0
    worst: float = 0.0  # largest ratio of a difference to its bound that is no finding
    seconds: float = 0.0  # of a processor


@dataclass
class Hunt:
    """A hunt of one seed."""

    seed: int
    rows: dict[str, Row] = field(default_factory=dict)
    findings: list[Outcome] = field(default_factory=list)
    refusals: Counter[str] = field(default_factory=Counter)
    drawn: int = 0
    scenes_refused: int = 0

    def case(
        self,
        number: int,
        only: str = "",
        without: frozenset[str] = frozenset(),
        shrink: bool = True,
    ) -> None:
        """Try a case's relations."""
        self.drawn += 1
        refused = False
        for name in tried(self.seed, number, only):
            begun = time.process_time()
            outcome = judge(name, self.seed, number, without)
            row = self.rows.setdefault(name, Row())
            row.cases += 1
            if outcome.refused:
                row.refused += 1
                self.refusals[outcome.refused.split(":")[-1].strip()[:60]] += 1
                refused |= outcome.refused.startswith(("made", "hung"))
            elif outcome.is_finding:
                row.findings += 1
                # the others of a relation are as a rule the same, and a smaller case takes twenty
                # runs
                first = all(known.relation != name for known in self.findings)
                if shrink and first:
                    outcome = smaller(outcome)
                self.findings.append(outcome)
            else:
                row.worst = max(row.worst, outcome.ratio)
            row.seconds += time.process_time() - begun
        self.scenes_refused += refused

    @property
    def share_refused(self) -> float:
        return self.scenes_refused / max(self.drawn, 1)

    def table(self) -> str:
        """Relations by what was found."""
        lines = [
            f"{'relation':<24}{'cases':>7}{'refused':>9}{'findings':>10}{'worst/bound':>13}{'s':>8}"
        ]
        for name in RELATIONS:
            if row := self.rows.get(name):
                lines.append(
                    f"{name:<24}{row.cases:>7}{row.refused:>9}{row.findings:>10}{row.worst:>13.2g}{row.seconds:>8.1f}"
                )
        lines.append(
            f"{self.drawn} cases, {self.scenes_refused} refused, {len(self.findings)} findings"
        )
        return "\n".join(lines)
