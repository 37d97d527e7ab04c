"""Builds the native FMU: self-contained C, FMI 2.0 or 3.0, for many platforms at once."""

from __future__ import annotations

import hashlib
import importlib.metadata
import os
import time
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path

from fmu_src.archive import write_archive
from fmu_src.arrays import arrays, scalars
from fmu_src.attachments import attachments, xml_bytes
from fmu_src.interface import NO_CHANGES, Variable, case_with, variables
from fmu_src.model_description import MODEL, Build, model_description
from fmu_src.model_description3 import build_description, model_description3
from fmu_src.native.build import choose_platforms
from fmu_src.native.shell import shell
from fmu_src.native.start import Start, binaries_with, c_start
from fmu_src.native.table import c_places, c_table, start_values
from fmu_src.profile import Profile
from rope_model.parameters import Level, RopeCase
from rope_model.scene_names import Value


def export_native(
    destination: Path,
    case: str = "rope-120",
    level: Level = "standard",
    fmi: int = 2,
    platforms: Sequence[str] | None = None,
    rope: Mapping[str, str] | None = None,
    start: Mapping[str, Value] = NO_CHANGES,
    profile: Profile = Profile(),  # noqa: B008  it is frozen
) -> Path:
    """Write the native FMU with the start values of ``case``, at a level of accuracy and with ``start``.

    ``platforms`` are names of FMI 3.0, all that can be built here if None.  ``rope`` replaces the C files behind
    rope.h (tests do).  Two exports of the same sources give the same bytes.
    """
    if fmi not in (2, 3):
        raise ValueError(f"there is no FMI version {fmi}; choose 2 or 3")
    chosen = choose_platforms(platforms)
    data = case_with(case, level, start)
    table = native_table(data)
    form = arrays if fmi == 3 and profile.arrays else scalars
    sources = {**(rope_sources() if rope is None else rope), **shell_sources(table, fmi)}
    what = f"{case} {level} {fmi} {sorted(start.items())} {profile}"
    own = Start(_token(sources, what), start_values(table, fmi), form is arrays)
    code = binaries_with(own, sources, MODEL, fmi, chosen)
    sources["start.c"] = c_start(own)
    build = Build(
        own.token,
        importlib.metadata.version("balance-rope"),
        f"balance-rope {importlib.metadata.version('balance-rope')}, native",
        _date(),
        profile.stop,
        data.scene.accuracy.end_force,
        tuple(sorted(name for name in sources if name.endswith(".c"))),
    )
    described = profile.select(table)
    root = model_description(described, build) if fmi == 2 else model_description3(form(described), len(table), build)
    files = {"modelDescription.xml": xml_bytes(root)}
    files |= {f"sources/{name}": text.encode() for name, text in sources.items()}
    files["sources/buildDescription.xml"] = xml_bytes(build_description(build, fmi))
    files |= code
    files |= attachments(described.values(), data, fmi, native=True)
    write_archive(destination, files)
    return destination


def native_table(case: RopeCase) -> tuple[Variable, ...]:
    """The interface table, with marks on variables of the Python flavour alone."""
    return tuple(
        v._replace(description=f"of no effect here, the code is compiled; Python flavour: {v.description}")
        if v.name == "solver.kernels"
        else v
        for v in variables(case)
    )


def shell_sources(table: Sequence[Variable], fmi: int) -> dict[str, str]:
    """All sources between rope.h and the FMI functions but start.c."""
    written = shell(fmi, "rope_model.c", "rope_table.h")
    return {**written, "variables.c": c_table(table, fmi), "places.c": c_places(table, fmi)}


def rope_sources() -> dict[str, str]:
    """The rope simulator in C: file name -> text."""
    from rope_model.codegen.build import sources

    return sources()


def _token(sources: Mapping[str, str], what: str) -> str:
    """GUID or instantiation token: the same for the same sources, start values and FMI version."""
    digest = hashlib.sha256(what.encode())
    for name, text in sorted(sources.items()):
        digest.update(f"\0{name}\0{text}".encode())
    return str(uuid.uuid5(uuid.NAMESPACE_OID, f"balance-rope native {digest.hexdigest()}"))


def _date() -> str:
    """UTC, of SOURCE_DATE_EPOCH; empty without it, for two exports shall be the same bytes."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(int(epoch))) if epoch else ""
