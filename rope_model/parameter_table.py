"""Table of parameters: fields of data classes with unit, description, bounds and choices.

``parameter`` and ``choice`` make such fields.  The table serves the checks of the data classes, the
C structures and checks (codegen.tables), the FMU's interface, its documents, studies and reports.
"""

import math
import numbers
import re
from collections.abc import Callable, Mapping
from dataclasses import field, fields
from typing import Any, NamedTuple, TypeVar, get_args

T = TypeVar("T")
#: rad, a full turn as messages round it
_TURN = 6.2832
#: least value of parameters above 0, because tools know no open intervals
LEAST_POSITIVE = 1e-15


class Parameter(NamedTuple):
    """Facts of a parameter; name and default value are the field's."""

    unit: str  # unit as FMI writes it, "1" of a pure number, "" of a count or a choice
    description: str  # [assumed] marks data that are ours
    lower: float | str | None = None  # least value, or name of the field with it
    upper: float | str | None = None  # largest value, or name of the field with it
    cure: str = ""  # advice for a value out of bounds
    tunable: bool = False  # may change between steps
    choices: Mapping[str, str] = {}  # words and their meanings; the index of a word is its code

    @property
    def other(self) -> str:
        """Name of the field that bounds this one, or ''."""
        return next((bound for bound in (self.lower, self.upper) if isinstance(bound, str)), "")

    @property
    def bound(self) -> str:
        """Bounds in words, with {} for the value of a field that is a bound; '' without bounds."""
        if self.choices:
            return f"one of {', '.join(self.choices)}"
        if self.lower is None:
            return ""
        lower = _words(self.lower)
        upper = _words(self.upper)
        unit = re.sub(r"(?<=[a-z])(\d)", r"^\1", self.unit).replace(".", " ")
        return (f"in [{lower}, {upper}]" if upper else f">= {lower}") + (
            f" {unit}" if unit not in ("", "1") else ""
        )


class CrossCheck(NamedTuple):
    """Check of several parameters of a data class ``x``; codegen.tables makes the C of it."""

    what: str
    bound: str  # with {} or {:.4g} for a number
    cure: str
    # x -> conditions, the value, and the number in the bound, if any
    formula: Callable[[Any], tuple[Any, ...]]


class Bounds(NamedTuple):
    """Bounds of a parameter and advice for a value beyond them, as in Parameter."""

    lower: float | str | None = None
    upper: float | str | None = None
    cure: str = ""


_ANY = Bounds()


def at_least(lower: float | str, cure: str) -> Bounds:
    """Return a lower bound only."""
    return Bounds(lower, None, cure)


def parameter(
    default: T, unit: str, description: str, bounds: Bounds = _ANY, tunable: bool = False
) -> T:
    """Return a field that is a number, with the facts of Parameter."""
    return field(default=default, metadata=Parameter(unit, description, *bounds, tunable)._asdict())


def angle_parameter(description: str) -> float:
    """Return a field that is an angle of at most a full turn; a larger number was given in degrees."""
    cure = "give it in radians: 45 degrees are 0.7854"
    return parameter(0.0, "rad", description, Bounds(-_TURN, _TURN, cure))


def choice(default: T, words: Any, meanings: tuple[str, ...], description: str, cure: str) -> T:
    """Return a field that is one of the words of a Literal, each with its meaning."""
    choices = dict(zip(get_args(words), meanings, strict=True))
    return field(
        default=default, metadata=Parameter("", description, cure=cure, choices=choices)._asdict()
    )


#: caches by data class: its table, and the table in the order of the checks
_TABLES: dict[Any, dict[str, Parameter]] = {}
_CHECKED: dict[Any, tuple[tuple[str, Parameter], ...]] = {}


def parameters_of(kind: type[Any]) -> dict[str, Parameter]:
    """Return the parameters of a data class by name."""
    if kind not in _TABLES:
        _TABLES[kind] = {f.name: Parameter(**f.metadata) for f in fields(kind)}
    return _TABLES[kind]


def check_order(kind: type[Any]) -> tuple[tuple[str, Parameter], ...]:
    """Return the parameters in the order of the checks: choices first, those bounded by another field last."""
    if kind not in _CHECKED:
        table = parameters_of(kind).items()
        _CHECKED[kind] = tuple(
            sorted(table, key=lambda item: (not item[1].choices, bool(item[1].other)))
        )
    return _CHECKED[kind]


def numeric_bounds(kind: type[Any], name: str) -> tuple[float | None, float | None]:
    """Return the bounds of a parameter as numbers, taken from the field that bounds it if there is one."""
    table = parameters_of(kind)
    p = table[name]
    lower = table[p.lower].lower if isinstance(p.lower, str) else p.lower
    upper = table[p.upper].upper if isinstance(p.upper, str) else p.upper
    assert not isinstance(lower, str)
    assert not isinstance(upper, str)
    return lower, upper


def require(ok: bool, what: str, value: Any, bound: str, cure: str) -> None:
    """Raise ValueError with value, bound and cure unless ``ok``."""
    if not ok:
        raise ValueError(f"{what} = {value!r} is out of range: it must be {bound}; {cure}")


def require_number(name: str, value: object, *, whole: bool = False) -> None:
    """Raise ValueError unless the value is a finite real number, and without a fraction if ``whole``.

    True and False are none, nor is an array with one number; numbers of numpy are.
    """
    if type(value) is not float:
        if isinstance(value, str):
            cure = "give it without quotation marks"
        else:
            cure = "give one, or leave it out for the default"
        is_number = isinstance(value, numbers.Real) and not isinstance(value, bool)
        require(is_number, name, value, "a number", cure)
    assert isinstance(value, int | float | numbers.Real)
    require(math.isfinite(value), name, value, "finite", "give a number")
    if whole:
        require(value == math.floor(value), name, value, "a whole number", "leave out the fraction")


_NO_CHECKS: tuple[CrossCheck, ...] = ()


class ParameterGroup:
    """Data that are checked when they are made."""

    cross_checks = _NO_CHECKS

    def __post_init__(self) -> None:
        self.require_in_bounds()

    def require_in_bounds(self) -> None:
        """Raise ValueError unless all are finite, of their choices, in their bounds, and ``cross_checks`` hold."""
        order = check_order(type(self))
        for name, p in order:
            value = getattr(self, name)
            default = getattr(type(self), name)
            if not p.choices and isinstance(default, int | float):
                require_number(name, value, whole=isinstance(default, int))
        for name, p in order:
            value = getattr(self, name)
            if p.choices:
                ok = isinstance(value, str) and value in p.choices
            else:
                if isinstance(p.lower, str):
                    lower = getattr(self, p.lower)
                else:
                    lower = p.lower
                if isinstance(p.upper, str):
                    upper = getattr(self, p.upper)
                else:
                    upper = p.upper
                ok = (lower is None or lower <= value) and (upper is None or value <= upper)
            if not ok:
                if p.other:
                    bound = p.bound.format(repr(getattr(self, p.other)))
                else:
                    bound = p.bound
                require(False, name, value, bound, p.cure)
        for what, bound, cure, formula in self.cross_checks:
            holds, value, *number = formula(self)
            require(all(holds), what, value, bound.format(*number), cure)


def _words(bound: float | str | None) -> str:
    if bound is None:
        return ""
    return f"{bound} = {{}}" if isinstance(bound, str) else f"{bound:g}"
