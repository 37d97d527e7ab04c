"""Compiler driver: C sources to object files and libraries, each compiled once on a machine.

Libraries and object files are cached on disk under the hash of their sources, the compiler and its
flags, so that only a change of these compiles anew.
"""

import getpass
import hashlib
import importlib.util
import logging
import os
import re
import shlex
import shutil
import stat
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import cache, lru_cache
from pathlib import Path

from rope_model.files import whole_file, write_error

log = logging.getLogger(__name__)
#: logger of long waits, at the level WARNING, which Python shows on stderr by default
progress = logging.getLogger("balance_rope.progress")

FLAGS = ("-std=c99", "-O3", "-fPIC", "-shared", "-ffp-contract=off", "-fno-math-errno")
#: not the names of functions that contain "error"
_AN_ERROR = re.compile(r"\berror:|undefined reference")
_ANNOUNCED = "compiling %s with %s, once on this machine: up to a minute"
#: names that a C file includes, kept as it takes milliseconds in the longest, which fifty others
#: include
_names_included = lru_cache(maxsize=256)(
    re.compile(r'^[ \t]*#[ \t]*include[ \t]+"([^"]+)"', re.MULTILINE).findall
)
LIBRARY_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


def last_words(error: Exception) -> str:
    """Return the error's text with the first error, or else the last line, of the compiler's or the linker's output."""
    if isinstance(error, subprocess.CalledProcessError):
        output = str(error.stderr).strip().splitlines()
    else:
        output = []
    first = next((line for line in output if _AN_ERROR.search(line)), output[-1] if output else "")
    return f"{error} {first}".rstrip()


def find_compiler() -> tuple[str, ...] | None:
    """Return the command of a C compiler: that of CC, the system's, or the ziglang package's; None without one."""
    for command in (shlex.split(os.environ.get("CC", "")), ["cc"], ["gcc"], ["clang"]):
        if command and (path := shutil.which(command[0])):
            return (path, *command[1:])
    if importlib.util.find_spec("ziglang") is not None:
        return (sys.executable, "-m", "ziglang", "cc")
    return None


def cache_folder() -> Path:
    """Return the folder for compiled code: BALANCE_ROPE_CACHE, or balance-rope in the user's cache folder.

    Where that cannot be written it is a folder of the user's own in the temporary one.
    """
    if chosen := os.environ.get("BALANCE_ROPE_CACHE"):
        return Path(chosen)
    base = os.environ.get("LOCALAPPDATA") or os.environ.get("XDG_CACHE_HOME")
    try:
        usual = Path(base or Path.home() / ".cache") / "balance-rope"
    except RuntimeError:  # no home directory
        return _temporary_cache(Path(tempfile.gettempdir()))
    return _writable_cache(usual, Path(tempfile.gettempdir()))


@cache
def _writable_cache(usual: Path, temporary: Path) -> Path:
    """Return the usual folder, or that in the temporary one if nothing can be written there."""
    try:
        usual.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=usual):
            return usual
    except OSError as error:
        other = _temporary_cache(temporary)
        log.warning(
            "%s cannot be written (%s): compiled code is kept in %s; name another folder in BALANCE_ROPE_CACHE",
            usual,
            error.strerror,
            other,
        )
        return other


@cache
def _temporary_cache(temporary: Path) -> Path:
    """Return a folder that this user alone can write: libraries are loaded from it."""
    user = os.getuid() if sys.platform != "win32" else getpass.getuser()
    folder = temporary / f"balance-rope-{user}"
    with suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    if sys.platform == "win32":
        return folder
    seen = folder.lstat()
    if stat.S_ISDIR(seen.st_mode) and seen.st_uid == user and not seen.st_mode & 0o022:
        return folder
    # somebody else has taken the name
    return Path(tempfile.mkdtemp(prefix="balance-rope-", dir=temporary))


def compile_library(
    sources: Mapping[str, str],
    compiler: Sequence[str],
    folder: Path,
    name: str,
) -> Path:
    """Compile the C files among ``sources`` (text by file name) into a library in ``folder``, once; return its path."""
    command = [*compiler, *FLAGS]
    objects = object_files(sources, compiler, FLAGS, folder)
    files = [*objects.values()]
    library = (
        folder / f"{name}-{short_hash(*command, *(file.name for file in files))}{LIBRARY_SUFFIX}"
    )

    def link() -> None:
        # announce long waits only; Python runs ziglang
        if sum(map(len, sources.values())) > 10_000:
            progress.warning(
                _ANNOUNCED, name, "ziglang" if "ziglang" in command else Path(command[0]).name
            )
        compile_objects(sources, command, objects)
        link_library(command, files, library, library.name)

    return make_once(library, link)


def link_library(
    command: Sequence[str],
    objects: Iterable[Path],
    library: Path,
    name: str,
    more: Sequence[str] = (),
) -> None:
    """Link the ``objects`` and ``more`` into the file ``library``, whose own ``name`` may differ."""
    with tempfile.TemporaryDirectory(dir=library.parent) as folder:
        # relative names in a scratch folder keep paths of this machine out of the library
        files = [os.path.relpath(file, folder) for file in objects]
        _run([*command, *files, "-o", name, "-lm", *more], Path(folder))
        with whole_file(library) as draft:
            (Path(folder) / name).replace(draft)


def make_once(file: Path, make: Callable[[], None]) -> Path:
    """Call ``make`` unless the ``file`` that it writes exists, and return the file.

    Other processes that need the file wait meanwhile.  If the process that makes it dies, the next
    one makes it.
    """
    if file.exists():
        return file
    lock = file.with_name(f"{file.name}.lock")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        handle = lock.open("w")
    except OSError as error:
        raise write_error(file, error) from error
    with handle:
        if sys.platform != "win32":
            import fcntl

            with suppress(OSError):  # not every file system of a network can
                fcntl.flock(handle, fcntl.LOCK_EX)
        if not file.exists():
            make()
    with suppress(OSError):  # Windows deletes no file that another process has open
        lock.unlink()
    return file


def object_files(
    sources: Mapping[str, str], compiler: Sequence[str], flags: Sequence[str], folder: Path
) -> dict[str, Path]:
    """Return the paths of the object files, which ``compile_objects`` makes, of the C files among ``sources``.

    The hash of a file, its includes, the compiler and its flags is in the name: libraries share
    common files.
    """
    # the path of Python does not count: the same ziglang compiles the same elsewhere
    made_by = (
        compiler_version(tuple(compiler)),
        *compiler[compiler[0] == sys.executable :],
        *flags,
    )
    digests = {file: short_hash(file, text) for file, text in sources.items()}
    return {
        file: folder
        / f"{Path(file).stem}-{short_hash(*made_by, *(digests[f] for f in _included(file, sources)))}.o"
        for file in sorted(sources)
        if file.endswith(".c")
    }


def compile_objects(
    sources: Mapping[str, str], command: Sequence[str], objects: Mapping[str, Path]
) -> None:
    """Make the missing ``object_files``, as many at a time as the machine has cores."""
    # longest files first, includes counted
    missing = sorted(
        (file for file, path in objects.items() if not path.exists()),
        key=lambda file: -sum(len(sources[part]) for part in _included(file, sources)),
    )
    if not missing:
        return
    folder = objects[missing[0]].parent
    with (
        tempfile.TemporaryDirectory(dir=folder) as scratch,
        ThreadPoolExecutor(os.cpu_count()) as threads,
    ):
        for file, code in sources.items():
            (Path(scratch) / file).write_text(code, encoding="utf-8", newline="\n")

        def compile_one(file: str) -> None:
            # relative names in the folder keep paths of this machine out of the code
            new = Path(scratch) / objects[file].name
            _run([*command, "-c", file, "-o", new.name], Path(scratch))
            with whole_file(objects[file]) as draft:  # several processes may build it at once
                new.replace(draft)

        list(threads.map(compile_one, missing))


def _included(file: str, sources: Mapping[str, str]) -> list[str]:
    """Return the file and those of the ``sources`` that it includes, each once."""
    included = [file]
    for part in included:
        included += (
            name
            for name in _names_included(sources[part])
            if name in sources and name not in included
        )
    return list(dict.fromkeys(included))


def _run(command: Sequence[str], folder: Path) -> None:
    """Run the command; CalledProcessError, with its output as a note, if it fails."""
    try:
        subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    except subprocess.CalledProcessError as error:
        error.add_note(error.stderr)
        raise


def short_hash(*parts: str) -> str:
    """Return the hash in a file's name of the texts that the file is made of."""
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:20]


@cache
def compiler_version(compiler: tuple[str, ...]) -> str:
    """Return the first line of the compiler's answer to ``--version``."""
    output = subprocess.run(
        [*compiler, "--version"], capture_output=True, text=True, check=False
    ).stdout
    return output.partition("\n")[0]
