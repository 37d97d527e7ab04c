"""Start values of an export, as ``start.c`` of the sources and written into finished libraries.

Token, start values and the choice of arrays are one block of the library, behind MAGIC.  It is read
at run time (volatile), so it can be written after the compiler is done: one library per platform
and version of FMI serves every export.  Its bytes are those of one compiled from the export's own
sources, except for the linker's mark (the time stamp of Windows' libraries, macOS's UUID).
"""

import struct
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from fmu_src.shell.build import binaries
from fmu_src.shell.mach_o import parts, with_page_hashes
from rope_model.texts import c_string

MAGIC = b"FMU start values"
TOKEN_ROOM = 64
_HEAD = struct.Struct(f"<16s{TOKEN_ROOM}sii")

_TEXT = """\
/* Generated: what this export has and another has not. */
#include <stdbool.h>

#include "model.h"

struct ModelStart {{
    char magic[16], token[TOKEN_BYTES];
    int scalars, arrays;
    double values[{scalars}];
}};

/* an exporter writes into the finished library, and finds the place by the magic */
extern const struct ModelStart MODEL_START;
const struct ModelStart MODEL_START = {{
    "{magic}",
    {token},
    {scalars},
    {arrays:d},
    {{
{values}
    }},
}};

/* so that no compiler takes the values above for those at run time */
static const volatile struct ModelStart *const START = &MODEL_START;

void model_token(char token[TOKEN_BYTES]) {{
    int i;
    for (i = 0; i < TOKEN_BYTES; i++) token[i] = START->token[i];
    token[TOKEN_BYTES - 1] = '\\0';
}}

double model_start(size_t scalar) {{ return START->values[scalar]; }}

bool model_has_arrays(void) {{ return START->arrays; }}
"""


class Start(NamedTuple):
    """Data of an export in its library."""

    token: str  # GUID, or instantiation token of FMI 3.0
    values: tuple[float, ...]  # start value of every scalar
    arrays: bool = True  # whether an array is one variable

    def block(self) -> bytes:
        """Return the values as a block of a library."""
        token = self.token.encode()
        if len(token) >= TOKEN_ROOM:
            raise ValueError(
                f"the token {self.token} has {len(token)} bytes: "
                f"it must have less than {TOKEN_ROOM}"
            )
        head = _HEAD.pack(MAGIC, token, len(self.values), self.arrays)
        return head + struct.pack(f"<{len(self.values)}d", *self.values)


def c_start(start: Start) -> str:
    """Return the text of start.c."""
    values = "\n".join(f"        {value!r}," for value in start.values)
    return _TEXT.format(
        magic=MAGIC.decode(),
        token=c_string(start.token),
        scalars=len(start.values),
        arrays=start.arrays,
        values=values,
    )


def without_start(sources: Mapping[str, str], scalars: int) -> dict[str, str]:
    """Return the C files of all exports of a model: ``sources``, and a start.c of zeros."""
    return {**sources, "start.c": c_start(Start("", (0.0,) * scalars))}


def binaries_with(
    start: Start,
    sources: Mapping[str, str],
    name: str,
    fmi: int,
    platforms: Sequence[str],
    identifier: str = "",
) -> dict[str, bytes]:
    """Return libraries with ``start`` by path in the FMU, made of ``sources`` and start.c.

    ``name`` is that of the library, ``identifier`` that of the FMU, where it differs.
    """
    libraries = binaries(
        without_start(sources, len(start.values)), name, fmi, platforms, identifier or name
    )
    return {path: with_start(library, start) for path, library in libraries.items()}


def with_start(library: bytes, start: Start) -> bytes:
    """Return the library with the data of ``start``; those of macOS are signed again.

    Raises RuntimeError if the library has no block for them, or one for another number of scalars.
    """
    out = bytearray(library)
    for begin, end in parts(library):
        offset = library.find(MAGIC, begin, end)
        if offset < 0 or library.find(MAGIC, offset + 1, end) >= 0:
            raise RuntimeError(
                f"the library has no one place for start values ({MAGIC!r}); "
                "delete it and export anew"
            )
        scalars = _HEAD.unpack_from(library, offset)[2]
        if scalars != len(start.values):
            raise RuntimeError(
                f"the library takes {scalars} start values, not {len(start.values)}; "
                "delete it and export anew"
            )
        block = start.block()
        out[offset : offset + len(block)] = block
        out[begin:end] = with_page_hashes(bytes(out[begin:end]))
    return bytes(out)
