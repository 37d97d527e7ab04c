"""Export of native FMUs: self-contained C, FMI 2.0 or 3.0, for many platforms at once.

The model is the rope, or any model that implements model.h, in the rope's shell.
"""

import hashlib
import importlib.metadata
import os
import time
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fmu_src.archive import write_archive
from fmu_src.attachments import attachments, licenses
from fmu_src.interface import NO_CHANGES, Variable, case_with, variables
from fmu_src.model_description import (
    MODEL,
    Build,
    build_description,
    model_description,
    model_description3,
)
from fmu_src.native.build import choose_platforms
from fmu_src.native.prefix import checked_identifier, with_prefix
from fmu_src.native.start import Start, binaries_with, c_start
from fmu_src.native.table import c_places, c_table, start_values
from fmu_src.profile import Form, Profile, arrays, in_reading_order, scalars
from fmu_src.xml import xml_bytes
from rope_model.cases import Level, RopeCase
from rope_model.scene_names import Value

_HERE = Path(__file__).resolve().parent
HEADERS_IN_FMU = "fmi"  #: Folder of FMI's headers in the sources of an FMU.
HEADERS = _HERE / "headers"  #: Headers of FMI 2.0.5 and 3.0.2, of the Modelica Association.
_COMMON = ("component.c", "component.h", "model.h", "shell.inc", "snapshot.c", "snapshot.h")


def export_native(
    destination: Path,
    case: str = "rope-120",
    level: Level = "standard",
    fmi: int = 2,
    platforms: Sequence[str] | None = None,
    rope: Mapping[str, str] | None = None,
    start: Mapping[str, Value] = NO_CHANGES,
    profile: Profile = Profile(),  # noqa: B008  it is frozen
    identifier: str = MODEL,
) -> Path:
    """Write the native FMU with the start values of ``case``, at a level of accuracy and with ``start``.

    ``platforms`` are names of FMI 3.0, by default all that can be built here.  ``rope`` replaces the C files behind
    rope.h (tests do).  ``identifier`` is the FMU's model identifier: FMUs that are linked statically into one program
    must differ in it.  Two exports of the same sources give the same bytes.
    """
    if fmi not in (2, 3):
        raise ValueError(f"there is no FMI version {fmi}; choose 2 or 3")
    chosen = choose_platforms(platforms)
    data, epoch = case_with(case, level, start), os.environ.get("SOURCE_DATE_EPOCH")
    table = native_table(data)
    described = profile.select(table)
    files = native_files(
        table,
        described,
        {**(rope_sources() if rope is None else rope), **shell_sources(table, fmi)},
        f"{case} {level} {fmi} {sorted(start.items())} {profile} {identifier}",
        fmi,
        chosen,
        arrays if fmi == 3 and profile.arrays else scalars,
        # no date without SOURCE_DATE_EPOCH, so that two exports give the same bytes
        date=time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(int(epoch))) if epoch else "",
        stop=profile.stop,
        tolerance=data.scene.accuracy.end_force,
        identifier=identifier,
    )
    write_archive(destination, files | attachments(described.values(), data, fmi, native=True))
    return destination


def native_table(case: RopeCase) -> tuple[Variable, ...]:
    """Return the interface table, with marks on variables that only serve the Python flavour."""
    return tuple(
        v._replace(
            description=f"of no effect here, the code is compiled; Python flavour: {v.description}"
        )
        if v.name == "solver.kernels"
        else v
        for v in variables(case)
    )


def shell_sources(table: Sequence[Variable], fmi: int) -> dict[str, str]:
    """Return all sources between rope.h and the FMI functions without start.c."""
    written = shell(fmi, "rope_model.c", "rope_table.h")
    return {**written, "variables.c": c_table(table, fmi), "places.c": c_places(table, fmi)}


def rope_sources() -> dict[str, str]:
    """Return the text of the rope simulator in C by file name."""
    from rope_model.codegen.build import sources

    return sources()


def export_model(
    destination: Path,
    platforms: Sequence[str] | None,
    fmi: int,
    *,
    name: str,
    description: str,
    variables: Sequence[Variable],
    described: Mapping[int, Variable],
    sources: Mapping[str, str],
    data: Sequence[float],
    attachments: Mapping[str, bytes],
    duration: float,
    initial: Mapping[str, Sequence[str]],
    identifier: str | None = None,
) -> Path:
    """Write the FMU of a model without arrays, events and directional derivatives; ``platforms`` as for the rope.

    Its outputs at an instant depend on no input of that instant (after initialisation).  ``variables`` are those of
    the compiled model, ``described`` those of them that the FMU shows, with names of its own.  ``sources`` are C files
    that implement model.h, ``data`` numbers that they read by ``model_start`` from MODEL_SCALARS on, ``attachments``
    further files by their paths in the archive, ``duration`` that of the default run [s], ``initial`` the outputs'
    dependencies during initialisation, see Build.  ``identifier`` replaces the name as model identifier.
    """
    files = native_files(
        variables,
        in_reading_order(described),
        model_sources(variables, sources, fmi),
        f"{name}\0{start_values(variables, fmi)}\0{[*data]}\0{[v.name for v in described.values()]}",
        fmi,
        choose_platforms(platforms),
        stop=duration,
        name=name,
        description=description,
        derivatives=False,
        events=False,
        initial=initial,
        data=data,
        identifier=identifier or name,
    )
    write_archive(destination, {**files, **attachments, **licenses()})
    return destination


def native_files(
    table: Sequence[Variable],
    described: Mapping[int, Variable],
    sources: Mapping[str, str],
    what: str,
    fmi: int,
    platforms: Sequence[str],
    form: Form = arrays,
    data: Sequence[float] = (),
    identifier: str = MODEL,
    **facts: Any,
) -> dict[str, bytes]:
    """Return description, sources and libraries by path in the FMU.

    ``sources`` lack start.c; ``what`` distinguishes exports of the same sources; ``data`` are numbers behind the
    start values; ``facts`` are those of Build.
    """
    digest = hashlib.sha256(what.encode())
    for name, text in sorted(sources.items()):
        digest.update(f"\0{name}\0{text}".encode())
    token = str(uuid.uuid5(uuid.NAMESPACE_OID, f"balance-rope native {digest.hexdigest()}"))
    start = Start(token, (*start_values(table, fmi), *data), form is arrays)
    version = importlib.metadata.version("balance-rope")
    written = with_prefix(
        {**sources, "start.c": c_start(start)}, checked_identifier(identifier), fmi
    )
    compiled = tuple(sorted(name for name in written if name.endswith(".c")))
    tool = f"balance-rope {version}, native"
    build = Build(token, version, tool, sources=compiled, identifier=identifier, **facts)
    root = (
        model_description(described, build)
        if fmi == 2
        else model_description3(form(described), len(table), build)
    )
    return {
        "modelDescription.xml": xml_bytes(root),
        **{f"sources/{_place(name)}": text.encode() for name, text in written.items()},
        "sources/buildDescription.xml": xml_bytes(build_description(build, fmi)),
        **binaries_with(start, sources, build.name, fmi, platforms, identifier),
    }


def _place(name: str) -> str:
    """Return the path of a source file below the folder of sources.

    The standard has no headers of FMI beside the sources: an importer gives its own, such as one without prefixes for
    shared libraries.  Who has none finds them in a folder.
    """
    return f"{HEADERS_IN_FMU}/{name}" if (HEADERS / name).exists() else name


def model_sources(table: Sequence[Variable], model: Mapping[str, str], fmi: int) -> dict[str, str]:
    """Return the C files ``model`` with everything between model.h and the FMI functions without start.c."""
    return {**model, **shell(fmi), "variables.c": c_table(table, fmi)}


def shell(fmi: int, *more: str) -> dict[str, str]:
    """Return the C files between the FMI functions and model.h by name; ``more`` are further files of this folder."""
    headers = sorted(HEADERS.glob(f"fmi{fmi}*.h"))
    files = [*(_HERE / name for name in (*_COMMON, f"fmi{fmi}.c", *more)), *headers]
    return {path.name: path.read_text(encoding="utf-8") for path in files}
