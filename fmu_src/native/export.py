"""Builds the native FMU: self-contained C, FMI 2.0 or 3.0, for many platforms at once."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from fmu_src.archive import write_archive
from fmu_src.arrays import arrays, scalars
from fmu_src.attachments import attachments
from fmu_src.interface import NO_CHANGES, Variable, case_with, variables
from fmu_src.native.build import choose_platforms
from fmu_src.native.model_fmu import native_files
from fmu_src.native.shell import shell
from fmu_src.native.table import c_places, c_table
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
    described = profile.select(table)
    files = native_files(
        table,
        described,
        {**(rope_sources() if rope is None else rope), **shell_sources(table, fmi)},
        f"{case} {level} {fmi} {sorted(start.items())} {profile}",
        fmi,
        chosen,
        arrays if fmi == 3 and profile.arrays else scalars,
        date=_date(),
        stop=profile.stop,
        tolerance=data.scene.accuracy.end_force,
    )
    write_archive(destination, files | attachments(described.values(), data, fmi, native=True))
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


def _date() -> str:
    """UTC, of SOURCE_DATE_EPOCH; empty without it, for two exports shall be the same bytes."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(int(epoch))) if epoch else ""
