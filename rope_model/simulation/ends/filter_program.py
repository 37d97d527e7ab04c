"""Input filter of an end as one program of CasADi's virtual machine, for the rope in Python."""

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from itertools import islice
from typing import Any, NamedTuple

from rope_model.numerics.program import Program
from rope_model.parameters import Rope
from rope_model.rules import input_filter
from rope_model.rules.end_paths import PATH, EndMotion, EndPath
from rope_model.rules.input_filter import FilterSettings, InputFilter, PathMeasures
from rope_model.rules.input_misfit import add_misfit


class FilterStep(NamedTuple):
    """Next path of an end, the filter at its end, and the measures that decide whether the rope can follow the path."""

    filter: InputFilter
    path: EndPath
    measures: PathMeasures


def _gatherer(example: Any) -> Callable[[list[Any], Any], None]:
    """Return the function that appends the numbers of tuples nested like the ``example`` to a list."""
    if not any(isinstance(part, tuple) for part in example):
        return list.extend
    parts = [_gatherer(part) if isinstance(part, tuple) else list.append for part in example]

    def gather(numbers: list[Any], x: Any) -> None:
        for add, part in zip(parts, x, strict=True):
            add(numbers, part)

    return gather


def _maker(example: Any) -> Callable[[Iterator[Any]], Any]:
    """Return the function that makes tuples nested like the ``example`` of numbers in a row."""
    if not isinstance(example, tuple):
        return next
    make: Any = getattr(type(example), "_make", tuple)
    if not any(isinstance(part, tuple) for part in example):
        return lambda numbers: make(islice(numbers, len(example)))
    parts = [_maker(part) for part in example]
    return lambda numbers: make([part(numbers) for part in parts])


_NO_PATH = EndPath(0.0, 0.0, ((0.0,) * 6,) * len(PATH))  # type: ignore[arg-type]
_NOTHING = (0.0,) * len(PATH)
_NO_SETTINGS, _NO_MOTION = (
    FilterSettings(*(0.0,) * len(FilterSettings._fields)),
    tuple(vars(EndMotion()).values()),
)
_ARGUMENTS = InputFilter(), _NO_PATH, _NO_SETTINGS, 0.0, 0.0, _NO_MOTION, 0.0
_RESULT = FilterStep(InputFilter(), _NO_PATH, PathMeasures((0.0,) * 6, _NOTHING, _NOTHING))  # type: ignore[arg-type]
_make_arguments, _make_result = _maker(_ARGUMENTS), _maker(_RESULT)
_gather_arguments, _gather_result = _gatherer(_ARGUMENTS), _gatherer(_RESULT)


@lru_cache(maxsize=64)
def _step_of(rope: Rope) -> Callable[[Sequence[Any]], list[Any]]:
    """Return ``filter_step`` for an end of the ``rope``, of its arguments in a row; one function for equal ropes."""

    def step(x: Sequence[Any]) -> list[Any]:
        state, path, settings, given_at, stop, end, leg = _make_arguments(iter(x))
        state = input_filter.filter_sample(
            state, settings, given_at, stop - path.stop, EndMotion(*end)
        )
        path = input_filter.filter_path(path, state, stop, settings.observer)
        after = add_misfit(state, path, settings, rope, leg)
        numbers: list[Any] = []
        _gather_result(numbers, FilterStep(after, path, input_filter.path_measures(path, state)))
        return numbers

    return step


def _row(arguments: tuple[Any, ...]) -> list[Any]:
    numbers: list[Any] = []
    _gather_arguments(numbers, arguments)
    return numbers


def filter_program(rope: Rope) -> Program:
    """Return the program of ``filter_step`` for an end of the ``rope``."""
    return Program(_step_of(rope), len(_row(_ARGUMENTS)))


def filter_step(
    program: Program,
    state: InputFilter,
    path: EndPath,
    settings: FilterSettings,
    given_at: float,
    stop: float,
    end: EndMotion,
    leg: float,
) -> FilterStep:
    """Return the path to ``stop`` of an end that moves as ``end`` at the instant ``given_at``, according to the host.

    ``leg`` is the length (m) of the rope from this end to the loop.
    """
    arguments = state, path, settings, given_at, stop, tuple(vars(end).values()), leg
    result: FilterStep = _make_result(iter(program(*_row(arguments))))
    return result
