"""macOS libraries (Mach-O): universal binaries, and the code signature of a changed library.

The linker signs libraries for aarch64 "ad hoc": no certificate, but a code directory with the
SHA-256 hash of every page of the file.  macOS ends a process that loads a page with another hash.

    hash[i] = SHA-256(page i of the file, up to the code limit) ,  i = 0 ... slots - 1
"""

import hashlib
import struct
from collections.abc import Sequence

#: Magic numbers of files: universal binaries, and libraries.
_UNIVERSAL = 0xCAFEBABE
_LIBRARY = 0xFEEDFACF
_CODE_SIGNATURE = 0x1D  #: Load command of a signature.
#: Magic numbers of a signature and of the code directory in it.
_SIGNATURE = 0xFADE0CC0
_CODE_DIRECTORY = 0xFADE0C02
_SHA256 = 2  #: Kind of a hash.
_HASH_BYTES = 32
_PAGE_BITS = 14
_PAGE = 1 << _PAGE_BITS
_HEADER_BYTES = 32  #: Length of a library's header.


def universal(libraries: Sequence[bytes]) -> bytes:
    """Return one library for several processors: a table of offsets, then the libraries."""
    table = struct.pack(">II", _UNIVERSAL, len(libraries))
    body = b""
    for code in libraries:
        cpu, subtype = struct.unpack_from("<II", code, 4)
        offset = _PAGE + len(body)
        table += struct.pack(">IIIII", cpu, subtype, offset, len(code), _PAGE_BITS)
        body += code + bytes(-len(code) % _PAGE)
    return table.ljust(_PAGE, b"\0") + body


def parts(library: bytes) -> list[tuple[int, int]]:
    """Return begin and end of the part of each processor in a library."""
    magic, number = struct.unpack_from(">II", library)
    if magic != _UNIVERSAL:
        return [(0, len(library))]
    extents = (struct.unpack_from(">II", library, 8 + 20 * i + 8) for i in range(number))
    return [(offset, offset + size) for offset, size in extents]


def with_page_hashes(library: bytes) -> bytes:
    """Return the library with the present hashes of its pages.

    A library that is not signed, or no Mach-O, is unchanged. Raises RuntimeError for a code
    directory of a kind that our linkers do not write.
    """
    at = _code_directory(library)
    if at is None:
        return library
    hashes, _, _, slots, limit = struct.unpack_from(">5I", library, at + 16)
    size, kind, _, power = struct.unpack_from("4B", library, at + 36)
    if (size, kind) != (_HASH_BYTES, _SHA256):
        raise RuntimeError(
            f"the library is signed with hashes of kind {kind}, {size} bytes, not with SHA-256"
        )
    out = bytearray(library)
    page = 1 << power
    for i in range(slots):
        digest = hashlib.sha256(library[i * page : min((i + 1) * page, limit)]).digest()
        begin = at + hashes + _HASH_BYTES * i
        out[begin : begin + _HASH_BYTES] = digest
    return bytes(out)


def _code_directory(library: bytes) -> int | None:
    """Return the offset of the code directory in the file; None without one."""
    if len(library) < _HEADER_BYTES or struct.unpack_from("<I", library)[0] != _LIBRARY:
        return None
    position = _HEADER_BYTES
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
