"""The console command ``balance-rope``: joins the FMU's export and the hoist, which know nothing of each other."""

from __future__ import annotations

import argparse
import logging
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

try:  # NumPy and CasADi take a second to load, in which a user may change his mind
    from fmu_src.export import export_fmu
    from fmu_src.interface import variables
    from fmu_src.native.build import PLATFORMS, available_platforms, host_platform, missing_platforms
    from fmu_src.native.export import export_native
    from fmu_src.native.model_fmu import export_model
    from fmu_src.profile import ALL, DEFAULT, GROUPS, Profile
    from fmu_src.ssp import Component, export_ssp
    from hoist_demo.cases.case import Case
    from hoist_demo.cases.table import CASES, find_case
    from hoist_demo.command_line.demo import add_demo
    from hoist_demo.command_line.duty import add_duty
    from hoist_demo.command_line.identify import add_identify
    from hoist_demo.command_line.linear import add_linear
    from hoist_demo.command_line.options import rope_values, settings
    from hoist_demo.command_line.results import named, results_folder
    from hoist_demo.command_line.ropes import add_ropes
    from hoist_demo.command_line.study import add_study
    from hoist_demo.command_line.uncertain import add_uncertain
    from hoist_demo.drive_fmu.description import drive_model, duration
    from hoist_demo.drive_fmu.interface import Tail
    from hoist_demo.study.catalogue import Catalogue
    from hoist_demo.study.run import tail_rope
    from rope_model import __version__
    from rope_model.parameters import LEVELS, Level, rope_120

    if TYPE_CHECKING:
        from hoist_demo.ropes.definition import OneRope
except KeyboardInterrupt:
    print("balance-rope: interrupted", file=sys.stderr)
    sys.exit(130)

BUILD = Path("build")
#: flavour and FMI version -> file name
NAMES = {
    ("Python", 2): "balance_rope.fmu",
    ("native", 2): "balance_rope_native.fmu",
    ("native", 3): "balance_rope_native_fmi3.fmu",
}
#: name of the hoist in a system of FMUs
DRIVE = "drive"
DEFAULT_FMU = BUILD / NAMES["Python", 2]

DESCRIPTION = """\
The balance rope of a friction (Koepe) hoist, as an FMU and in a winding.

The rope hangs in a U below the two conveyances: tension, torsion and lateral motion, coupled. The drive (motor,
sheave, head ropes, conveyances) is a CasADi model that exchanges end motions and end forces with the FMU."""

EPILOG = """\
first steps:
  balance-rope export                  write the rope to build/balance_rope.fmu
  balance-rope export --outputs all    with the points along the rope that the demo draws
  balance-rope export --native --fmi 2 3    the same as C code for all platforms, without Python
  balance-rope demo                    wind 90 m with it; figures, CSV and a report in out/demo
  balance-rope demo --quick            wind 10 m only, to see that all is in place
  balance-rope demo --in-process       the same rope without the FMU
  balance-rope study STUDY.toml        wind many times, with parameters over grids, samples or a search
  balance-rope duty SCHEDULE.toml      wind many trips as one run, each from where the last has left the rope
  balance-rope ropes ROPES.toml        wind several balance ropes that differ, in one hoist
  balance-rope identify MEASURED.toml  find the rope's properties from measurements
  balance-rope uncertain SCENE.toml    wind with all that is not known of the rope: spread, and what causes it
  balance-rope modes                   frequencies and damping of hoist and rope along the trip
  balance-rope linearise               linear models for controller design
  balance-rope COMMAND --help          what a command can do
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit code."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("balance-rope", description=DESCRIPTION, epilog=EPILOG, formatter_class=raw)
    parser.add_argument("--version", action="version", version=f"balance-rope {__version__}")
    parser.add_argument("-v", "--verbose", action="store_true", help="log what the solver does")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_export(commands)
    add_demo(commands, DEFAULT_FMU, _levels)
    add_study(commands)
    add_duty(commands)
    add_ropes(commands)
    add_identify(commands)
    add_uncertain(commands)
    add_linear(commands)
    for command in commands.choices.values():  # -v is understood behind the command as well
        command.add_argument(
            "-v", "--verbose", action="store_true", default=argparse.SUPPRESS, help="log what the solver does"
        )
    options = parser.parse_args(arguments)
    level = logging.INFO if options.verbose else logging.WARNING
    logging.basicConfig(level=level, format=f"{'%(name)s' if options.verbose else 'balance-rope'}: %(message)s")
    try:
        code: int = options.run(options)
        return code
    except KeyboardInterrupt:
        print("balance-rope: interrupted", file=sys.stderr)
        return 130
    except (ValueError, RuntimeError, OSError) as error:
        print(f"balance-rope: {error}", file=sys.stderr)
        return 2


def _add_export(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    export = commands.add_parser(
        "export",
        help="write the rope as an FMU",
        description="Export the balance rope as a co-simulation FMU. The Python flavour (FMI 2.0) needs Python with "
        "numpy and casadi on the importing host; the native flavour (FMI 2.0 or 3.0) is self-contained C and needs "
        "nothing. Both have the same variables, and the same C code answers the tool; every parameter can still be set "
        "before initialisation. An installed wheel brings the libraries; in a checkout the first export compiles, with "
        "a C compiler or ziglang, some 10 s per platform, a second version of FMI some more; "
        "--platform host makes it short.",
    )
    export.add_argument("--python", action="store_true", help="the Python flavour (the default)")
    export.add_argument("--native", action="store_true", help="the native flavour")
    export.add_argument("--fmi", type=int, nargs="+", choices=(2, 3), default=[2], help="version of FMI (2)")
    export.add_argument(
        "--platform",
        nargs="+",
        choices=("host", *PLATFORMS),
        metavar="NAME",
        help=f"platforms of the libraries: host, {', '.join(PLATFORMS)} (all that can be built here)",
    )
    export.add_argument(
        "--case",
        choices=tuple(CASES),
        default="rope-120",
        metavar="NAME",
        help=f"start values: the rope of {', '.join(CASES)}, see docs/howto/hoist.md (%(default)s)",
    )
    export.add_argument(
        "--rope", type=Path, metavar="FILE", help="start values of the rope, as balance-rope identify writes them"
    )
    export.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="start value of a parameter by its name in docs/reference/variables.md, in SI units; may be repeated, and "
        "overrides --case and --rope",
    )
    export.add_argument(
        "--level",
        choices=tuple(LEVELS),
        default="standard",
        help="accuracy against speed, see docs/howto/accuracy.md (%(default)s)",
    )
    export.add_argument(
        "--outputs",
        nargs="+",
        choices=("all", *GROUPS),
        default=list(DEFAULT),
        metavar="GROUP",
        help=f"outputs that the FMU shows: all, or groups of {', '.join(GROUPS)} (all but shape and "
        "station, points along the rope and places in it, which the demo's report draws)",
    )
    export.add_argument(
        "--scalar", action="store_true", help="FMI 3.0 without arrays: each element a variable, for tools without them"
    )
    export.add_argument(
        "--ssp", action="store_true", help="also hoist drive and rope as one system, an .ssp beside the .fmu"
    )
    export.add_argument(
        "--ropes",
        type=Path,
        metavar="FILE.toml",
        help="of the system: these ropes, trip and hoist instead of the case's one rope, see docs/reference/files.md",
    )
    export.add_argument(
        "--out",
        type=named,
        help=f"the .fmu to write; a folder where there is one, or several are written ({BUILD}/...)",
    )
    export.set_defaults(run=_export)


def _levels() -> dict[str, dict[str, float]]:
    """By what a report tells the level of a rope: numbers and choices of mesh, solver and model, by FMI name."""
    numbers = dict[str, dict[str, float]]()
    for level in LEVELS:
        table = [v for v in variables(rope_120(level)) if v.causality == "parameter"]
        numbers[level] = {
            v.name: v.start
            for v in table
            if (isinstance(v.start, float) and v.name.startswith(("mesh.", "solver.", "model.")))
            or (isinstance(v.start, int) and v.name in ("mesh.kind", "model.fidelity"))
        }
    return numbers


def _export(options: argparse.Namespace) -> int:
    wanted = [("native", fmi) for fmi in options.fmi] if options.native else []
    if options.python or not options.native:
        if 2 not in options.fmi:
            raise ValueError("the Python flavour is FMI 2.0 only; FMI 3.0 comes with --native")
        wanted.insert(0, ("Python", 2))
    if options.scalar and ("native", 3) not in wanted:
        raise ValueError("--scalar is for FMI 3.0, and FMI 2.0 has no arrays: add --native --fmi 3")
    if options.ropes and not options.ssp:
        raise ValueError(f"--ropes {options.ropes} is for systems, and an FMU has one rope: add --ssp")
    paths = _paths(options.out, wanted)
    case, level, ropes = _hoist(options)
    start = {**case.rope, "right.y": abs(case.winding.travel)}
    groups = ALL if "all" in options.outputs else tuple(options.outputs)
    profile = Profile(groups, arrays=not options.scalar, stop=duration(case.winding))
    asked = [host_platform() if name == "host" else name for name in options.platform or available_platforms()]
    rows = [("file", "flavour", "FMI", "platforms", "size")]
    for (flavour, fmi), path in zip(wanted, paths, strict=True):
        if flavour == "native":
            export_native(path, level=level, fmi=fmi, platforms=asked, start=start, profile=profile)
        else:
            export_fmu(path, level=level, start=start, profile=profile, platforms=asked)
        rows.append((str(path), flavour, f"{fmi}.0", ", ".join(asked), f"{path.stat().st_size / 1e6:.2f} MB"))
        if options.ssp:
            ssp = _system(path, case, ropes, asked, fmi)
            what = f"{len(ropes)} {flavour} ropes, native drive" if ropes else f"{flavour} rope, native drive"
            rows.append((str(ssp), what, f"{fmi}.0", "", f"{ssp.stat().st_size / 1e6:.2f} MB"))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
    if (options.native or options.ssp) and not options.platform and (missing := missing_platforms()):
        print(f"left out: {missing}")
    return 0


def _with_rope(case: Case, path: Path | None, texts: Sequence[str]) -> Case:
    """The case with the rope of a parameter file and of --set, for which its drive takes it."""
    if path is None and not texts:
        return case
    from hoist_demo.cosimulation.participants.inprocess_rope import rope_data, rope_parameters

    parameters = rope_parameters()
    catalogue = Catalogue(parameters)
    own = {**rope_values(path, catalogue), **settings(texts, catalogue)}
    if others := sorted(own.keys() - parameters.keys()):
        raise ValueError(f"--set {others[0]}: the FMU has the rope alone: give it to demo, or to a study or a duty")
    rope_data({**case.rope, **own})  # what is wrong with the rope is told in its own names, not in the hoist's
    shared: dict[str, Any] = tail_rope(own)
    return replace(case, rope={**case.rope, **own}, hoist=replace(case.hoist, **shared))


def _paths(out: Path | None, wanted: Sequence[tuple[str, int]]) -> list[Path]:
    """Where each of ``wanted`` goes, --out being ``out``; its folder is there and can be written to."""
    if out is not None and len(wanted) == 1 and not out.is_dir():
        if out.suffix.lower() != ".fmu":
            raise ValueError(
                f"--out {out} must end in .fmu or be a folder that is there: give {out.with_suffix('.fmu')}"
            )
        paths = [out]
    elif out is not None and out.suffix == ".fmu":
        raise ValueError(f"--out {out} names one file, and {len(wanted)} are written: give a folder")
    else:
        paths = [(out or BUILD) / NAMES[one] for one in wanted]
    results_folder(paths[0].parent)
    return paths


def _hoist(options: argparse.Namespace) -> tuple[Case, Level, tuple[OneRope, ...]]:
    """The case to export, the level of its rope, and its ropes where a file has several."""
    if options.ropes is None:
        return _with_rope(CASES[options.case], options.rope, options.set), options.level, ()
    if options.rope is not None:
        raise ValueError(f'--rope {options.rope} is one rope: in {options.ropes} give a rope from = "{options.rope}"')
    if options.set:
        raise ValueError(f"--set {options.set[0]} is for one rope: give it to a rope of {options.ropes}")
    # a file of ropes is read with what winds them, which loads slowly
    from hoist_demo.cosimulation.participants.inprocess_rope import rope_parameters
    from hoist_demo.ropes.definition import read_ropes

    file = read_ropes(options.ropes, rope_parameters())
    if broken := [rope.name for rope in file.ropes if rope.breaks]:
        raise ValueError(f"breaks_at of {', '.join(broken)} must be left out: the rope of an FMU does not break")
    if len(file.ropes) > 1 and file.touching:
        told = "contact.rope_stiffness lets each rope of the system press itself alone: FMUs know no neighbours"
        print(f"balance-rope: {told}; `balance-rope ropes {options.ropes}` has their contact", file=sys.stderr)
    case = replace(find_case(file.case), hoist=file.hoist, winding=file.run.winding, gains=file.run.gains)
    return case, file.level, file.ropes


def _system(rope: Path, case: Case, ropes: Sequence[OneRope], platforms: Sequence[str], fmi: int) -> Path:
    """The FMU of the rope, or of each of several, and the case's drive as one system: ``rope`` with the ending .ssp."""
    tails = [Tail(one.name, one.scene.rope.mass_per_length, one.scene.rope.length) for one in ropes]
    drive = drive_model(case, tails)
    kinds = {v.name: v.kind for v in variables(rope_120())}
    with tempfile.TemporaryDirectory() as folder:
        fmu = export_model(Path(folder) / "drive.fmu", drive, platforms, fmi)
        components = [Component(DRIVE, fmu, {})]
        for name, values in [(one.name, one.parameters) for one in ropes] or [("rope", {})]:
            typed = {key: float(x) if kinds[key] == "Real" else x for key, x in values.items()}
            # drive and rope step at the same time: the rope extrapolates the motion
            components.append(Component(name, rope, {**typed, "inputs_at_step_end": False}))
        name, text = "FrictionHoist", drive.description
        return export_ssp(rope.with_suffix(".ssp"), name, components, drive.duration, 0.01, text)


if __name__ == "__main__":
    sys.exit(main())
