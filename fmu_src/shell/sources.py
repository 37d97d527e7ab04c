"""C files between the functions of FMI and model.h, and their union with those of a model."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from fmu_src.interface import Variable
from fmu_src.shell.table import c_table

_HERE = Path(__file__).resolve().parent
HEADERS = _HERE / "headers"  #: Headers of FMI 2.0.5 and 3.0.2, of the Modelica Association.
_COMMON = ("component.c", "component.h", "model.h", "shell.inc", "snapshot.c", "snapshot.h")


def shell_files(fmi: int) -> dict[str, str]:
    """Return the written C files between the FMI functions and model.h by name."""
    headers = sorted(HEADERS.glob(f"fmi{fmi}*.h"))
    return texts([*(_HERE / name for name in (*_COMMON, f"fmi{fmi}.c")), *headers])


def texts(files: Sequence[Path]) -> dict[str, str]:
    """Return the texts of C files by name."""
    return {path.name: path.read_text(encoding="utf-8") for path in files}


def model_sources(table: Sequence[Variable], model: Mapping[str, str], fmi: int) -> dict[str, str]:
    """Return the C files ``model`` with all files between model.h and FMI but start.c."""
    return joined(model, {**shell_files(fmi), "variables.c": c_table(table, fmi)})


def joined(model: Mapping[str, str], between: Mapping[str, str]) -> dict[str, str]:
    """Return the C files of a model and those ``between`` it and FMI; ValueError if they share a name."""
    if both := model.keys() & between.keys():
        raise ValueError(
            f"two C files are called {min(both)}, the model's and that between it and FMI: rename the model's"
        )
    return {**model, **between}
