"""The compiled code that the wheel brings, for every platform, and the generated sources that it is made of.

A further library is one more line in ``libraries``.
"""

import json
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import NamedTuple

from fmu_src.interface import variables
from fmu_src.model_description import MODEL
from fmu_src.native.export import rope_sources, shell_sources
from fmu_src.python.export import library_sources
from fmu_src.shell.build import PLATFORMS, library, open_library
from fmu_src.shell.sources import joined, model_sources
from fmu_src.shell.start import without_start
from fmu_src.shell.table import start_values
from hoist_demo.cases.table import find_case
from hoist_demo.drive_fmu.description import drive_model
from hoist_demo.drive_fmu.description import sources as drive_sources
from hoist_demo.drive_fmu.kernels import complete, kernels_file, structures
from hoist_demo.drive_fmu.kernels import generate as drive_kernels
from hoist_demo.parameters import Hoist
from rope_model.cases import rope_120
from rope_model.codegen.build import NAME, generate, generated_file, sources
from rope_model.codegen.platforms import prebuilt_file


class Library(NamedTuple):
    """C text by file name, and the name that an FMU knows the library by."""

    sources: Mapping[str, str]
    identifier: str


def libraries() -> Iterator[Library]:
    """Those of FMUs."""
    table = variables(rope_120())
    yield Library(without_start(library_sources(table), len(start_values(table, 2))), MODEL)
    for fmi in (2, 3):
        yield _rope(fmi)
        for structure in structures():
            yield drive_library(structure, fmi)


def _rope(fmi: int) -> Library:
    table = variables(rope_120())
    shared = without_start(
        joined(rope_sources(), shell_sources(table, fmi)), len(start_values(table, fmi))
    )
    return Library(shared, MODEL)


def drive_library(structure: Hoist, fmi: int) -> Library:
    """Return the library of all hoists' drives of a structure, whose tables and numbers are alike."""
    drive = drive_model(find_case("rope-120"))
    numbers = (
        len(drive.data)
        - len(complete(find_case("rope-120").hoist).numbers)
        + len(structure.numbers)
    )
    sources = model_sources(drive.variables, drive_sources(structure), fmi)
    return Library(
        without_start(sources, len(start_values(drive.variables, fmi)) + numbers), drive.name
    )


def add_prebuilt(root: Path) -> None:
    """Write what the packages below ``root``, copies of ours, are to bring."""
    _write(generated_file(root / "rope_model"), generate())
    for structure in structures():
        _write(kernels_file(root / "hoist_demo", structure), asdict(drive_kernels(structure)))
    for name in PLATFORMS:
        rope = prebuilt_file(root / "rope_model" / "csrc", sources(), NAME, name)
        shutil.copyfile(open_library(sources(), NAME, name), rope)
    (root / "fmu_src" / "shell" / "prebuilt").mkdir()
    for one in libraries():
        for name in PLATFORMS:
            to = prebuilt_file(root / "fmu_src" / "shell", one.sources, one.identifier, name)
            shutil.copyfile(library(one.sources, one.identifier, name), to)


def _write(path: Path, data: Mapping[str, object]) -> None:
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(data), encoding="utf-8")
