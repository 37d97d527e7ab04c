"""Compiler driver and loader of CasADi functions: compiled where there is a C compiler, else interpreted.

The CasADi virtual machine is the reference and always works.  The compiled library is generated from the very same
functions.  It is cached on disk under the hash of the generated C, the compiler and its flags, so that only a change of
these compiles anew.
"""

import getpass
import hashlib
import importlib.util
import logging
import os
import platform
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
from typing import Any, Literal

import casadi as ca
import numpy as np

from rope_model.arrays import Array
from rope_model.files import whole_file, write_error

KernelForm = Literal["auto", "compiled", "portable"]
#: function that builds a library with a compiler's command, or finds it in the cache
Build = Callable[[Sequence[str]], Path]

log = logging.getLogger(__name__)
#: logger of long waits, at the level WARNING, which Python shows on stderr by default
progress = logging.getLogger("balance_rope.progress")

FLAGS = ("-std=c99", "-O3", "-fPIC", "-shared", "-ffp-contract=off", "-fno-math-errno")
#: not the names of functions that contain "error"
_AN_ERROR = re.compile(r"\berror:|undefined reference")
_ANNOUNCED = "compiling %s with %s, once on this machine: up to a minute"
#: names that a C file includes, kept as it takes milliseconds in the longest, which fifty others include
_names_included = lru_cache(maxsize=256)(
    re.compile(r'^[ \t]*#[ \t]*include[ \t]+"([^"]+)"', re.MULTILINE).findall
)
LIBRARY_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


class Kernel:
    """One CasADi function called on numpy arrays without copying through CasADi's own matrices.

    Arrays are C-ordered with one row per CasADi column: shape (nodes, 7) for a (7, nodes) argument.  The returned
    arrays belong to the caller.  Not to be shared between threads.

    ``inputs`` and ``outputs`` are the arrays that ``evaluate`` reads and writes.
    """

    def __init__(self, function: ca.Function, shapes: Sequence[tuple[int, ...]]) -> None:
        self.function = function
        buffer: Any
        buffer, self.evaluate = (
            function.buffer()
        )  # the stubs of casadi do not know the buffer's methods
        self._buffer = buffer
        self.inputs = [np.zeros(function.numel_in(i)) for i in range(function.n_in())]
        self.outputs = [np.zeros(function.numel_out(i)) for i in range(function.n_out())]
        for i, x in enumerate(self.inputs):
            buffer.set_arg(i, x.data)
        for i, x in enumerate(self.outputs):
            buffer.set_res(i, x.data)
        self._taken: list[
            Array
        ] = []  # views of the inputs in the shapes of the arguments, which never change
        self._returned = [x.reshape(shape) for x, shape in zip(self.outputs, shapes, strict=True)]

    def __call__(self, *arguments: Array | float) -> list[Array]:
        if not self._taken:
            self._taken = [
                x.reshape(np.shape(argument))
                for x, argument in zip(self.inputs, arguments, strict=True)
            ]
        for destination, source in zip(self._taken, arguments, strict=True):
            destination[...] = source
        self.evaluate()
        return [x.copy() for x in self._returned]


def prepare(
    functions: Sequence[ca.Function],
    build: Build,
    form: KernelForm = "auto",
    bundle: Path | None = None,
) -> tuple[list[ca.Function], str]:
    """Return the functions in the wanted form, and the form obtained: ``compiled`` or ``portable``.

    ``build`` makes their library with a compiler.  ``bundle`` is a finished library that is tried first.

    Raises RuntimeError if ``compiled`` is required and not available.
    """
    if form == "portable":
        log.info("kernels: portable (CasADi virtual machine), as asked for")
        return list(functions), "portable"
    if bundle is not None and bundle.exists():
        try:
            compiled = load_compiled(functions, bundle)
            log.info("kernels: compiled, %s", bundle)
            return compiled, "compiled"
        except RuntimeError as error:
            log.warning("kernels: the library %s does not load here (%s)", bundle, error)
    cause = "no C compiler found (tried CC, cc, gcc, clang and the ziglang package)"
    if (compiler := find_compiler()) is not None:
        try:
            library = build(compiler)
            compiled = load_compiled(functions, library)
            log.info("kernels: compiled, %s", library)
            return compiled, "compiled"
        except (OSError, subprocess.CalledProcessError, RuntimeError) as error:
            cause = f"{' '.join(compiler)} failed: {last_words(error)}"
    if form == "compiled":
        raise RuntimeError(
            f"compiled kernels asked for, but {cause}; install a C compiler or use kernels='portable'"
        )
    # expected without a compiler, unless a bundle was to spare it; a compiler that fails is not expected
    level = logging.INFO if compiler is None and bundle is None else logging.WARNING
    log.log(
        level,
        "kernels: portable (CasADi virtual machine, 5 to 10 times as long), because %s",
        cause,
    )
    return list(functions), "portable"


def last_words(error: Exception) -> str:
    """Return the error's text with the first error, or else the last line, of the compiler's or the linker's output."""
    output = (
        str(error.stderr).strip().splitlines()
        if isinstance(error, subprocess.CalledProcessError)
        else []
    )
    first = next((line for line in output if _AN_ERROR.search(line)), output[-1] if output else "")
    return f"{error} {first}".rstrip()


def find_compiler() -> tuple[str, ...] | None:
    """Return the command of a C compiler: that of CC, the system's, or the ziglang package's; None without one."""
    for command in (shlex.split(os.environ.get("CC", "")), ["cc"], ["gcc"], ["clang"]):
        if command and (path := shutil.which(command[0])):
            return (path, *command[1:])
    return (
        (sys.executable, "-m", "ziglang", "cc")
        if importlib.util.find_spec("ziglang") is not None
        else None
    )


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
    return Path(
        tempfile.mkdtemp(prefix="balance-rope-", dir=temporary)
    )  # somebody else has taken the name


def build_library(
    functions: Sequence[ca.Function],
    compiler: Sequence[str],
    folder: Path,
    name: str = "kernels",
    objects: Sequence[Path] = (),
) -> Path:
    """Generate C, compile it into ``folder`` unless it is there already, and return the library's path.

    ``objects`` contain functions that these call.
    """
    return compile_library(
        {"kernels.c": generate_c(tuple(functions))}, compiler, folder, name, objects
    )


def build_parts(
    functions: Sequence[ca.Function], compiler: Sequence[str], folder: Path, name: str
) -> tuple[Path, Path]:
    """Compile functions once for all that call them; return library to load, and object file to link callers with."""
    sources = {f"{name}.c": generate_c(tuple(functions), "parts")}
    library, objects = (
        compile_library(sources, compiler, folder, name),
        object_files(sources, compiler, FLAGS, folder),
    )
    return library, objects[f"{name}.c"]


def compile_library(
    sources: Mapping[str, str],
    compiler: Sequence[str],
    folder: Path,
    name: str,
    linked: Sequence[Path] = (),
) -> Path:
    """Compile the C files among ``sources`` (text by file name) into a library in ``folder``, once; return its path.

    ``linked`` are finished object files for the library.
    """
    command = [*compiler, *FLAGS]
    objects = object_files(sources, compiler, FLAGS, folder)
    files = [*objects.values(), *linked]
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

    Other processes that need the file wait meanwhile.  If the process that makes it dies, the next one makes it.
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

    The hash of a file, its includes, the compiler and its flags is in the name: libraries share common files.
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


@lru_cache(maxsize=32)  # each takes about 0.5 MB
def generate_c(functions: tuple[ca.Function, ...], prefix: str = "kernels") -> str:
    """Return one C source of the functions, with ``prefix`` before the names of their shared parts."""
    generator = ca.CodeGenerator(prefix, {"with_header": False})
    for function in functions:
        generator.add(function)
    return str(generator.dump())


def save_portable(functions: Sequence[ca.Function], path: Path) -> None:
    """Write the functions to a file for ``load_portable``, which then needs nothing that built them."""
    serializer = ca.FileSerializer(str(path))
    serializer.pack(len(functions))
    for function in functions:
        serializer.pack(function)


def load_portable(path: Path) -> list[ca.Function]:
    """Load the functions from a file written by ``save_portable``; none if this CasADi cannot read it."""
    try:
        file = ca.FileDeserializer(str(path))
        return [file.unpack() for _ in range(file.unpack())]
    except RuntimeError as error:  # an older CasADi refuses the file of a newer one
        cause = str(error).strip().splitlines()[-1]
        log.warning(
            "kernels: CasADi %s cannot read %s, they are built anew (%s)",
            ca.CasadiMeta.version(),
            path,
            cause,
        )
        return []


def platform_tag() -> str:
    """Return operating system and processor, as in ``linux-x86_64``."""
    return f"{sys.platform}-{platform.machine().lower()}"


def load_compiled(functions: Sequence[ca.Function], library: Path) -> list[ca.Function]:
    """Load the functions from ``library``; RuntimeError if it lacks one, or has one of another size."""
    loaded = [ca.external(function.name(), str(library)) for function in functions]
    for ours, theirs in zip(functions, loaded, strict=True):
        if _sizes(ours) != _sizes(theirs):
            raise RuntimeError(f"{library} holds kernels of another mesh size")
    return loaded


def _sizes(f: ca.Function) -> list[tuple[int, int]]:
    return [f.size_in(i) for i in range(f.n_in())] + [f.size_out(i) for i in range(f.n_out())]
