"""Windings with samples of all uncertain data, and which datum causes the spread.

The samples are a scrambled Sobol sequence in the shares of the ranges (A. B. Owen;
scipy.stats.qmc).  What a datum causes is judged by ranks, which ask for monotony only: with the
standardised ranks of the data x, of a result y,

    y = sum_k b_k x_k + rest        share of datum k: b_k^2        unexplained: 1 - R^2

The data vary independently, so that the shares add up to R^2 but for what the sample leaves of
correlation.
"""

import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from multiprocessing import get_context

import numpy as np
import scipy  # loads stats, slowly, when they are used

from hoist_demo.cosimulation.progress import warnings_of
from hoist_demo.recording.passages import PASSED, passages
from hoist_demo.recording.ropes import computed, rope_signals
from hoist_demo.recording.time_series import Array
from hoist_demo.run.metrics import measure_ropes
from hoist_demo.run.wind import wind_run
from hoist_demo.uncertainty.definition import UncertaintyFile

WindingResult = tuple[dict[str, float], tuple[str, ...]]  #: Measures by name, and remarks.
QUANTILES = (0.05, 0.5, 0.95)  #: Quantiles of each measure in the results.
#: sum of the shares of data that vary independently, from which on their correlation in the sample
#: spoils them
SPOILED = 1.1
UNEXPLAINED = "unexplained"  #: Name of the part of a spread that no datum explains.
STOPPED = "stopped: "  #: Prefix of the cause of a winding's stop.
#: Prefix of what a rope passed through: its winding describes no real rope.
LEFT_OUT = "left out: "
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


@dataclass(frozen=True)
class UncertaintyResult:
    """Results of all windings, a row each: what varied and what was measured.

    NaN where the winding has stopped before, its rope has passed through something, or it shows no
    such thing: the rope's model may not compute it.
    """

    file: UncertaintyFile
    columns: Mapping[str, Array]
    # warnings and causes of stops: in how many windings
    remarks: Mapping[str, int] = field(default_factory=dict)

    def has(self, name: str) -> Array:
        """Select the windings that have this measure."""
        return np.isfinite(self.columns[name])

    def quantiles(self, name: str) -> tuple[float, ...]:
        """Return the QUANTILES of a measure."""
        values = self.columns[name][self.has(name)]
        if not values.size:
            return (math.nan,) * len(QUANTILES)
        return tuple(float(x) for x in np.quantile(values, QUANTILES))

    @property
    def completed(self) -> int:
        """Number of windings that came to their end with a rope that passed through nothing."""
        unfit = (STOPPED, LEFT_OUT)
        return self.file.header.samples - sum(
            count for text, count in self.remarks.items() if text.startswith(unfit)
        )

    @property
    def exit_code(self) -> int:
        """Exit code of the command: 1 if a winding does not count."""
        if self.completed == self.file.header.samples:
            return 0
        return 1

    @property
    def needed(self) -> int:
        """Windings from which on a regression leaves a rest by which to judge it."""
        return len(self.file.data) + 2

    def causes(self, name: str) -> dict[str, float]:
        """Return each datum's share in a measure's spread, and the unexplained.

        {} if too few or contradictory.
        """
        shares = self._shares(name)
        if sum(shares.values()) > SPOILED:
            return {}
        return shares

    def spoiled(self, name: str) -> float:
        """Return the sum of the shares over the spread if they contradict one another; else 0."""
        total = sum(self._shares(name).values())
        if total > SPOILED:
            return total
        return 0.0

    def _shares(self, name: str) -> dict[str, float]:
        selected = self.has(name)
        y = self.columns[name][selected]
        if y.size < self.needed or np.ptp(y) == 0.0:
            return {}
        x = np.array([_standard(self.columns[key][selected]) for key in self.file.data])
        y = _standard(y)
        b = np.linalg.lstsq(x.T, y, rcond=None)[0]
        rest = y - b @ x
        shares = {key: float(share) for key, share in zip(self.file.data, b * b, strict=True)}
        return shares | {UNEXPLAINED: float(rest @ rest / (y @ y))}


def run_windings(
    file: UncertaintyFile,
    workers: int,
    progress: Callable[[Iterable[WindingResult]], Iterable[WindingResult]] = iter,
) -> UncertaintyResult:
    """Wind the sampled ropes in ``workers`` processes, and return the spread of the measures."""
    samples = draw(file)
    if workers == 1:
        results = list(progress(wind_once(file, values) for values in samples))
    else:
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            results = list(progress(pool.map(wind_once, [file] * len(samples), samples)))
    columns: dict[str, Array] = {}
    for name in file.data:
        columns[name] = np.array([values[name] for values in samples])
    for name in file.measured:
        columns[name] = np.array([measures[name] for measures, _ in results])
    return UncertaintyResult(file, columns, remarks_of([texts for _, texts in results]))


def draw(file: UncertaintyFile) -> list[dict[str, float]]:
    """Draw the values of what varies, one set per winding."""
    sequence = scipy.stats.qmc.Sobol(len(file.data), rng=np.random.default_rng(file.header.seed))
    shares = sequence.random_base2(round(math.log2(file.header.samples)))
    samples = []
    for row in shares:
        values: dict[str, float] = {}
        for (key, datum), share in zip(file.data.items(), row, strict=True):
            values[key] = datum.at(float(share))
        samples.append(values)
    return samples


def wind_once(file: UncertaintyFile, values: Mapping[str, float]) -> WindingResult:
    """Return the measures of one winding with its warnings.

    NaN, with the reason, if it shows no real rope.
    """
    ropes = file.ropes(values)
    run = ropes.run
    with warnings_of("hoist_demo") as warnings:
        result = wind_run(run, ropes.plant)
    identities = ropes.data()
    torque_free = {rope.name: rope.torque_free for rope in identities}
    result = replace(result, recording=computed(result.recording, torque_free))
    sentences: list[str] = []
    for rope in identities:
        text = passages(rope_signals(result.recording, rope.name))
        if text:
            sentences.append(f"{rope.prefix.replace('.', ' ')}{text}")
    passed = "; ".join(sentences)
    if result.completed and PASSED not in passed:
        metrics = measure_ropes(result, run.hoist, run.arrival, [rope.name for rope in identities])
        measures = {name: metrics[name] for name in file.measured}
        return measures, tuple(f"warning: {text}" for text in warnings)
    reason = f"{STOPPED}{result.cause}"
    if result.completed:
        reason = f"{LEFT_OUT}{passed}"
    return dict.fromkeys(file.measured, math.nan), (reason,)


def remarks_of(remarks: Sequence[Iterable[str]]) -> dict[str, int]:
    """Return remarks with the number of windings of each.

    Numbers that differ between windings become ranges.
    """
    Words = tuple[str, ...]
    numbers_by_words: dict[Words, set[tuple[str, ...]]] = {}
    windings_by_words: dict[Words, set[int]] = {}
    for k, texts in enumerate(remarks):
        for text in texts:
            words = tuple(_NUMBER.split(text))
            numbers_by_words.setdefault(words, set()).add(tuple(_NUMBER.findall(text)))
            windings_by_words.setdefault(words, set()).add(k)
    counts: dict[str, int] = {}
    for words, numbers in numbers_by_words.items():
        counts[_with_numbers(words, numbers)] = len(windings_by_words[words])
    return counts


def _with_numbers(words: Sequence[str], numbers: Collection[Sequence[str]]) -> str:
    """Return a remark with its numbers, or with the range of those that differ."""
    texts = []
    for values in zip(*numbers, strict=True):
        distinct = sorted({*values}, key=float)
        text = distinct[0]
        texts.append(text if len(distinct) == 1 else f"{text} to {distinct[-1]}")
    return "".join(word + number for word, number in zip(words, (*texts, ""), strict=True))


def _standard(values: Array) -> Array:
    """Return ranks with mean 0 and variance 1."""
    ranks = scipy.stats.rankdata(values)
    return np.asarray((ranks - ranks.mean()) / ranks.std())
