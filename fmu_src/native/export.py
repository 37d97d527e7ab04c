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
from typing import Any, NamedTuple, Protocol

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
from fmu_src.native.places import c_places
from fmu_src.native.prefix import checked_identifier, with_prefix
from fmu_src.profile import Grouping, Profile, arrays, in_reading_order, scalars
from fmu_src.shell.build import choose_platforms
from fmu_src.shell.sources import HEADERS, joined, model_sources, texts
from fmu_src.shell.start import Start, binaries_with, c_start
from fmu_src.shell.table import start_values
from fmu_src.xml import xml_bytes
from rope_model.cases import Level
from rope_model.scene_names import Value

_HERE = Path(__file__).resolve().parent
HEADERS_IN_FMU = "fmi"  #: Folder of FMI's headers in the sources of an FMU.
_WRITTEN = ("rope_model.c", "rope_table.h")


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
    """Write the native FMU of ``case`` at a level of accuracy; ``start`` replaces start values.

    ``platforms`` are names of FMI 3.0, by default all that can be built here.  ``rope`` replaces
    the C files behind rope.h (tests do).  ``identifier`` is the FMU's model identifier: FMUs that
    are linked statically into one program must differ in it.  Two exports of the same sources give
    the same bytes.
    """
    if fmi not in (2, 3):
        raise ValueError(f"there is no FMI version {fmi}; choose 2 or 3")
    chosen = choose_platforms(platforms)
    data = case_with(case, level, start)
    table = variables(data)
    described = profile.select(table)
    if rope is None:
        rope = rope_sources()
    files = native_files(
        Content(
            table,
            described,
            sources=joined(rope, shell_sources(table, fmi)),
            grouping=arrays if fmi == 3 and profile.arrays else scalars,
        ),
        key=f"{case} {level} {fmi} {sorted(start.items())} {profile} {identifier}",
        fmi=fmi,
        platforms=chosen,
        date=_build_date(),
        stop=profile.stop,
        tolerance=data.scene.accuracy.end_force,
        identifier=identifier,
    )
    write_archive(destination, files | attachments(described.values(), data, fmi, native=True))
    return destination


def _build_date() -> str:
    """Return the date of SOURCE_DATE_EPOCH.

    It is empty without it, so that two exports give the same bytes.
    """
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if not epoch:
        return ""
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(int(epoch)))


def shell_sources(table: Sequence[Variable], fmi: int) -> dict[str, str]:
    """Return all sources between rope.h and the FMI functions without start.c."""
    model = texts([_HERE / name for name in _WRITTEN])
    return model_sources(table, {**model, "places.c": c_places(table, fmi)}, fmi)


def rope_sources() -> dict[str, str]:
    """Return the text of the rope simulator in C by file name."""
    from rope_model.codegen.build import sources

    return sources()


class FmuModel(Protocol):
    """Model of an FMU that is not the rope.

    It has no arrays, events and directional derivatives; its outputs at an instant depend on no
    input of that instant (after initialisation).
    """

    @property
    def name(self) -> str:
        """Name of the model."""

    @property
    def description(self) -> str:
        """Description of the model."""

    @property
    def variables(self) -> Sequence[Variable]:
        """Variables of the compiled model, by value reference."""

    @property
    def described(self) -> Mapping[int, Variable]:
        """Variables that the FMU shows, with names of its own."""

    @property
    def sources(self) -> Mapping[str, str]:
        """C files that implement model.h."""

    @property
    def data(self) -> Sequence[float]:
        """Numbers that the sources read by ``model_start`` from MODEL_SCALARS on."""

    @property
    def attachments(self) -> Mapping[str, bytes]:
        """Further files by their paths in the archive."""

    @property
    def duration(self) -> float:
        """Length of the default run [s]."""

    @property
    def initial(self) -> Mapping[str, Sequence[str]]:
        """Dependencies of outputs during initialisation, see Build."""


def export_model(
    destination: Path,
    platforms: Sequence[str] | None,
    fmi: int,
    model: FmuModel,
) -> Path:
    """Write the FMU of a model; ``platforms`` as for the rope."""
    start = start_values(model.variables, fmi)
    names = [v.name for v in model.described.values()]
    files = native_files(
        Content(
            model.variables,
            in_reading_order(model.described),
            sources=model_sources(model.variables, model.sources, fmi),
            data=model.data,
        ),
        key=f"{model.name}\0{start}\0{[*model.data]}\0{names}",
        fmi=fmi,
        platforms=choose_platforms(platforms),
        stop=model.duration,
        name=model.name,
        description=model.description,
        derivatives=False,
        events=False,
        initial=model.initial,
        identifier=model.name,
    )
    write_archive(destination, {**files, **model.attachments, **licenses()})
    return destination


class Content(NamedTuple):
    """Variables and sources of an FMU."""

    table: Sequence[Variable]  # of the compiled model
    described: Mapping[int, Variable]  # of the FMU, by value reference
    sources: Mapping[str, str]  # without start.c
    grouping: Grouping = arrays  # in FMI 3.0
    data: Sequence[float] = ()  # numbers behind the start values


def native_files(
    content: Content,
    key: str,
    fmi: int,
    platforms: Sequence[str],
    identifier: str = MODEL,
    **facts: Any,
) -> dict[str, bytes]:
    """Return description, sources and libraries by path in the FMU.

    ``key`` distinguishes exports of the same sources; ``facts`` are those of Build.
    """
    sources = content.sources
    digest = hashlib.sha256(key.encode())
    for name, text in sorted(sources.items()):
        digest.update(f"\0{name}\0{text}".encode())
    token = str(uuid.uuid5(uuid.NAMESPACE_OID, f"balance-rope native {digest.hexdigest()}"))
    values = (*start_values(content.table, fmi), *content.data)
    start = Start(token, values, arrays=content.grouping is arrays)
    version = importlib.metadata.version("balance-rope")
    written = with_prefix(
        {**sources, "start.c": c_start(start)}, checked_identifier(identifier), fmi
    )
    compiled = tuple(sorted(name for name in written if name.endswith(".c")))
    tool = f"balance-rope {version}, native"
    build = Build(token, version, tool, sources=compiled, identifier=identifier, **facts)
    if fmi == 2:
        root = model_description(content.described, build)
    else:
        root = model_description3(content.grouping(content.described), len(content.table), build)
    return {
        "modelDescription.xml": xml_bytes(root),
        **{f"sources/{_place(name)}": text.encode() for name, text in written.items()},
        "sources/buildDescription.xml": xml_bytes(build_description(build, fmi)),
        **binaries_with(start, sources, build.name, fmi, platforms, identifier),
    }


def _place(name: str) -> str:
    """Return the path of a source file below the folder of sources.

    The standard has no headers of FMI beside the sources: an importer gives its own, such as one
    without prefixes for shared libraries.  A folder has them for importers without.
    """
    if (HEADERS / name).exists():
        return f"{HEADERS_IN_FMU}/{name}"
    return name
