"""macOS libraries (Mach-O): universal binaries, and the code signature of a changed library.

The linker signs libraries for aarch64 "ad hoc": no certificate, but a code directory with the SHA-256 hash of every
page of the file.  macOS ends a process that loads a page with another hash.

    hash[i] = SHA-256(page i of the file, up to the code limit) ,  i = 0 ... slots - 1
"""

import hashlib
import struct
from collections.abc import Sequence

_UNIVERSAL, _LIBRARY = 0xCAFEBABE, 0xFEEDFACF
_CODE_SIGNATURE, _SIGNATURE, _CODE_DIRECTORY, _SHA256 = 0x1D, 0xFADE0CC0, 0xFADE0C02, 2
_PAGE = 1 << 14


def universal(libraries: Sequence[bytes]) -> bytes:
    """Return one library for several processors (fat Mach-O: a table of offsets, then the libraries)."""
    table, body, offset = struct.pack(">II", _UNIVERSAL, len(libraries)), b"", _PAGE
    for code in libraries:
        cpu, subtype = struct.unpack_from("<II", code, 4)
        table += struct.pack(">IIIII", cpu, subtype, offset, len(code), 14)
        padded = code + bytes(-len(code) % _PAGE)
        body, offset = body + padded, offset + len(padded)
    return table.ljust(_PAGE, b"\0") + body


def parts(library: bytes) -> list[tuple[int, int]]:
    """Return begin and end of each processor's part of a universal library; of the whole of any other."""
    magic, number = struct.unpack_from(">II", library)
    if magic != _UNIVERSAL:
        return [(0, len(library))]
    extents = (struct.unpack_from(">II", library, 8 + 20 * i + 8) for i in range(number))
    return [(offset, offset + size) for offset, size in extents]


def with_page_hashes(library: bytes) -> bytes:
    """Return the library with the present hashes of its pages; unchanged if it is not signed, or no Mach-O.

    Raises RuntimeError for a code directory of a kind that our linkers do not write.
    """
    at = _code_directory(library)
    if at is None:
        return library
    hashes, _, _, slots, limit = struct.unpack_from(">5I", library, at + 16)
    size, kind, _, power = struct.unpack_from("4B", library, at + 36)
    if (size, kind) != (32, _SHA256):
        raise RuntimeError(
            f"the library is signed with hashes of kind {kind}, {size} bytes, not with SHA-256"
        )
    out, page = bytearray(library), 1 << power
    for i in range(slots):
        digest = hashlib.sha256(library[i * page : min((i + 1) * page, limit)]).digest()
        out[at + hashes + 32 * i : at + hashes + 32 * (i + 1)] = digest
    return bytes(out)


def _code_directory(library: bytes) -> int | None:
    """Return the offset of the code directory in the file; None without one."""
    if len(library) < 32 or struct.unpack_from("<I", library)[0] != _LIBRARY:
        return None
    position = 32
    for _ in range(struct.unpack_from("<I", library, 16)[0]):
        command, size, offset = struct.unpack_from("<3I", library, position)
        if command == _CODE_SIGNATURE:
            return _directory_in(library, offset)
        position += size
    return None


def _directory_in(library: bytes, signature: int) -> int:
    magic, _, number = struct.unpack_from(">3I", library, signature)
    offsets: list[int] = [
        struct.unpack_from(">2I", library, signature + 12 + 8 * i)[1] for i in range(number)
    ]
    blobs = [signature + offset for offset in offsets]
    directories = [
        at for at in blobs if struct.unpack_from(">I", library, at)[0] == _CODE_DIRECTORY
    ]
    if magic != _SIGNATURE or len(directories) != 1:
        raise RuntimeError(
            f"the library's signature has {len(directories)} code directories, not one"
        )
    return directories[0]
