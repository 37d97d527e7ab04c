"""Fields of the host's data classes by dotted names: their types and units, and copies with some of them changed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, Literal, get_args, get_origin, get_type_hints

from hoist_demo.parameters.parameter import Parameter
from hoist_demo.parameters.quantity import units_of
from hoist_demo.parameters.units import fmi_unit

_KINDS = {bool: "Boolean", int: "Integer", str: "String", float: "Real"}


def leaves(data: type[Any], prefix: str = "") -> Iterator[Parameter]:
    """All single values of a data class, by dotted names; `brake: Brake | None` stands for the brake's own."""
    hints, units = get_type_hints(data), units_of(data)
    for field in fields(data):
        inner = _inner(hints[field.name])
        if inner is not None:
            yield from leaves(inner, f"{prefix}{field.name}.")
            continue
        if get_origin(hints[field.name]) is Literal:
            yield Parameter(f"{prefix}{field.name}", "1", "String", choices=get_args(hints[field.name]))
            continue
        kinds = [_KINDS[t] for t in (hints[field.name], *get_args(hints[field.name])) if t in _KINDS]
        if kinds:
            numeric = kinds[0] in ("Real", "Integer")
            if numeric and field.name not in units:
                raise ValueError(
                    f"{data.__name__}.{field.name} must state its unit: make it with `quantity(default, unit)`"
                )
            unit = fmi_unit(units[field.name]) if numeric else "1"
            yield Parameter(f"{prefix}{field.name}", unit, kinds[0])


def with_values(data: Any, values: Mapping[str, object]) -> Any:
    """A copy with the given values by dotted name, checked as a whole; a part that was None starts from defaults."""
    direct: dict[str, object] = {}
    parts: dict[str, dict[str, object]] = {}
    for name, value in values.items():
        head, _, rest = name.partition(".")
        if rest:
            parts.setdefault(head, {})[rest] = value
        else:
            direct[head] = value
    for head, inside in parts.items():
        part = getattr(data, head)
        if part is None:
            kind = _inner(get_type_hints(type(data))[head])
            assert kind is not None  # the catalogue has let the name pass
            part = kind()
        direct[head] = with_values(part, inside)
    return replace(data, **direct)


def _inner(hint: Any) -> type[Any] | None:
    """The data class that a hint names, alone or beside None."""
    return next((t for t in (hint, *get_args(hint)) if isinstance(t, type) and is_dataclass(t)), None)
