"""Builds a native FMU (FMI 2.0 or 3.0) of any model that implements model.h, in the rope's shell."""

from __future__ import annotations

import hashlib
import importlib.metadata
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path

from ..archive import write_archive
from ..arrays import scalars
from ..attachments import license_text, xml_bytes
from ..interface import Variable
from ..model_description import ALL_FOLLOWED, Build, model_description
from ..model_description3 import build_description, model_description3
from ..profile import Profile
from .build import choose_platforms
from .shell import shell
from .start import Start, binaries_with, c_start
from .table import c_table, start_values

_HERE = Path(__file__).resolve().parent


def export_model(
    destination: Path,
    name: str,
    description: str,
    table: Sequence[Variable],
    model: Mapping[str, str],
    attachments: Mapping[str, bytes],
    platforms: Sequence[str] | None = None,
    fmi: int = 2,
    stop: float = Profile.stop,
    initial: Mapping[str, Sequence[str]] = ALL_FOLLOWED,
) -> Path:
    """Write the FMU of the C files ``model`` to ``destination``; ``stop`` is the time of its default run's end, s.

    The model has no arrays and no directional derivatives, and its outputs at an instant depend on no input of that
    instant (after initialisation; ``initial``: see Build). ``attachments`` are further files by their paths in the
    archive; ``platforms`` as for the rope.
    """
    sources = model_sources(table, model, fmi)
    values = start_values(table, fmi)
    start = Start(_token(name, sources, values), values)
    code = binaries_with(start, sources, name, fmi, choose_platforms(platforms))
    sources["start.c"] = c_start(start)
    version = importlib.metadata.version("balance-rope")
    compiled = tuple(sorted(file for file in sources if file.endswith(".c")))
    build = Build(
        start.token,
        version,
        f"balance-rope {version}, native",
        "",
        stop,
        sources=compiled,
        name=name,
        description=description,
        derivatives=False,
        initial=initial,
    )
    described = dict(enumerate(table))
    root = (
        model_description(described, build) if fmi == 2 else model_description3(scalars(described), len(table), build)
    )
    files = {"modelDescription.xml": xml_bytes(root), **attachments}
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
