"""Builds a native FMU (FMI 2.0 or 3.0) of any model that implements model.h, in the rope's shell."""

from __future__ import annotations

import hashlib
import importlib.metadata
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from fmu_src.archive import write_archive
from fmu_src.arrays import Form, arrays
from fmu_src.attachments import license_text, xml_bytes
from fmu_src.interface import Variable
from fmu_src.model_description import Build, model_description
from fmu_src.model_description3 import build_description, model_description3
from fmu_src.native.build import choose_platforms
from fmu_src.native.shell import shell
from fmu_src.native.start import Start, binaries_with, c_start
from fmu_src.native.table import c_table, start_values

_HERE = Path(__file__).resolve().parent


class ExportedModel(Protocol):
    """A model to export, without arrays and directional derivatives.

    Its outputs at an instant depend on no input of that instant (after initialisation).
    """

    @property
    def name(self) -> str:
        """Name of the model."""
        ...

    @property
    def description(self) -> str:
        """Description of the model."""
        ...

    @property
    def variables(self) -> Sequence[tuple[Any, ...]]:
        """Rows of the table: the values of a Variable each."""

    @property
    def sources(self) -> Mapping[str, str]:
        """Texts by file name: C that implements model.h."""

    @property
    def attachments(self) -> Mapping[str, bytes]:
        """Further files by their paths in the archive."""

    @property
    def duration(self) -> float:
        """Duration (s) of the default run."""

    @property
    def initial(self) -> Mapping[str, Sequence[str]]:
        """Dependencies of the outputs during initialisation, see Build."""


def export_model(destination: Path, model: ExportedModel, platforms: Sequence[str] | None = None, fmi: int = 2) -> Path:
    """Write the FMU of ``model`` to ``destination``; ``platforms`` as for the rope."""
    table = [Variable(*variable) for variable in model.variables]
    files = native_files(
        table,
        dict(enumerate(table)),
        model_sources(table, model.sources, fmi),
        f"{model.name}\0{start_values(table, fmi)}",
        fmi,
        choose_platforms(platforms),
        stop=model.duration,
        name=model.name,
        description=model.description,
        derivatives=False,
        initial=model.initial,
    )
    files |= model.attachments
    files["documentation/licenses/license.txt"] = license_text().encode()
    files["documentation/licenses/fmi-headers.txt"] = (_HERE / "include" / "LICENSE.txt").read_bytes()
    write_archive(destination, files)
    return destination


def native_files(
    table: Sequence[Variable],
    described: Mapping[int, Variable],
    sources: Mapping[str, str],
    what: str,
    fmi: int,
    platforms: Sequence[str],
    form: Form = arrays,
    **facts: Any,
) -> dict[str, bytes]:
    """Path in the FMU -> contents: description, sources and libraries.

    ``sources`` lack start.c; ``what`` tells exports of the same sources apart; ``facts`` are those of Build.
    """
    digest = hashlib.sha256(what.encode())
    for name, text in sorted(sources.items()):
        digest.update(f"\0{name}\0{text}".encode())
    token = str(uuid.uuid5(uuid.NAMESPACE_OID, f"balance-rope native {digest.hexdigest()}"))
    start = Start(token, start_values(table, fmi), form is arrays)
    version = importlib.metadata.version("balance-rope")
    written = {**sources, "start.c": c_start(start)}
    compiled = tuple(sorted(name for name in written if name.endswith(".c")))
    build = Build(token, version, f"balance-rope {version}, native", sources=compiled, **facts)
    root = model_description(described, build) if fmi == 2 else model_description3(form(described), len(table), build)
    return {
        "modelDescription.xml": xml_bytes(root),
        **{f"sources/{name}": text.encode() for name, text in written.items()},
        "sources/buildDescription.xml": xml_bytes(build_description(build, fmi)),
        **binaries_with(start, sources, build.name, fmi, platforms),
    }


def model_sources(table: Sequence[Variable], model: Mapping[str, str], fmi: int) -> dict[str, str]:
    """The C files ``model`` with everything between model.h and the FMI functions but start.c."""
    return {**model, **shell(fmi), "variables.c": c_table(table, fmi)}
