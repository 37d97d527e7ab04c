"""CasADi functions of the drive: compiled where there is a C compiler, else interpreted."""

import logging
import subprocess
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

import casadi as ca
import numpy as np

from rope_model.arrays import Array
from rope_model.compiler import compile_library, find_compiler, last_words

log = logging.getLogger(__name__)

KernelForm = Literal["auto", "compiled", "portable"]
#: function that builds a library with a compiler's command, or finds it in the cache
Build = Callable[[Sequence[str]], Path]


class Kernel:
    """One CasADi function called on numpy arrays without copying through CasADi's own matrices.

    Arrays are C-ordered with one row per CasADi column: shape (nodes, 7) for a (7, nodes) argument.  The returned
    arrays belong to the caller.  Not to be shared between threads.

    ``inputs`` and ``outputs`` are the arrays that ``evaluate`` reads and writes.
    """

    def __init__(self, function: ca.Function, shapes: Sequence[tuple[int, ...]]) -> None:
        self.function = function
        # the stubs of casadi do not know the buffer's methods
        buffer: Any
        buffer, self.evaluate = function.buffer()
        self._buffer = buffer
        self.inputs = [np.zeros(function.numel_in(i)) for i in range(function.n_in())]
        self.outputs = [np.zeros(function.numel_out(i)) for i in range(function.n_out())]
        for i, x in enumerate(self.inputs):
            buffer.set_arg(i, x.data)
        for i, x in enumerate(self.outputs):
            buffer.set_res(i, x.data)
        # views of the inputs in the shapes of the arguments, which never change
        self._taken: list[Array] = []
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
) -> tuple[list[ca.Function], str]:
    """Return the functions in the wanted form, and the form obtained: ``compiled`` or ``portable``.

    ``build`` makes their library with a compiler.

    Raises RuntimeError if ``compiled`` is required and not available.
    """
    if form == "portable":
        log.info("kernels: portable (CasADi virtual machine), set by the caller")
        return list(functions), "portable"
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
    # a machine without a compiler is expected, a compiler that fails is not
    level = logging.INFO if compiler is None else logging.WARNING
    log.log(
        level,
        "kernels: portable (CasADi virtual machine, 5 to 10 times as long), because %s",
        cause,
    )
    return list(functions), "portable"


def build_library(
    functions: Sequence[ca.Function],
    compiler: Sequence[str],
    folder: Path,
    name: str = "kernels",
) -> Path:
    """Generate C, compile it into ``folder`` unless it is there already, and return the library's path."""
    sources = {"kernels.c": generate_c(tuple(functions))}
    return compile_library(sources, compiler, folder, name)


@lru_cache(maxsize=32)  # each takes about 0.5 MB
def generate_c(functions: tuple[ca.Function, ...], prefix: str = "kernels") -> str:
    """Return one C source of the functions, with ``prefix`` before the names of their shared parts."""
    generator = ca.CodeGenerator(prefix, {"with_header": False})
    for function in functions:
        generator.add(function)
    return str(generator.dump())


def load_compiled(functions: Sequence[ca.Function], library: Path) -> list[ca.Function]:
    """Load the functions from ``library``; RuntimeError if it lacks one, or has one of another size."""
    loaded = [ca.external(function.name(), str(library)) for function in functions]
    for ours, theirs in zip(functions, loaded, strict=True):
        if _sizes(ours) != _sizes(theirs):
            raise RuntimeError(f"{library} holds kernels of another mesh size")
    return loaded


def _sizes(f: ca.Function) -> list[tuple[int, int]]:
    return [f.size_in(i) for i in range(f.n_in())] + [f.size_out(i) for i in range(f.n_out())]
