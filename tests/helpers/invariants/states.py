"""States: a rope that goes on from what was saved is the same rope, to the bit."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable, Iterator

import numpy as np

from invariants.case import Case
from invariants.features import Draws
from invariants.runs import READ, Compared, Record, made, step, wind
from rope_model import BalanceRope


def _saved(case: Case, rope: BalanceRope) -> BalanceRope:
    """Through bytes, into a rope that was never hung up."""
    other = made(case)
    other.restore(rope.save())
    return other


def _snapshot(case: Case, rope: BalanceRope) -> BalanceRope:
    """Back from a step that was taken on trial."""
    kept = rope.snapshot()
    step(case, rope, len(case.times) - 1)
    rope.restore(kept)
    return rope


def _pickled(case: Case, rope: BalanceRope) -> BalanceRope:
    other: BalanceRope = pickle.loads(pickle.dumps(rope))
    return other


def _copied(case: Case, rope: BalanceRope) -> BalanceRope:
    return copy.deepcopy(rope)


WAYS = (_saved, _snapshot, _pickled, _copied)


def restored(case: Case, draws: Draws) -> Iterator[Compared]:
    """Restored at a few instants, each time in another way."""
    one = wind(case)
    last = len(one.rows) - 1
    chosen = {1 + int(draws.evenly(0.0, max(last - 1, 1))): draws.one_of(*WAYS) for _ in range(4)}

    def before(rope: BalanceRope, k: int) -> BalanceRope:
        if k not in chosen:
            return rope
        return chosen[k](one.case, rope)

    two = wind(one.case, before, work=np.inf)
    yield from _to_the_bit(one, two)


def _to_the_bit(one: Record, two: Record) -> Iterator[Compared]:
    yield Compared("steps to the end", float(abs(len(one.rows) - len(two.rows))), 0.0)
    last = min(len(one.rows), len(two.rows))
    for name in READ:
        yield Compared(name, float(np.abs(two[name][:last] - one[name][:last]).max()), 0.0)


RELATIONS: tuple[Callable[[Case, Draws], Iterator[Compared]], ...] = (restored,)
