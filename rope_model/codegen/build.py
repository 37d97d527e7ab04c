"""Sources of the native rope, written and generated, and their compilation to a library.

An installed package contains the library for each platform, and the generated sources: another
version of CasADi generates different text.
"""

import ctypes
import importlib.metadata
import json
import subprocess
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

from rope_model.codegen.elements import element_code
from rope_model.codegen.formula_functions import formulas_code
from rope_model.codegen.interface_structures import interface_structures
from rope_model.codegen.messages import messages_code
from rope_model.codegen.platforms import host_platform, prebuilt_file, text_hash
from rope_model.codegen.rules import rules_code, state_signals
from rope_model.codegen.state_structures import state_structures
from rope_model.codegen.tables import parameter_bounds, parameter_structures, signal_numbers
from rope_model.compiler import cache_folder, compile_library, find_compiler, last_words, make_once
from rope_model.files import WriteError, write_text

_FOLDER = Path(__file__).resolve().parent.parent / "csrc"
NAME = "rope"
#: functions that make the generated files, by file name
_GENERATED: dict[str, Callable[[], str]] = {
    "elements.inc": element_code,
    "formulas.h": formulas_code,
    "messages.h": messages_code,
    "rules.h": rules_code,
    "state_structures.h": state_structures,
    "interface_structures.h": interface_structures,
    "signal_numbers.h": signal_numbers,
    "state_signals.h": state_signals,
    "parameters.h": parameter_structures,
    "parameters.inc": parameter_bounds,
}


class NoEngine(RuntimeError):
    """There is no native rope here; the text names cause and cure."""


@cache
def sources() -> dict[str, str]:
    """Return the text of all written and generated files, by file name."""
    return {path.name: path.read_text(encoding="utf-8") for path in written()} | _generated()


def written(folder: Path = _FOLDER) -> list[Path]:
    """List the files below ``folder`` that are not generated.

    Raises ValueError if two files have one name: they are compiled in one folder, and an #include
    gives no more than the name.
    """
    paths = [path for path in folder.rglob("*") if path.suffix in (".c", ".h", ".inc")]
    places = dict.fromkeys(_GENERATED, "the generated one")
    for path in sorted(paths):
        place = path.relative_to(folder).as_posix()
        if path.name in places:
            raise ValueError(
                f"two C files are called {path.name}, {places[path.name]} and {place}: rename one"
            )
        places[path.name] = place
    return sorted(paths, key=lambda path: path.name)


def _generated() -> dict[str, str]:
    """Return the generated files: the package's, the cache's, or new ones, which go into the cache."""
    packaged = generated_file(_FOLDER.parent)
    cached = cache_folder() / f"{packaged.stem}-casadi-{importlib.metadata.version('casadi')}.json"

    def make() -> None:
        write_text(cached, json.dumps(generate()))

    file = packaged if packaged.exists() else make_once(cached, make)
    texts: dict[str, str] = json.loads(file.read_text(encoding="utf-8"))
    return texts


def generate() -> dict[str, str]:
    """Generate the files from the physics and the tables of signals and parameters."""
    return {name: make() for name, make in _GENERATED.items()}


def generated_file(package: Path) -> Path:
    """Return the path of the generated files' JSON in ``package``, a folder rope_model, for its Python text."""
    return package / "csrc" / "prebuilt" / f"generated-{text_hash(package)}.json"


@cache
def library() -> Path:
    """Return the compiled library: the package's, the cached one, or one compiled for this machine's processor.

    Raises NoEngine without a C compiler, or if it fails, and WriteError if the cache cannot be
    written.
    """
    if (packaged := prebuilt_file(_FOLDER, sources(), NAME, host_platform())).exists():
        return packaged
    if (compiler := find_compiler()) is None:
        raise NoEngine(
            "the native rope needs a C compiler; install one, or ziglang: pip install 'balance-rope[compiler]'"
        )
    detection = {name: sources()[name] for name in ("processor.c", "processor.h")}
    try:
        question = compile_library(detection, compiler, cache_folder(), "processor")
        return library_of(ctypes.CDLL(str(question)).processor_lanes(), compiler)
    except WriteError:
        raise
    except (OSError, subprocess.CalledProcessError) as error:
        raise failed(error) from error


def failed(error: Exception) -> NoEngine:
    """Return the error of a compiler that fails, or of a library that does not load."""
    return NoEngine(
        f"the native rope cannot be had: {last_words(error)}; repair the compiler, name another in CC, or take "
        "ziglang: pip install 'balance-rope[compiler]', and CC='python -m ziglang cc'"
    )


def library_of(lanes: int, compiler: Sequence[str]) -> Path:
    """Compile the library for vectors of ``lanes`` numbers only, as processor.c reports them, in half the time."""
    others = (
        form for form, numbers in {"plain": 2, "wide": 4, "widest": 8}.items() if numbers != lanes
    )
    texts = {f"chains_{x}.c": f'#include "chain.h"\nconst Chain chains_{x}[3];\n' for x in others}
    texts["processor.c"] = f"int processor_lanes(void) {{\n    return {lanes};\n}}\n"
    return compile_library(sources() | texts, compiler, cache_folder(), NAME)
