"""CasADi functions made fast and portable: compiled where a C compiler is there, interpreted where it is not.

The CasADi virtual machine is the reference and always works.  The compiled library is generated from the very same
functions; it is cached on disk under the hash of the generated C, the compiler and its flags, so that only a change of
these compiles anew.
"""

import hashlib
import importlib.util
import logging
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
KernelForm = Literal["auto", "compiled", "portable"]
#: from a compiler's command to a library, made or found
Build = Callable[[Sequence[str]], Path]

log = logging.getLogger(__name__)
#: long waits of a host: at the level WARNING, which Python shows on stderr by default
progress = logging.getLogger("balance_rope.progress")

FLAGS = ("-std=c99", "-O3", "-fPIC", "-shared", "-ffp-contract=off", "-fno-math-errno")
#: Not the names of functions that have "error" in them.
_AN_ERROR = re.compile(r"\berror:|undefined reference")
_ANNOUNCED = "compiling %s with %s, once on this machine: up to a minute"
_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+"([^"]+)"', re.MULTILINE)
LIBRARY_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


class Kernel:
    """One CasADi function called on numpy arrays without copying through CasADi's own matrices.

    Arrays are C-ordered with one row per CasADi column: shape (nodes, 7) for a (7, nodes) argument.  The returned
    arrays belong to the caller.  Not to be shared between threads.

    ``inputs`` and ``outputs`` are the arrays that the function itself reads and writes when it is ``evaluate``d.
    """

    def __init__(self, function: ca.Function, shapes: Sequence[tuple[int, ...]]) -> None:
        self.function = function
        buffer: Any
        buffer, self.evaluate = function.buffer()  # the stubs of casadi do not know the buffer's methods
        self._buffer = buffer
        self.inputs = [np.zeros(function.numel_in(i)) for i in range(function.n_in())]
        self.outputs = [np.zeros(function.numel_out(i)) for i in range(function.n_out())]
        for i, x in enumerate(self.inputs):
            buffer.set_arg(i, x.data)
        for i, x in enumerate(self.outputs):
            buffer.set_res(i, x.data)
        self._taken: list[Array] = []  # views of the inputs in the shapes of the arguments, which never change
        self._returned = [x.reshape(shape) for x, shape in zip(self.outputs, shapes, strict=True)]

    def __call__(self, *arguments: Array | float) -> list[Array]:
        if not self._taken:
            self._taken = [x.reshape(np.shape(argument)) for x, argument in zip(self.inputs, arguments, strict=True)]
        for destination, source in zip(self._taken, arguments, strict=True):
            destination[...] = source
        self.evaluate()
        return [x.copy() for x in self._returned]


def prepare(
    functions: Sequence[ca.Function], build: Build, form: KernelForm = "auto", bundle: Path | None = None
) -> tuple[list[ca.Function], str]:
    """Return the functions in the wanted form, and the form that could be had: ``compiled`` or ``portable``.

    ``build`` makes their library with a compiler. ``bundle`` is a finished library that is tried first.

    Raises RuntimeError where ``compiled`` is asked for and cannot be had.
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
        raise RuntimeError(f"compiled kernels asked for, but {cause}; install a C compiler or use kernels='portable'")
    # without a compiler that is as expected, but not where a library was to be; nor is one that fails
    level = logging.INFO if compiler is None and bundle is None else logging.WARNING
    log.log(level, "kernels: portable (CasADi virtual machine, 5 to 10 times as long), because %s", cause)
    return list(functions), "portable"


def last_words(error: Exception) -> str:
    """Return the error's text, with the first error that the compiler or the linker names, or their last line."""
    output = str(error.stderr).strip().splitlines() if isinstance(error, subprocess.CalledProcessError) else []
    first = next((line for line in output if _AN_ERROR.search(line)), output[-1] if output else "")
    return f"{error} {first}".rstrip()


def find_compiler() -> tuple[str, ...] | None:
    """The command of a C compiler: the CC variable's, the system's, or the ziglang package's; None without one."""
    for command in (shlex.split(os.environ.get("CC", "")), ["cc"], ["gcc"], ["clang"]):
        if command and (path := shutil.which(command[0])):
            return (path, *command[1:])
    if importlib.util.find_spec("ziglang") is not None:
        return (sys.executable, "-m", "ziglang", "cc")
    return None


def cache_folder() -> Path:
    """Folder for compiled kernels: BALANCE_ROPE_CACHE, or balance-rope in the user's cache folder."""
    if chosen := os.environ.get("BALANCE_ROPE_CACHE"):
        return Path(chosen)
    base = os.environ.get("LOCALAPPDATA") or os.environ.get("XDG_CACHE_HOME")
    try:
        return Path(base or Path.home() / ".cache") / "balance-rope"
    except RuntimeError:  # no home directory
        return Path(tempfile.gettempdir()) / "balance-rope"


class CompiledParts(NamedTuple):
    """Functions that others call: the library to load them from, and the object file to link those others with."""

    library: Path
    linked: Path


def build_library(
    functions: Sequence[ca.Function],
    compiler: Sequence[str],
    folder: Path,
    name: str = "kernels",
    objects: Sequence[Path] = (),
) -> Path:
    """Generate C, compile it into ``folder`` unless it is there already, and return the library's path.

    ``objects`` hold functions that these call.
    """
    return compile_library({"kernels.c": generate_c(tuple(functions))}, compiler, folder, name, objects)


def build_parts(functions: Sequence[ca.Function], compiler: Sequence[str], folder: Path, name: str) -> CompiledParts:
    """The functions, compiled once for all that call them."""
    sources = {f"{name}.c": generate_c(tuple(functions), "parts")}
    library, objects = compile_library(sources, compiler, folder, name), object_files(sources, compiler, FLAGS, folder)
    return CompiledParts(library, objects[f"{name}.c"])


def compile_library(
    sources: Mapping[str, str], compiler: Sequence[str], folder: Path, name: str, linked: Sequence[Path] = ()
) -> Path:
    """Return the library of the C files among ``sources`` (text by file name), compiled into ``folder`` once.

    ``linked`` are finished object files of it.
    """
    command = [*compiler, *FLAGS]
    objects = object_files(sources, compiler, FLAGS, folder)
    files = [*objects.values(), *linked]
    library = folder / f"{name}-{_key(*command, *(file.name for file in files))}{LIBRARY_SUFFIX}"

    def link() -> None:
        # python runs ziglang; what is short takes no time
        if sum(map(len, sources.values())) > 10_000:
            progress.warning(_ANNOUNCED, name, "ziglang" if "ziglang" in command else Path(command[0]).name)
        compile_objects(sources, command, objects)
        link_library(command, files, library, library.name)

    return make_once(library, link)


def link_library(
    command: Sequence[str], objects: Iterable[Path], library: Path, name: str, more: Sequence[str] = ()
) -> None:
    """Link the library ``library`` of object files and ``more``, in which its ``name`` may be another."""
    with tempfile.TemporaryDirectory(dir=library.parent) as folder:
        # in a folder, by a relative name: no path of this machine gets into the library
        files = [os.path.relpath(file, folder) for file in objects]
        _run([*command, *files, "-o", name, "-lm", *more], Path(folder))
        (Path(folder) / name).replace(library)


def make_once(file: Path, make: Callable[[], None]) -> Path:
    """Call ``make`` unless the ``file`` that it writes exists, and return the file.

    Other processes that need the file wait meanwhile.  If the process that makes it dies, the next one makes it.
    """
    if file.exists():
        return file
    file.parent.mkdir(parents=True, exist_ok=True)
    lock = file.with_name(f"{file.name}.lock")
    with lock.open("w") as handle:
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
    """Return the object files, to be made by ``compile_objects``, of the C files among ``sources``.

    The hash of a file, its includes, the compiler and its flags goes into the name: libraries share common files.
    """
    # wherever Python is: another one with the same ziglang compiles the same
    made_by = (compiler_version(tuple(compiler)), *compiler[compiler[0] == sys.executable :], *flags)
    digests = {file: hashlib.sha256(text.encode()).hexdigest() for file, text in sources.items()}
    return {
        file: folder / f"{Path(file).stem}-{_key(*made_by, *(f'{f} {digests[f]}' for f in _included(file, sources)))}.o"
        for file in sorted(sources)
        if file.endswith(".c")
    }


def compile_objects(sources: Mapping[str, str], command: Sequence[str], objects: Mapping[str, Path]) -> None:
    """Make those of the ``object_files`` that are not there, as many at a time as the machine has cores."""
    # the longest first, includes counted
    missing = sorted(
        (file for file, path in objects.items() if not path.exists()),
        key=lambda file: -sum(len(sources[part]) for part in _included(file, sources)),
    )
    if not missing:
        return
    folder = objects[missing[0]].parent
    with tempfile.TemporaryDirectory(dir=folder) as scratch, ThreadPoolExecutor(os.cpu_count()) as threads:
        for file, code in sources.items():
            (Path(scratch) / file).write_text(code, encoding="utf-8", newline="\n")

        def compile_one(file: str) -> None:
            # in the folder, by a relative name: no path of this machine gets into the code
            new = Path(scratch) / objects[file].name
            _run([*command, "-c", file, "-o", new.name], Path(scratch))
            new.replace(objects[file])  # atomic: processes with different libraries may build it at once

        list(threads.map(compile_one, missing))


def _included(file: str, sources: Mapping[str, str]) -> list[str]:
    """The file and those of the ``sources`` that it includes, each once."""
    included = [file]
    for part in included:
        included += (name for name in _INCLUDE.findall(sources[part]) if name in sources and name not in included)
    return list(dict.fromkeys(included))


def _run(command: Sequence[str], folder: Path) -> None:
    """Run it; CalledProcessError, with a note of what the command said, when it fails."""
    try:
        subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    except subprocess.CalledProcessError as error:
        error.add_note(error.stderr)
        raise


def _key(*parts: str) -> str:
    """Key in a file's name, from everything that the file is made of."""
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:20]


@cache
def compiler_version(compiler: tuple[str, ...]) -> str:
    """First line of the compiler's answer to ``--version``."""
    output = subprocess.run([*compiler, "--version"], capture_output=True, text=True, check=False).stdout
    return output.partition("\n")[0]


@lru_cache(maxsize=32)  # some 0.5 MB each
def generate_c(functions: tuple[ca.Function, ...], prefix: str = "kernels") -> str:
    """One C source with the functions, and ``prefix`` before the names of their shared parts."""
    generator = ca.CodeGenerator(prefix, {"with_header": False})
    for function in functions:
        generator.add(function)
    code: str = generator.dump()
    return code


def save_portable(functions: Sequence[ca.Function], path: Path) -> None:
    """Write the functions for ``load_portable``, which then needs nothing that built them."""
    serializer = ca.FileSerializer(str(path))
    serializer.pack(len(functions))
    for function in functions:
        serializer.pack(function)


def load_portable(path: Path) -> list[ca.Function]:
    """The functions of a file written by ``save_portable``."""
    file = ca.FileDeserializer(str(path))
    return [file.unpack() for _ in range(file.unpack())]


def platform_tag() -> str:
    """Operating system and processor, as in ``linux-x86_64``."""
    return f"{sys.platform}-{platform.machine().lower()}"


def load_compiled(functions: Sequence[ca.Function], library: Path) -> list[ca.Function]:
    """Load the functions from ``library``; RuntimeError where it lacks one, or has one of another size."""
    loaded = [ca.external(function.name(), str(library)) for function in functions]
    for ours, theirs in zip(functions, loaded, strict=True):
        sizes = [(f.size_in(i) for i in range(f.n_in())) for f in (ours, theirs)]
        if [*sizes[0]] != [*sizes[1]]:
            raise RuntimeError(f"{library} holds kernels of another mesh size")
    return loaded
