"""Files that appear complete under their names, or not at all: written beside them, synced and renamed."""

import errno
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_DENIED = (errno.EACCES, errno.EPERM, errno.EROFS)


class WriteError(OSError):
    """A file that cannot be written; the text names it and the cure."""


def write_error(path: Path, error: OSError) -> WriteError:
    """Return the error of a file with its name, the system's reason and the cure."""
    cure = "check its folder, or choose another"
    if error.errno in _FULL:
        cure = "make room there, or choose another folder"
    elif error.errno in _DENIED:
        cure = "allow writing there, or choose another folder"
    return WriteError(f"{path} cannot be written ({error.strerror or error}): {cure}")


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield the path of a draft, with the suffix of ``path``, which then replaces ``path`` at once.

    Whatever goes wrong, ``path`` stays as it was, and no draft is left; two processes may write one
    file. Raises WriteError for every OSError.
    """
    draft = path.with_name(f".{path.stem}.{os.getpid()}-{secrets.token_hex(4)}{path.suffix}")
    try:
        yield draft
        with draft.open("rb+") as file:
            os.fsync(file.fileno())
        draft.replace(path)
    except WriteError:
        raise
    except OSError as error:
        raise write_error(path, error) from error
    finally:
        with suppress(OSError):  # no folder, no draft
            draft.unlink(missing_ok=True)


def write_text(path: Path, text: str, errors: str = "strict") -> Path:
    """Write a text as UTF-8 with plain line ends, the same bytes on every system, and return the path."""
    return write_bytes(path, text.encode("utf-8", errors))


def write_bytes(path: Path, content: bytes) -> Path:
    """Write a file and return its path."""
    with whole_file(path) as draft:
        draft.write_bytes(content)
    return path
