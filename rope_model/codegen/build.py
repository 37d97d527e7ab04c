"""The native rope's C sources, complete, and the library they make.

An installed package brings the library for each platform, and the generated sources: another version of CasADi writes
them in other words.
"""

from __future__ import annotations

import importlib.metadata
import json
import sys
import tempfile
from functools import cache
from pathlib import Path

from rope_model.codegen.elements import element_code
from rope_model.codegen.formulas import formulas_code
from rope_model.codegen.messages import messages_code
from rope_model.codegen.platforms import host_platform, prebuilt_file, text_hash
from rope_model.codegen.rules import rules_code, state_signals
from rope_model.codegen.state_structures import state_structures
from rope_model.codegen.tables import parameter_bounds, parameter_structures, signal_numbers
from rope_model.numerics.kernels import FLAGS, cache_folder, compile_library, find_compiler

_FOLDER = Path(__file__).resolve().parent.parent / "csrc"
NAME = "rope"


@cache
def sources() -> dict[str, str]:
    """Return the text of all written and generated files, by file name."""
    return {path.name: path.read_text(encoding="utf-8") for path in _written()} | _generated()


def _written() -> list[Path]:
    files = (path for path in _FOLDER.rglob("*") if path.suffix in (".c", ".h", ".inc"))
    return sorted(files, key=lambda path: path.name)


def lay_out(folder: Path) -> None:
    """Put all C into ``folder`` for an editor: links to written files, generated files, compile_commands.json."""
    folder = folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    for name in sources():
        (folder / name).unlink(missing_ok=True)
    for path in _written():
        (folder / path.name).symlink_to(path)
    for name, text in _generated().items():
        (folder / name).write_text(text, encoding="utf-8")
    commands = [
        {"directory": str(folder), "file": name, "arguments": ["cc", *FLAGS, "-c", name]}
        for name in sources()
        if name.endswith(".c")
    ]
    (folder / "compile_commands.json").write_text(json.dumps(commands, indent=1), encoding="utf-8")


def _generated() -> dict[str, str]:
    """The generated files: the package's, the cache's, or made and put there."""
    brought = generated_file(_FOLDER.parent)
    kept = cache_folder() / f"{brought.stem}-casadi-{importlib.metadata.version('casadi')}.json"
    for file in (brought, kept):
        if file.exists():
            texts: dict[str, str] = json.loads(file.read_text(encoding="utf-8"))
            return texts
    texts = generate()
    kept.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=kept.parent) as scratch:
        new = Path(scratch) / kept.name
        new.write_text(json.dumps(texts), encoding="utf-8")
        new.replace(kept)  # atomic: two processes may do so at once
    return texts


def generate() -> dict[str, str]:
    """The generated files, made anew from the physics and the tables of signals and parameters."""
    return {
        "elements.inc": element_code(),
        "formulas.h": formulas_code(),
        "messages.h": messages_code(),
        "rules.h": rules_code(),
        "state.h": state_structures(),
        "signal_numbers.h": signal_numbers(),
        "state_signals.h": state_signals(),
        "parameters.h": parameter_structures(),
        "parameters.inc": parameter_bounds(),
    }


def generated_file(package: Path) -> Path:
    """Return the JSON of the generated files, if ``package``, a folder rope_model, has it for its Python text."""
    return package / "csrc" / "prebuilt" / f"generated-{text_hash(package)}.json"


@cache
def library() -> Path:
    """The compiled library: the package's, or from the cache of kernels, or compiled.

    Raises RuntimeError without a C compiler, CalledProcessError when that fails.
    """
    if (brought := prebuilt_file(_FOLDER, sources(), NAME, host_platform())).exists():
        return brought
    if (compiler := find_compiler()) is None:
        raise RuntimeError(
            "the native rope needs a C compiler; install one, or ziglang: pip install 'balance-rope[compiler]'"
        )
    return compile_library(sources(), compiler, cache_folder(), NAME)


if __name__ == "__main__":
    lay_out(Path(sys.argv[1]))
