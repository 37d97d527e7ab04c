"""C files between the functions of FMI and model.h, and their union with those of a model."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from fmu_src.interface import Variable
from fmu_src.shell.table import c_table

_HERE = Path(__file__).resolve().parent
HEADERS = _HERE / "headers"  #: Headers of FMI 2.0.5 and 3.0.2, of the Modelica Association.
_STANDARDS = ("fmi2.c", "fmi3.c")
_TEXT = ("text.c", "text.h")  #: Files of the rope that serve every model.


def shell_files(fmi: int) -> dict[str, str]:
    """Return the written C files between the FMI functions and model.h by name."""
    from rope_model.codegen.build import written

    files = [path for path in _HERE.iterdir() if path.suffix in (".c", ".h", ".inc")]
    common = [path for path in files if path.name not in _STANDARDS]
    text = [path for path in written() if path.name in _TEXT]
    headers = HEADERS.glob(f"fmi{fmi}*.h")
    return texts(sorted([*common, _HERE / f"fmi{fmi}.c", *text, *headers]))


def texts(files: Sequence[Path]) -> dict[str, str]:
    """Return the texts of C files by name."""
    return {path.name: path.read_text(encoding="utf-8") for path in files}


def model_sources(table: Sequence[Variable], model: Mapping[str, str], fmi: int) -> dict[str, str]:
    """Return the C files ``model`` with all files between model.h and FMI but start.c."""
    return joined(model, {**shell_files(fmi), "variables.c": c_table(table, fmi)})


def joined(model: Mapping[str, str], between: Mapping[str, str]) -> dict[str, str]:
    """Return the C files of a model and those ``between`` it and FMI.

    Raises ValueError for two files of one name with different texts.
    """
    both = {name for name in model.keys() & between.keys() if model[name] != between[name]}
    if both:
        raise ValueError(
            f"two C files are called {min(both)}, the model's and that between it and FMI: rename the model's"
        )
    return {**model, **between}
