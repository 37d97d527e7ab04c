"""The command ``balance-rope wind``, also called ``demo``."""

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from hoist_demo.cases.case import BUILTIN_HOISTS, DEFAULT_HOIST, SCENARIOS, Case
from hoist_demo.cases.table import DEFAULT_FMU, find_case
from hoist_demo.command_line.options import TRIP, add_data, add_trip, settings
from hoist_demo.command_line.run_results import (
    REPORT,
    WoundRun,
    missing_outputs,
    report_of,
    write_reports,
    write_tables,
)
from hoist_demo.command_line.support import (
    CHECKED,
    HOIST_UNCHECKED,
    INTERRUPTED,
    describe,
    interruption,
    nonempty_path,
    results_folder,
)
from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.drive_signals import DRIVE_UNITS
from hoist_demo.cosimulation.participants.fmu_description import read_outputs, read_parameters
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.progress import progress_bar, warnings_of
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.cosimulation.schemes.catalogue import SCHEMES
from hoist_demo.cosimulation.schemes.interface import ADDED_MASSES
from hoist_demo.design.controllers import design_drive
from hoist_demo.files.reading import read
from hoist_demo.files.registry import parameters
from hoist_demo.files.rope_file import RopeFile
from hoist_demo.files.values import GIVEN
from hoist_demo.parameters import ASSUMED_DATA
from hoist_demo.parameters.quantity import FileParameter, Value
from hoist_demo.recording.ropes import computed
from hoist_demo.recording.time_series import match_signals
from hoist_demo.report.rows import Report, SummaryRow, render, render_verdict
from hoist_demo.run.data import RunData, build_single_trip, contradictions, fmu_part
from hoist_demo.run.probe import FmuProbe
from hoist_demo.run.provenance import host_provenance
from hoist_demo.run.ropes import OneRope, Ropes, ropes_of
from hoist_demo.run.wind import wind_run

#: File in the output folder with the last good state of a run that stopped.
LAST_GOOD = "last_good.npz"
#: Folder in the output folder for a run that stopped, beside results of an earlier one.
STOPPED = "stopped"
#: Trip of --quick; scenarios keep their travel, as what goes wrong in them does so later.
_QUICK = {"travel": 10.0, "settle": 2.0}

_DESCRIPTION = """\
Wind a hoist once and write to --out: signals.csv (all signals with units), shapes.csv (the rope at several instants),
exposure.csv and spectra.csv (what each place in the rope went through), data.csv (where each number comes from), PNG
figures, report.md, and report.html: the rope in motion and linked plots in one file for any browser, offline.
The verdict is printed at the end: what matters, beside its bounds; the report has all other numbers. Of several ropes
each has its tables along the rope, and its signals and rows, under its name."""

_EPILOG = """\
examples:
  balance-rope wind hoist.toml                  your hoist: balance-rope new writes the file
  balance-rope wind rope-240                    240 m rope, swivels released at 20 s
  balance-rope wind slack-rope                  what goes wrong, also overwind, seized-swivel, caught-rope,
                                                jammed-conveyance
  balance-rope wind monopol-1000 --estop-at 40 --estop-law two-stage    stopped by its brake
  balance-rope wind --step 0.005 --out out/fine  a finer coupling, to see whether the results change
  balance-rope wind --scheme iterative-secant    each exchange iterated to convergence
  balance-rope wind --set rope.EI=450 --set hoist.payload_left=4000    other data
  balance-rope wind --rope out/identify/example/rope.toml              a rope that was identified
  balance-rope wind --signals left.fy right.fy "loop.*"    these columns of signals.csv only
  balance-rope wind --resume out/wind/rope-120/last_good.npz  go on with a run that was interrupted or stopped

exit code: 0 wound to the end, 1 the rope or the drive stopped the run (the cause is printed and what was recorded
is written all the same), 2 wrong arguments, 130 interrupted (what is kept is said, and how to go on).
"""


def add_wind(wind: argparse.ArgumentParser) -> None:
    """Add description and options of the command ``wind``."""
    describe(wind, _wind_command, _DESCRIPTION, _EPILOG)
    names = f"{', '.join(BUILTIN_HOISTS)} ({DEFAULT_HOIST}, or that of --resume)"
    text = f"hoist, trip, controller, ropes: a file, or one of {names}"
    wind.add_argument("hoist", nargs="?", metavar="HOIST", help=text)
    wind.add_argument("--case", metavar="NAME", help="the same as HOIST")
    rope = wind.add_mutually_exclusive_group()
    text = f"the rope, FMI 2.0 or 3.0 ({DEFAULT_FMU} for {DEFAULT_HOIST}, if it is there)"
    rope.add_argument("--fmu", type=Path, metavar="PATH", help=text)
    rope.add_argument(
        "--in-process", action="store_true", help="run the rope in this process, without an FMU"
    )
    wind.add_argument(
        "--out", type=nonempty_path, metavar="DIR", help="results (out/wind and the hoist's name)"
    )
    text = "check the file and its values, wind nothing; `balance-rope check` judges the hoist"
    wind.add_argument("--check", action="store_true", help=text)
    wind.add_argument(
        "--step", type=float, metavar="H", help="communication step [s] (that of the hoist)"
    )
    text = (
        f"how drive and rope exchange, see docs/howto/hoist.md: {', '.join(SCHEMES)} (that of the "
        "hoist)"
    )
    wind.add_argument("--scheme", choices=tuple(SCHEMES), metavar="NAME", help=text)
    wind.add_argument(
        "--resume",
        type=Path,
        metavar="FILE",
        help="go on from the last_good.npz of a run that stopped",
    )
    add_trip(wind)
    add_data(wind)
    wind.add_argument(
        "--quick",
        action="store_true",
        help="10 m of travel, but of a hoist in which something goes wrong all of it, and 2 s of "
        "settling: a check, not a result",
    )


class _PlannedTrip(NamedTuple):
    """Trip that the options describe, before it is wound."""

    case: Case
    run: RunData
    ropes: Ropes
    values: Mapping[str, Value]  # set by options
    statuses: Mapping[str, str]  # of the values of --rope and --set


class _Outcome(NamedTuple):
    """Trip that was wound, and whether the user has stopped it."""

    wound: WoundRun
    stopped_by_user: bool


def _wind_command(options: argparse.Namespace) -> int:
    """Plan the trip of the options, wind it, judge it, and write and print what is found."""
    resume = _choose_hoist(options)
    trip = _plan_trip(options)
    if options.check:
        print(f"{options.hoist}: {CHECKED}; {HOIST_UNCHECKED}")
        return 0
    results_folder(options.out)
    plant = trip.ropes.plant  # loads the FMU, or makes the ropes in this process
    try:
        signals = match_signals(_patterns(options, trip.case), [*DRIVE_UNITS, *plant.units()])
        outcome = _wind_planned(options, trip, resume)
    finally:
        plant.close()
    wound = outcome.wound
    result = wound.result
    out = options.out
    # the report of an earlier run is worth more than that of one that failed
    if not result.completed and (options.out / REPORT).exists():
        out = results_folder(options.out / STOPPED)
    with interruption(f"the run is over, its results are being written to {out}") as interrupted:
        tables = write_tables(wound, out, signals)
        report = report_of(wound)
        pages = write_reports(wound, report, tables, out)
    written = [*tables.paths, *tables.pictures, *pages]
    _print_report(report)
    print("written: " + ", ".join(str(path) for path in written))
    print(f"open in a browser: {written[-1]}")
    by_user = outcome.stopped_by_user or interrupted()
    if not result.completed:
        print(f"balance-rope: {_stop(result, out, by_user=by_user)}", file=sys.stderr)
    elif by_user:
        print(
            f"balance-rope: interrupted when the run was over: all its results are in {out}",
            file=sys.stderr,
        )
    if by_user:
        return INTERRUPTED
    if result.completed:
        return 0
    return 1


def _choose_hoist(options: argparse.Namespace) -> Checkpoint | None:
    """Set the hoist and the folder where they are left out; return the state to go on from."""
    if options.case is not None:
        if options.hoist is not None:
            raise ValueError(
                f"--case {options.case} and {options.hoist} are both a hoist: leave one out"
            )
        options.hoist = options.case
    resume = None
    if options.resume:
        resume = Checkpoint.read(options.resume)
        options.hoist = options.hoist or resume.hoist
    options.hoist = options.hoist or DEFAULT_HOIST
    if options.out is None:
        options.out = Path("out") / "wind" / Path(options.hoist).stem
    return resume


def _plan_trip(options: argparse.Namespace) -> _PlannedTrip:
    """Return the trip of the options."""
    case = find_case(options.hoist)
    if case.distinct_ropes and options.fmu:
        raise ValueError(
            f"--fmu {options.fmu} is for a hoist with one [[rope]]: leave it out, several run in "
            "process"
        )
    fmu = _chosen_fmu(options, DEFAULT_FMU if options.hoist == DEFAULT_HOIST else None)
    set_here = settings(options.set, parameters(_parameters_of(fmu)))
    if options.rope:
        identified = read(options.rope, RopeFile).values()
    else:
        identified = {}
    overrides = {key: entry.value for key, entry in identified.items()} | set_here
    values = _values_of_options(options, case) | overrides
    run = build_single_trip(options.hoist, values)
    for remark in case.remarks:
        print(f"balance-rope: {remark}", file=sys.stderr)
    statuses = {key: entry.status for key, entry in identified.items()}
    statuses |= dict.fromkeys(set_here, GIVEN)
    if fmu is None:
        ropes = ropes_of(case, run, overrides, options.level or case.level)
    else:
        ropes = _rope_in_fmu(options, fmu, case, run, overrides)
    return _PlannedTrip(case, run, ropes, values, statuses)


def _wind_planned(
    options: argparse.Namespace, trip: _PlannedTrip, resume: Checkpoint | None
) -> _Outcome:
    """Wind the trip under a progress bar, until the user interrupts it."""
    ropes = trip.ropes
    run = replace(trip.run, hoist=ropes.hoist)
    name = options.hoist
    if options.hoist not in BUILTIN_HOISTS:
        name = str(Path(options.hoist).resolve())
    with warnings_of("hoist_demo") as warnings:
        drive = design_drive(run)
        with interruption() as stopped_by_user, progress_bar() as bar:
            result = wind_run(
                run,
                ropes.plant,
                progress=lambda fraction, t: bar(fraction, t) and not stopped_by_user(),
                drive=drive,
                save_to=options.out / LAST_GOOD,
                resume=resume,
                name=name,
            )
    rope_data = ropes.data()
    torque_free = {rope.name: rope.torque_free for rope in rope_data}
    result = replace(result, recording=computed(result.recording, torque_free))
    run = replace(run, winding=result.winding)
    wound = WoundRun(
        title=_title(trip.case.name or options.hoist, run),
        run=run,
        result=result,
        ropes=rope_data,
        pairs=ropes.pairs(result.recording),
        provenance=[*host_provenance(run, trip.statuses), *ropes.provenance(trip.statuses)],
        warnings=[*_remarks(ropes), *warnings],
        set_names=trip.values,
    )
    return _Outcome(wound, stopped_by_user())


def _title(name: str, run: RunData) -> str:
    """Return the title of the report of a run: hoist, way, speed and emergency stop."""
    trip = run.winding
    direction = "up" if trip.travel > 0.0 else "down"
    title = (
        f"{name}: the left conveyance {abs(trip.travel):g} m {direction} at up to "
        f"{trip.speed:g} m/s"
    )
    if trip.emergency_at is not None:
        title += f", emergency stop at {run.coupling.start + trip.emergency_at:g} s"
    return title


def _print_report(report: Report) -> None:
    """Print title, verdict and changed settings, and remarks to the messages."""
    parts = [report.title, render_verdict(report.verdict)]
    group, changed = report.changed
    rows = []
    for name, value, unit, before in changed:
        quantity = f"{value} {unit}".rstrip()
        rows.append(SummaryRow(group, name, f"{quantity}, not {before}"))
    if rows:
        parts.append(render(rows))
    print("\n\n".join([*parts, ASSUMED_DATA]))
    for text in report.verdict.remarks:
        print(f"balance-rope: {text}", file=sys.stderr)


def _stop(result: Result, out: Path, *, by_user: bool) -> str:
    """Return why a run stopped, what is kept of it, and how it goes on."""
    how = "interrupted" if by_user else "stopped"
    words = f"{how}: {result.cause}; what was wound is in {out}"
    if result.saved is None:
        return f"{words}, no state is kept to go on from"
    resumed = f"the same command with --resume {result.saved} goes on"
    if by_user:
        return f"{words}; {resumed}"
    return f"{words}; the last good state is in {result.saved}: {resumed} from it"


def _remarks(ropes: Ropes) -> list[str]:
    """Return remarks on outputs that an only rope lacks, and on a rope of another hoist."""
    first = ropes.ropes[0]
    level = ropes.case.level
    on_level = ""
    if first.level != level and first.scene == replace(first, level=level).scene:
        on_level = (
            f"--level {first.level} changes nothing: leave mesh, accuracy, solver and model out of "
            "the hoist's file"
        )
    if ropes.case.distinct_ropes:
        if on_level:
            return [on_level]
        return []
    (data,) = ropes.data()
    if isinstance(ropes.plant, FmuRope) and data.level not in ("", level):
        on_level = (
            f"level = {level!r} of {ropes.case.name} is not that of the FMU, "
            f"{data.level!r}, which was wound: export one of that level, or --in-process"
        )
    outputs = missing_outputs(ropes.plant.units())
    data_of_drive = contradictions(ropes.hoist, data.parameters)
    return [*filter(None, (outputs, data_of_drive, on_level))]


def _chosen_fmu(options: argparse.Namespace, default: Path | None) -> Path | None:
    """Return the FMU that is wound: the given one, or the default where it exists.

    None stands for the rope in this process.
    """
    given: Path | None = options.fmu
    if given is not None or options.in_process or default is None:
        return given
    if default.is_file():
        return default
    cure = "`balance-rope export --outputs all` makes it"
    print(
        f"balance-rope: {default} is not there: the rope runs in this process; {cure}",
        file=sys.stderr,
    )
    return None


def _values_of_options(options: argparse.Namespace, case: Case) -> dict[str, Value]:
    """Return trip and coupling by their names in files; options given by hand override --quick."""
    if options.estop_law and options.estop_at is None:
        raise ValueError(
            f"--estop-law {options.estop_law} needs the time of the stop: give --estop-at T"
        )
    chosen = {name: getattr(options, name) for name in TRIP}
    chosen |= {"emergency_at": options.estop_at, "emergency_law": options.estop_law}
    overrides: dict[str, Any] = {name: value for name, value in chosen.items() if value is not None}
    quick: dict[str, float] = {}
    if options.quick and options.hoist in SCENARIOS:
        quick = {"settle": _QUICK["settle"]}
    elif options.quick:
        quick = _QUICK
    winding = replace(case.winding, **(quick | overrides))
    if options.creep_speed is not None and not winding.creeps:
        raise ValueError(
            f"--creep-speed {options.creep_speed:g} needs a creep's length: give --creep-distance S"
        )
    values = {f"winding.{name}": value for name, value in (quick | overrides).items()}
    coupling = {"coupling.step": options.step, "coupling.scheme": options.scheme}
    return values | {name: value for name, value in coupling.items() if value is not None}


def _parameters_of(fmu: Path | None) -> dict[str, FileParameter] | None:
    """Return the FMU's parameters, None of a rope in this process."""
    if fmu is None:
        return None
    if not fmu.is_file():
        raise ValueError(
            f"FMU '{fmu}' is missing: `balance-rope export --outputs all --out {fmu}` "
            "makes it; or give another file with --fmu, or run with --in-process"
        )
    return read_parameters(fmu)


def _rope_in_fmu(
    options: argparse.Namespace,
    fmu: Path,
    case: Case,
    run: RunData,
    overrides: Mapping[str, Value],
) -> Ropes:
    """Return the hoist's rope in an FMU, which may refuse the values of ``overrides``."""
    if options.level:
        raise ValueError(
            f"--level {options.level} is for --in-process; an FMU has the level of its export: "
            f"`balance-rope export --level {options.level}`"
        )
    outputs = read_outputs(fmu)
    shown = match_signals(_patterns(options, case), [*DRIVE_UNITS, *outputs])
    probe = FmuProbe(fmu)
    probe.require_hoist(run)
    if fmu_part(overrides):
        probe.require_start(run)
    # added masses are expensive: those that are to be shown alone
    recorded = ({*outputs} - {*ADDED_MASSES}).union(shown)
    load = partial(FmuRope, fmu, run.rope_values, recorded)
    return Ropes(case, run, (OneRope("", run.rope_values, case.level, case, fmu=load),))


def _patterns(options: argparse.Namespace, case: Case) -> Sequence[str]:
    """Return the patterns of the signals to show: those of the options, or of the hoist."""
    patterns: Sequence[str] = options.signals or case.signals
    return patterns
