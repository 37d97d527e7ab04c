"""Step of an end that follows its host's motions, in CasADi's virtual machine for the rope in Python."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from rope_model.numerics.program import Program
from rope_model.parameters import Rope
from rope_model.simulation.ends.following import Following, Limits, Manner, follow_limits, follow_path, follow_sample
from rope_model.simulation.ends.misfit import follow_account
from rope_model.simulation.ends.paths import PATH, EndMotion, EndPath


class Followed(NamedTuple):
    """Next path of an end, with its account, and the measures that decide whether it can be followed."""

    following: Following
    path: EndPath
    limits: Limits


class _Row:
    """Takes tuples nested like an example apart into their numbers in a row, and makes them of such a row.

    Both are compiled once from the places of the numbers, since they run in every step.
    """

    def __init__(self, example: Any) -> None:
        types: dict[str, Any] = {}
        self.size = 0

        def made(part: Any) -> str:
            if not isinstance(part, tuple):
                self.size += 1
                return f"x[{self.size - 1}]"
            types[type(part).__name__] = type(part)
            inside = "".join(f"{made(inner)}, " for inner in part)
            return f"{type(part).__name__}({inside})" if hasattr(part, "_fields") else f"({inside})"

        self.made: Any = eval(f"lambda x: {made(example)}", types)
        self.numbers: Any = eval(f"lambda x: [{', '.join(_places(example, 'x'))}]")


def _places(part: Any, place: str) -> list[str]:
    if not isinstance(part, tuple):
        return [place]
    return [found for i, inner in enumerate(part) for found in _places(inner, f"{place}[{i}]")]


_NO_PATH = EndPath(0.0, 0.0, ((0.0,) * 6,) * len(PATH))  # type: ignore[arg-type]
_NOTHING = (0.0,) * len(PATH)
_NO_MANNER, _NO_MOTION = Manner(*(0.0,) * len(Manner._fields)), tuple(vars(EndMotion()).values())
_TAKEN = _Row((Following(), _NO_PATH, _NO_MANNER, 0.0, 0.0, _NO_MOTION, 0.0))
_RETURNED = _Row(Followed(Following(), _NO_PATH, Limits((0.0,) * 6, _NOTHING, _NOTHING)))  # type: ignore[arg-type]


def follow_program(rope: Rope) -> Program:
    """follow_sample, follow_path, follow_limits and follow_account of an end of the ``rope``, for ``follow``."""

    def followed(x: Sequence[Any]) -> list[Any]:
        now, path, manner, given_at, stop, end, leg = _TAKEN.made(x)
        now = follow_sample(now, manner, given_at, stop - path.stop, EndMotion(*end))
        path = follow_path(path, now, stop, manner.observer)
        account = follow_account(now, path, manner, rope, leg)
        numbers: list[Any] = _RETURNED.numbers(Followed(account, path, follow_limits(path, now)))
        return numbers

    return Program(followed, _TAKEN.size)


def follow(
    program: Program,
    now: Following,
    path: EndPath,
    manner: Manner,
    given_at: float,
    stop: float,
    end: EndMotion,
    leg: float,
) -> Followed:
    """Return the path to ``stop`` of an end whose host says of ``given_at`` that it moves as ``end``.

    ``leg`` is the length (m) of the rope from this end to the loop.
    """
    taken = now, path, manner, given_at, stop, tuple(vars(end).values()), leg
    followed: Followed = _RETURNED.made(program(*_TAKEN.numbers(taken)))
    return followed
