"""Relations of any scene (``tests/helpers/invariants``): a few here, an hour by ``make hunt``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from exports import FLAVOURS
from invariants import hosts, runs
from invariants.case import Sketch, draw
from invariants.features import FEATURES, NOT_DRAWN
from invariants.hunt import MOST_REFUSED, RELATIONS, Hunt, judge

from rope_model import CHOICES, Scene
from rope_model.scene_names import choices_of, named_parameters

pytestmark = pytest.mark.skipif("native-2" not in FLAVOURS, reason="needs a C compiler")

SEED = 47
#: cases of the seed for each relation; some 0.2 s of a processor each, where case 0 takes a second to be laid down
FIRST = 1
CASES = 1
#: elements times steps of a run
QUICK = 8_000
#: those that wind whole hoists, or take an FMU that other tests share
WITH_FMU = ("fmu",)


@pytest.mark.parametrize("relation", [name for name in RELATIONS if name not in WITH_FMU])
def test_a_relation_holds_on_random_scenes(relation: str) -> None:
    _hold(relation)


def test_the_fmu_is_the_rope_in_process_on_random_scenes(fmu_of: Callable[[str], Path]) -> None:
    hosts.FMU["native-2"] = fmu_of("native-2")
    _hold("fmu")


def _hold(relation: str) -> None:
    """The first cases that the product does not refuse hold, as far as they come with a little work."""
    runs.WORK = QUICK
    held = 0
    for number in range(FIRST, FIRST + 20):
        outcome = judge(relation, SEED, number)
        assert not outcome.is_finding, f"{outcome.words}\n{outcome.command}"
        held += not outcome.refused
        if held == CASES:
            return
    raise AssertionError(f"{relation} is refused in {20 - held} of 20 cases")


def test_every_parameter_and_every_word_of_a_choice_is_drawn() -> None:
    found = dict[str, set[object]]()
    for number in range(400):
        for name, value in Sketch(1, number).values.items():
            found.setdefault(name, set()).add(value)
    known = {p.name for p in named_parameters(Scene())}
    assert set(found) | set(NOT_DRAWN) == known
    for name in sorted(
        set(found) & {p.name for p in named_parameters(Scene()) if choices_of(p.name)}
    ):
        assert found[name] == set(range(len(choices_of(name)))), name
    assert CHOICES


def test_every_feature_is_in_some_cases_and_not_in_all() -> None:
    cases = [Sketch(1, number).features for number in range(200)]
    for feature in FEATURES:
        share = sum(feature.__name__ in case for case in cases) / len(cases)
        assert 0.05 < share < 0.7, feature.__name__


def test_few_scenes_are_refused() -> None:
    refused = 0
    for number in range(60):
        try:
            draw(1, number)
        except ValueError:
            refused += 1
    assert refused < MOST_REFUSED * 60


def test_a_case_is_the_same_for_the_same_seed_and_without_a_feature_the_rest_stays() -> None:
    whole = Sketch(5, 3)
    again = Sketch(5, 3)
    assert whole.values == again.values
    assert (whole.times == again.times).all()
    known = {f.__name__ for f in FEATURES}
    feature = next(name for name in whole.features if name in known)
    less = Sketch(5, 3, frozenset({feature}))
    assert feature not in less.features
    assert less.values.items() <= whole.values.items() or set(less.values) <= set(whole.values)


def test_a_broken_relation_is_found_and_made_smaller(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(
        RELATIONS, "later", lambda case, draws: iter([runs.Compared("a force", 1.0, 0.5)])
    )
    hunt = Hunt(SEED)
    hunt.case(0, "later")
    (found,) = hunt.findings
    assert found.ratio == 2.0
    assert found.command.startswith(f"make hunt SEED={SEED} CASE=0 RELATION=later")
    assert len(found.features) <= 2  # a way to move, and no more
