"""Builds a native FMU (FMI 2.0 or 3.0) of any model that implements model.h, in the rope's shell."""

from __future__ import annotations

import hashlib
import importlib.metadata
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from fmu_src.archive import write_archive
from fmu_src.arrays import scalars
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
    sources = model_sources(table, model.sources, fmi)
    values = start_values(table, fmi)
    start = Start(_token(model.name, sources, values), values)
    code = binaries_with(start, sources, model.name, fmi, choose_platforms(platforms))
    sources["start.c"] = c_start(start)
    version = importlib.metadata.version("balance-rope")
    compiled = tuple(sorted(file for file in sources if file.endswith(".c")))
    build = Build(
        start.token,
        version,
        f"balance-rope {version}, native",
        "",
        model.duration,
        sources=compiled,
        name=model.name,
        description=model.description,
        derivatives=False,
        initial=model.initial,
    )
    described = dict(enumerate(table))
    root = (
        model_description(described, build) if fmi == 2 else model_description3(scalars(described), len(table), build)
    )
    files = {"modelDescription.xml": xml_bytes(root), **model.attachments}
    files["documentation/licenses/license.txt"] = license_text().encode()
    files["documentation/licenses/fmi-headers.txt"] = (_HERE / "include" / "LICENSE.txt").read_bytes()
    files |= {f"sources/{file}": text.encode() for file, text in sources.items()}
    files["sources/buildDescription.xml"] = xml_bytes(build_description(build, fmi))
    files |= code
    write_archive(destination, files)
    return destination


def model_sources(table: Sequence[Variable], model: Mapping[str, str], fmi: int) -> dict[str, str]:
    """The C files ``model`` with everything between model.h and the FMI functions but start.c."""
    return {**model, **shell(fmi), "variables.c": c_table(table, fmi)}


def _token(name: str, sources: Mapping[str, str], values: Sequence[float]) -> str:
    """GUID: the same for the same sources and start values."""
    digest = hashlib.sha256(f"{name}\0{values}".encode())
    for file, text in sorted(sources.items()):
        digest.update(f"\0{file}\0{text}".encode())
    return str(uuid.uuid5(uuid.NAMESPACE_OID, f"balance-rope {digest.hexdigest()}"))
