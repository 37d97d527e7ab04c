"""Structures that Python and trip.c share: ctypes and the text in C follow from one list of members."""

from collections.abc import Sequence
from ctypes import Structure, c_double, c_int, c_size_t, c_void_p
from inspect import cleandoc
from typing import Any, ClassVar, NamedTuple

_NUMBERS: dict[str, Any] = {"double": c_double, "int": c_int, "size_t": c_size_t}
#: types of trip.c that are as large as an address
_ADDRESSES = ("Function",)


class CMember(NamedTuple):
    """Member of a structure: a number, another structure, or a pointer, which ends with a star."""

    name: str
    type_in_c: str
    comment: str = ""
    length: int = 0  # of an array, or 0


class SharedStructure(Structure):
    """Structure with the members that its class lists."""

    members: ClassVar[Sequence[CMember]] = ()


def fields_of(
    members: Sequence[CMember], structures: Sequence[type[SharedStructure]] = ()
) -> list[tuple[str, Any]]:
    """Return the fields for ctypes; ``structures`` are those of members."""
    by_name = _NUMBERS | {kind.__name__: kind for kind in structures}
    fields = []
    for member in members:
        is_address = member.type_in_c.endswith("*") or member.type_in_c in _ADDRESSES
        kind = c_void_p if is_address else by_name[member.type_in_c]
        fields.append((member.name, kind * member.length if member.length else kind))
    return fields


def definition(kind: type[SharedStructure]) -> str:
    """Return the definition of a structure in C."""
    return (
        f"/* {cleandoc(kind.__doc__ or '')} */\n"
        f"typedef struct {{\n{''.join(map(_declaration, kind.members))}}} {kind.__name__};\n"
    )


def _declaration(member: CMember) -> str:
    space = "" if member.type_in_c.endswith("*") else " "
    array = f"[{member.length}]" if member.length else ""
    comment = f" /* {member.comment} */" if member.comment else ""
    return f"    {member.type_in_c}{space}{member.name}{array};{comment}\n"
