"""``balance-rope export``: the rope as an FMU, and a hoist as one system of FMUs."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

from fmu_src.model_description import MODEL
from fmu_src.profile import ALL, DEFAULT, OUTPUT_GROUPS, Profile
from fmu_src.shell.build import (
    PLATFORMS,
    available_platforms,
    host_platform,
    missing_platforms,
)
from fmu_src.ssp import SystemNumber, Version
from hoist_demo.cases.case import BUILTIN_HOISTS, DEFAULT_HOIST, Case
from hoist_demo.cases.rules import case_with_values
from hoist_demo.cases.table import BUILD, NATIVE_ENDING, find_case, fmu_name
from hoist_demo.command_line.options import settings
from hoist_demo.command_line.support import nonempty_path, results_folder
from hoist_demo.export.system import (
    NATIVE,
    OMITTABLE,
    PYTHON,
    RopeFmu,
    SystemOptions,
    export_hoist,
    export_rope,
)
from hoist_demo.files.reading import read
from hoist_demo.files.registry import CONTROLLER, parameters, rope_parameters
from hoist_demo.files.rope_file import RopeFile
from hoist_demo.files.values import values_of
from hoist_demo.report.rows import aligned_table
from rope_model.cases import LEVELS
from rope_model.files import write_bytes

if TYPE_CHECKING:
    from hoist_demo.control.trajectory import Trajectory
    from hoist_demo.run.ropes import OneRope

#: flavour and FMI version -> end of the file name
NAMES = {(PYTHON, 2): "", (NATIVE, 2): NATIVE_ENDING, (NATIVE, 3): "_native_fmi3"}


def add_export(export: argparse.ArgumentParser) -> None:
    """Add description and options of the command ``export``."""
    export.description = (
        "Export the balance rope as a co-simulation FMU. The native flavour (FMI 2.0 "
        "or 3.0), the default, is the complete model in self-contained C and needs nothing on the "
        "importing host. The Python flavour (FMI 2.0) is the published system in plain Python, to "
        "be read and changed, and needs Python with numpy, scipy and casadi there. What both have "
        "has the same names, "
        "and the same C code answers the tool; parameters can still be set before initialisation. "
        "An installed wheel brings the libraries; in a checkout the first export compiles, with a "
        "C compiler or ziglang, some 10 s per platform, a second version of FMI some more; "
        "--platform host makes it short."
    )
    _add_kinds(export)
    _add_start_values(export)
    _add_description(export)
    _add_system(export)
    export.add_argument(
        "--out", type=nonempty_path, help=f"the .fmu to write, or a folder ({BUILD})"
    )
    export.set_defaults(run=_export)


def _add_kinds(export: argparse.ArgumentParser) -> None:
    """Add the options on flavour, version of FMI and platforms."""
    export.add_argument(
        "--python",
        action="store_true",
        help="the Python flavour, with fewer outputs: docs/reference/variables.md lists them",
    )
    export.add_argument(
        "--native",
        action="store_true",
        help="the native flavour (the default; beside --python: both)",
    )
    export.add_argument(
        "--fmi", type=int, nargs="+", choices=(2, 3), default=[2], help="version of FMI (2)"
    )
    export.add_argument(
        "--platform",
        nargs="+",
        choices=("host", *PLATFORMS),
        metavar="NAME",
        help=f"platforms of the libraries: host, {', '.join(PLATFORMS)} (all that can be built "
        "here)",
    )


def _add_start_values(export: argparse.ArgumentParser) -> None:
    """Add the hoist and the options that change its start values."""
    export.add_argument(
        "hoist",
        nargs="?",
        default=DEFAULT_HOIST,
        metavar="HOIST",
        help=f"start values: the rope of a hoist's file, or of {', '.join(BUILTIN_HOISTS)} "
        "(%(default)s)",
    )
    export.add_argument(
        "--rope",
        type=Path,
        metavar="FILE",
        help="start values of the rope, as balance-rope identify writes them",
    )
    export.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="start value of a parameter by its name in docs/reference/variables.md, in SI units; "
        "with --ssp also of the drive, as hoist.payload_left; may be repeated, and overrides "
        "HOIST and --rope",
    )
    export.add_argument(
        "--level",
        choices=tuple(LEVELS),
        help="accuracy against speed, see docs/howto/accuracy.md (that of the hoist)",
    )


def _add_description(export: argparse.ArgumentParser) -> None:
    """Add the options on what the FMU shows of itself."""
    export.add_argument(
        "--outputs",
        nargs="+",
        choices=("all", *OUTPUT_GROUPS),
        default=list(DEFAULT),
        metavar="GROUP",
        help=f"outputs that the FMU shows: all, or groups of {', '.join(OUTPUT_GROUPS)} (all but shape "
        "and station, points along the rope and places in it, which the demo's report draws)",
    )
    export.add_argument(
        "--scalar",
        action="store_true",
        help="FMI 3.0 without arrays: each element a variable, for tools without them",
    )
    export.add_argument(
        "--model-identifier",
        default=MODEL,
        metavar="NAME",
        help="model identifier of a native FMU: C functions of its sources and its libraries "
        "begin with it, and FMUs that are linked into one program must differ in it (%(default)s)",
    )


def _add_system(export: argparse.ArgumentParser) -> None:
    """Add the options of the system."""
    export.add_argument(
        "--ssp",
        action="store_true",
        help="also hoist drive and rope as one system, an .ssp beside the .fmu",
    )
    export.add_argument(
        "--ssp-version",
        choices=get_args(Version),
        default="1.0",
        help="version of SSP (%(default)s)",
    )
    export.add_argument(
        "--without",
        nargs="+",
        choices=OMITTABLE,
        default=[],
        metavar="NAME",
        help=f"leave this out of the system: {', '.join(OMITTABLE)}; without it, what a system "
        "cannot hold is refused",
    )


class _Wanted(NamedTuple):
    """Kind of FMU to write."""

    flavour: str
    fmi: int


class _ExportedHoist(NamedTuple):
    """Hoist to export."""

    case: Case
    ropes: tuple[OneRope, ...]  # where they differ
    trajectory: Trajectory | None  # of a controller that plans one


def _export(options: argparse.Namespace) -> int:
    wanted = _wanted(options)
    _require_meant(options, wanted)
    paths = _paths(options.out, options.hoist, wanted)
    set_values = _set_values(find_case(options.hoist), options)
    hoist = _hoist(options, set_values)
    groups = ALL if "all" in options.outputs else tuple(options.outputs)
    platforms = [*(options.platform or available_platforms())]
    if "host" in platforms:
        platforms = [host_platform() if name == "host" else name for name in platforms]
    rows = [("file", "flavour", "FMI", "platforms", "size")]
    for kind, path in zip(wanted, paths, strict=True):
        fmu = RopeFmu(
            kind.flavour,
            kind.fmi,
            level=options.level or hoist.case.level,
            platforms=platforms,
            profile=Profile(groups, arrays=not options.scalar),
            identifier=options.model_identifier,
        )
        if options.ssp:
            ssp = _export_system(path.with_suffix(".ssp"), hoist, fmu, options, set_values)
            contents = f"{fmu.flavour} rope, native drive"
            if hoist.ropes:
                contents = f"{len(hoist.ropes)} {fmu.flavour} ropes, native drive"
            rows.append((str(ssp), contents, f"{fmu.fmi}.0", "", _size(ssp)))
        if not hoist.ropes:
            export_rope(path, hoist.case, hoist.case.rope, fmu)
            rows.append((str(path), fmu.flavour, f"{fmu.fmi}.0", ", ".join(platforms), _size(path)))
    print("\n".join(aligned_table(rows)))
    if not options.platform:
        missing = missing_platforms()
        if missing:
            print(f"left out: {missing}")
    return 0


def _wanted(options: argparse.Namespace) -> list[_Wanted]:
    """Return the kinds of FMU to write: native ones, unless the Python flavour alone is chosen."""
    wanted: list[_Wanted] = []
    if options.python:
        if 2 not in options.fmi:
            raise ValueError(
                "the Python flavour is FMI 2.0 only: leave out --python, for FMI 3.0 is native"
            )
        wanted.append(_Wanted(PYTHON, 2))
    if options.native or not options.python:
        wanted += [_Wanted(NATIVE, fmi) for fmi in options.fmi]
    return wanted


def _require_meant(options: argparse.Namespace, wanted: Sequence[_Wanted]) -> None:
    """Refuse options that contradict each other."""
    if options.scalar and _Wanted(NATIVE, 3) not in wanted:
        raise ValueError("--scalar is for FMI 3.0, and FMI 2.0 has no arrays: add --native --fmi 3")
    if options.without and not options.ssp:
        raise ValueError(f"--without {options.without[0]} is for systems: add --ssp")
    if options.model_identifier != MODEL and (options.ssp or _Wanted(PYTHON, 2) in wanted):
        raise ValueError(
            f"--model-identifier {options.model_identifier} is for one native FMU: leave out "
            "--python and --ssp, whose FMUs have identifiers of their own"
        )
    if options.out is not None and options.out.suffix.lower() == ".ssp" and not options.ssp:
        raise ValueError(
            f"--out {options.out} is a system: add --ssp, or give {options.out.with_suffix('.fmu')}"
        )


def _export_system(
    path: Path,
    hoist: _ExportedHoist,
    fmu: RopeFmu,
    options: argparse.Namespace,
    set_values: Mapping[str, Any],
) -> Path:
    """Write the system of drive and ropes, and return its path."""
    system = SystemOptions(
        without=options.without,
        trajectory=hoist.trajectory,
        version=options.ssp_version,
        data=_data(hoist.case, options.hoist, set_values),
    )
    with tempfile.TemporaryDirectory() as folder:
        exported = export_hoist(Path(folder), hoist.case, hoist.ropes, fmu, system)
        write_bytes(path, exported.system.read_bytes())
    return path


def _data(case: Case, name: str, set_values: Mapping[str, Any]) -> list[SystemNumber]:
    """Return the hoist's data with their statuses; ``set_values`` replace those of its file."""
    from hoist_demo.run.complete_file import hoist_provenance
    from hoist_demo.run.provenance import SETTING

    rows = hoist_provenance(case, name, set_values)
    return [SystemNumber(*row) for row in rows if row.status != SETTING]


def _size(path: Path) -> str:
    return f"{path.stat().st_size / 1e6:.2f} MB"


#: Sections of a hoist's file that neither drive nor rope of a system takes.
_HOST_SECTIONS = ("coupling.", "arrival.")


def _set_values(case: Case, options: argparse.Namespace) -> dict[str, Any]:
    """Return the values of --rope and --set; those of the hoist change the drive of a system."""
    path = options.rope
    if path is None and not options.set:
        return {}
    set_here = settings(options.set, parameters())
    of_host = [key for key in set_here if key not in rope_parameters()]
    for key in of_host:
        if not options.ssp:
            raise ValueError(
                f"--set {key}: the FMU has the rope alone: add --ssp, which exports the drive, too"
            )
        if key.startswith(_HOST_SECTIONS):
            raise ValueError(
                f"--set {key}: a system leaves this to its master: give it to wind, or to a study"
            )
    if case.distinct_ropes:
        if path is not None or len(of_host) < len(set_here):
            raise ValueError(
                "--rope and --set of a rope's value are for one rope: give them to a [[rope]] of "
                f"{options.hoist}"
            )
        return set_here
    from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene

    values: dict[str, Any] = dict(set_here)
    if path is not None:
        values = {**read(path, RopeFile).values(), **set_here}
    of_rope = {key: value for key, value in values_of(values).items() if key in rope_parameters()}
    # report errors of the rope in its own names, not in the hoist's
    rope_scene({**case.rope, **of_rope})
    return values


def _paths(out: Path | None, hoist: str, wanted: Sequence[_Wanted]) -> list[Path]:
    """Return the path of each of ``wanted`` under --out; its folder exists and can be written to.

    A system is beside its rope, with the suffix .ssp.
    """
    ending = "" if out is None else out.suffix.lower()
    if out is not None and len(wanted) == 1 and ending and not out.is_dir():
        if ending not in (".fmu", ".ssp"):
            raise ValueError(
                f"--out {out} must end in .fmu or name a folder: give {out.with_suffix('.fmu')}"
            )
        paths = [out.with_suffix(".fmu") if ending == ".ssp" else out]
    elif ending in (".fmu", ".ssp"):
        raise ValueError(
            f"--out {out} names one file, and {len(wanted)} are written: give a folder"
        )
    else:
        paths = [(out or BUILD) / fmu_name(hoist, NAMES[one]) for one in wanted]
    results_folder(paths[0].parent)
    return paths


def _hoist(options: argparse.Namespace, set_values: Mapping[str, Any]) -> _ExportedHoist:
    """Return the hoist to export with the values that are set."""
    case = case_with_values(find_case(options.hoist), set_values)
    for remark in case.remarks:
        print(f"balance-rope: {remark}", file=sys.stderr)
    if case.distinct_ropes and not options.ssp:
        raise ValueError(f"{options.hoist} has several ropes, and an FMU has one: add --ssp")
    # slow imports
    from hoist_demo.design.controllers import design_drive
    from hoist_demo.run.data import build_single_trip
    from hoist_demo.run.ropes import ropes_of

    run = build_single_trip(options.hoist, set_values)
    trajectory = None
    if options.ssp and run.controller != CONTROLLER.start:
        undelayed = replace(run, winding=replace(run.winding, start_delay=0.0))
        drive = design_drive(undelayed)
        case = replace(case, gains=drive.gains)
        trajectory = drive.trajectory
    if not case.distinct_ropes:
        return _ExportedHoist(case, (), trajectory)
    ropes = ropes_of(case, run, {}, options.level or case.level)
    return _ExportedHoist(replace(case, hoist=ropes.hoist), ropes.ropes, trajectory)
