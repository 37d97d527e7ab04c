"""Builds a native FMU (FMI 2.0) of any model that implements model.h, in the rope's shell."""

from __future__ import annotations

import hashlib
import importlib.metadata
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path

from ..archive import write_archive
from ..attachments import license_text, xml_bytes
from ..interface import Variable
from ..model_description import Build, model_description
from ..model_description3 import build_description
from .build import available_platforms, binaries
from .shell import shell
from .table import c_table

_HERE = Path(__file__).resolve().parent


def export_model(
    destination: Path,
    name: str,
    description: str,
    table: Sequence[Variable],
    model: Mapping[str, str],
    attachments: Mapping[str, bytes],
    platforms: Sequence[str] | None = None,
) -> Path:
    """Write the FMU of the C files ``model`` to ``destination``.

    The model has no directional derivatives, and its outputs at an instant depend on no input of that instant (after
    initialisation). ``attachments`` are further files by their paths in the archive; ``platforms`` as for the rope.
    """
    chosen = available_platforms() if platforms is None else tuple(platforms)
    if not chosen:
        raise ValueError("no platform to build for: install a C compiler, or the ziglang package")
    sources = {**model, **shell(2)}
    token = _token(name, sources, c_table(table, "", 2))
    sources["variables.c"] = c_table(table, token, 2)
    version = importlib.metadata.version("balance-rope")
    compiled = tuple(sorted(file for file in sources if file.endswith(".c")))
    build = Build(token, version, f"balance-rope {version}, native", "", compiled, name, description, derivatives=False)
    root = model_description(table, build)
    for unknown in root.iterfind("ModelStructure/Outputs/Unknown"):
        unknown.set("dependencies", "")
    files = {"modelDescription.xml": xml_bytes(root), **attachments}
    files["documentation/licenses/license.txt"] = license_text().encode()
    files["documentation/licenses/fmi-headers.txt"] = (_HERE / "include" / "LICENSE.txt").read_bytes()
    files |= {f"sources/{file}": text.encode() for file, text in sources.items()}
    files["sources/buildDescription.xml"] = xml_bytes(build_description(build))
    files |= binaries(sources, name, 2, chosen)
    write_archive(destination, files)
    return destination


def _token(name: str, sources: Mapping[str, str], table: str) -> str:
    """GUID: the same for the same sources and start values."""
    digest = hashlib.sha256(f"{name}\0{table}".encode())
    for file, text in sorted(sources.items()):
        digest.update(f"\0{file}\0{text}".encode())
    return str(uuid.uuid5(uuid.NAMESPACE_OID, f"balance-rope {digest.hexdigest()}"))
