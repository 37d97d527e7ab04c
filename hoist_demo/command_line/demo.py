"""The command `balance-rope demo`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hoist_demo.cases.scenarios import SCENARIOS
from hoist_demo.cases.table import NAMED, find_case
from hoist_demo.command_line.demo_results import WoundRun, missing_outputs, write
from hoist_demo.command_line.options import KERNELS, add_data, add_trip, rope_values, settings
from hoist_demo.command_line.results import Commands, add_command, interruption, named, results_folder
from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.drive_signals import DRIVE_UNITS
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.fmu_description import read_outputs, read_parameters
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.participants.rope_data import Levels, RopeData
from hoist_demo.cosimulation.progress import listen, progress_bar
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.cosimulation.schemes.catalogue import SCHEMES
from hoist_demo.cosimulation.schemes.interface import ADDED_MASSES
from hoist_demo.parameters import ASSUMED_DATA, Coupling
from hoist_demo.parameters.quantity import Parameter, Value
from hoist_demo.recording.fidelity import mask_neglected
from hoist_demo.recording.passages import without_absent
from hoist_demo.recording.time_series import match_signals
from hoist_demo.report.rows import CAUSE, WARNING, render
from hoist_demo.study.slip import slip_warning
from hoist_demo.files.catalogue import Catalogue, with_values
from hoist_demo.study.provenance import of_host, of_rope
from hoist_demo.study.reading import GIVEN, file_statuses
from hoist_demo.study.run import Probe, RunData, build_trip, contradictions, fmu_part, tail_rope

if TYPE_CHECKING:
    from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope

LAST_GOOD = "last_good.npz"  #: File in the output folder with the last good state of a run that stopped.

_CASE = "rope-120"

#: Of --quick; what goes wrong in a scenario does so later, so that its trip is left as it is.
_QUICK = {"travel": 10.0, "settle": 2.0}

_DEMO_DESCRIPTION = """\
Wind once and write to --out: signals.csv (all signals with units), shapes.csv (the rope at several instants),
exposure.csv and spectra.csv (what each place in the rope went through), data.csv (where each number comes from), PNG
figures, report.md, and report.html: the rope in motion and linked plots in one file for any browser, offline.
The summary table is printed at the end."""

_DEMO_EPILOG = """\
examples:
  balance-rope demo --speed 4 --travel 60
  balance-rope demo --case rope-240             240 m rope, swivels released at 20 s
  balance-rope demo --case monopol-1000         a hoist of installed size: 1000 m, 16 m/s
  balance-rope demo --case slack-rope           what goes wrong, also overwind, seized-swivel, caught-rope,
                                                jammed-conveyance
  balance-rope demo --case monopol-1000 --estop-at 40 --estop-law two-stage    stopped by its brake
  balance-rope demo --travel -90                 lower the left conveyance instead
  balance-rope demo --creep-distance 3           the last 3 m at creep speed, 0.5 m/s
  balance-rope demo --estop-at 12                emergency stop at 5 m/s^2 near full speed
  balance-rope demo --step 0.005 --out out/fine  a finer coupling, to see whether the results change
  balance-rope demo --scheme iterative-secant    each exchange iterated to convergence
  balance-rope demo --set rope.EI=450 --set hoist.payload_left=4000    other data
  balance-rope demo --rope out/identify/example/rope.toml              a rope that was identified
  balance-rope demo --signals left.fy right.fy "loop.*"    these columns of signals.csv only
  balance-rope demo --resume out/demo/last_good.npz  go on with a run that was interrupted or stopped

exit code: 0 wound to the end, 1 the rope or the drive stopped the run (the cause is printed and what was recorded
is written all the same), 2 wrong arguments, 130 interrupted while the results were written.
"""


def add_demo(commands: Commands, fmu: Path, levels: Callable[[], Levels] = dict) -> None:
    """Add the subcommand `demo`; `levels` name a rope's accuracy."""
    about = "wind once and write figures, CSV and a report"
    demo = add_command(commands, "demo", partial(_demo, levels=levels), about, _DEMO_DESCRIPTION, _DEMO_EPILOG)
    demo.add_argument(
        "--case",
        choices=tuple(NAMED),
        metavar="NAME",
        help=f"hoist, winding and rope, see docs/howto/hoist.md: {', '.join(NAMED)} ({_CASE}, or that of --resume)",
    )
    rope = demo.add_mutually_exclusive_group()
    rope.add_argument("--fmu", type=Path, default=fmu, metavar="PATH", help="the rope, FMI 2.0 or 3.0 (%(default)s)")
    rope.add_argument("--in-process", action="store_true", help="run the rope in this process, without the FMU")
    demo.add_argument("--out", type=named, default=Path("out/demo"), metavar="DIR", help="results (%(default)s)")
    demo.add_argument("--step", type=float, default=Coupling().step, metavar="H", help="communication step [s] (0.01)")
    demo.add_argument(
        "--scheme",
        choices=tuple(SCHEMES),
        default=Coupling().scheme,
        metavar="NAME",
        help=f"how drive and rope exchange, see docs/howto/hoist.md: {', '.join(SCHEMES)} (%(default)s)",
    )
    demo.add_argument("--resume", type=Path, metavar="FILE", help="go on from the last_good.npz of a run that stopped")
    add_trip(demo)
    add_data(demo)
    demo.add_argument(
        "--quick",
        action="store_true",
        help="10 m of travel, but of a case in which something goes wrong all of it, and 2 s of settling: a check, "
        "not a result",
    )


def _demo(options: argparse.Namespace, levels: Callable[[], Levels]) -> int:
    resume = Checkpoint.read(options.resume) if options.resume else None
    catalogue = Catalogue(_parameters(options))
    own = settings(options.set, catalogue)
    identified = rope_values(options.rope, catalogue)
    chosen = {f"hoist.{field}": value for field, value in tail_rope(identified).items()} | identified | own
    hoist_values = {name.removeprefix("hoist."): v for name, v in chosen.items() if name.startswith("hoist.")}
    options.case = _case_of(resume, options.case, hoist_values) if resume else options.case or _CASE
    run = build_trip(options.case, _winding(options) | chosen)
    results_folder(options.out)
    rope, signals = _rope(options, run, bool(fmu_part(chosen)))
    missing = missing_outputs(rope.units())
    _tell(missing)
    try:
        with listen("hoist_demo") as said:
            result = _run(Host(rope, run.hoist, run.winding, run.coupling, run.gains), options.out / LAST_GOOD, resume)
        data = rope.data()
    finally:
        rope.close()
    result = replace(result, recording=without_absent(mask_neglected(result.recording, data.torque_free)))
    run = replace(run, winding=result.winding)
    contradiction = contradictions(run.hoist, data.parameters)
    for text in (contradiction, slip_warning(result.recording, run.hoist, run.winding)):
        _tell(text)
    given = (file_statuses(options.rope) if options.rope else {}) | dict.fromkeys(own, GIVEN)
    known = [*of_host(run, given), *of_rope(find_case(options.case), data, given)]
    warned = [*filter(None, (missing, contradiction)), *said]
    wound = WoundRun(_title(options, run, data), run, result, data, data.level(levels()), known, warned)
    before = set(options.out.iterdir())
    with interruption(f"the run is over, its results are being written to {options.out}") as interrupted:
        written = write(wound, options.out, signals)
    print(f"{wound.title}\n")
    # warnings have been told when they arose, and the cause is told last
    print(render([row for row in wound.rows if row.quantity not in (WARNING, CAUSE)]))
    print(f"\n{ASSUMED_DATA}\n")
    print("written: " + ", ".join(str(path) for path in written))
    if replaced := before.intersection(written):
        names = ", ".join(sorted(path.name for path in replaced))
        print(f"replaced in {options.out}: {names} of an earlier run; --out DIR keeps runs apart")
    print(f"open in a browser: {written[-1]}")
    if not result.completed:
        print(f"balance-rope: stopped: {result.cause}", file=sys.stderr)
        if result.saved is not None:
            print(f"balance-rope: the last good state is in {result.saved}; see --resume", file=sys.stderr)
        return 1
    return 130 if interrupted() else 0


def _tell(warning: str) -> None:
    if warning:
        print(f"balance-rope: {warning}", file=sys.stderr)


def _case_of(resume: Checkpoint, asked: str | None, hoist: Mapping[str, Value]) -> str:
    """Return the case of an interrupted run, found by its hoist; `hoist` is what is set of it."""
    hoists = {name: with_values(case.hoist, hoist) for name, case in NAMED.items()}
    fitting = [name for name, data in hoists.items() if resume.data.startswith(f"({data!r},")]
    found = asked if asked in fitting else next(iter(fitting), None)
    if found is None:
        raise ValueError(
            "the run to go on with is of no case's hoist: repeat its --set hoist..., or go on with it where it was "
            "begun"
        )
    if asked not in (None, found):
        raise ValueError(f"--case {asked} must be {found}, that of the run to go on with: leave it out")
    return found


def _winding(options: argparse.Namespace) -> dict[str, Value]:
    """Trip and coupling by the names of a study; values given by hand count more than --quick."""
    if options.estop_law and options.estop_at is None:
        raise ValueError(f"--estop-law {options.estop_law} needs the time of the stop: give --estop-at T")
    chosen = {
        "travel": options.travel,
        "speed": options.speed,
        "creep_distance": options.creep_distance,
        "creep_speed": options.creep_speed,
        "emergency_at": options.estop_at,
        "emergency_law": options.estop_law,
    }
    given: dict[str, Any] = {name: value for name, value in chosen.items() if value is not None}
    quick = dict[str, float]()
    if options.quick:
        quick = {"settle": _QUICK["settle"]} if options.case in SCENARIOS else _QUICK
    winding = replace(find_case(options.case).winding, **(quick | given))
    if options.creep_speed is not None and not winding.creeps:
        raise ValueError(f"--creep-speed {options.creep_speed:g} needs a creep's length: give --creep-distance S")
    values = {f"winding.{name}": value for name, value in (quick | given).items()}
    return values | {"coupling.step": options.step, "coupling.scheme": options.scheme}


def _parameters(options: argparse.Namespace) -> dict[str, Parameter]:
    if options.in_process:
        from hoist_demo.cosimulation.participants.inprocess_rope import rope_parameters

        return rope_parameters()
    if not options.fmu.is_file():
        raise ValueError(
            f"FMU '{options.fmu}' is missing: export it with `balance-rope export --outputs all`, "
            "give another file with --fmu, or run with --in-process"
        )
    return read_parameters(options.fmu)


def _rope(options: argparse.Namespace, run: RunData, asked: bool) -> tuple[FmuRope | InProcessRope, tuple[str, ...]]:
    """The rope, and the signals to write (none: the usual); an FMU is `asked` whether it takes its parameters."""
    rope: FmuRope | InProcessRope
    if options.in_process:
        # only this plant needs rope_model; the FMU brings its own
        from hoist_demo.cosimulation.participants.inprocess_rope import rope_in_process

        rope = rope_in_process(options.case, options.kernels, options.level or "standard", run.fmu)
        return rope, match_signals(options.signals, [*DRIVE_UNITS, *rope.units()])
    if options.level:
        raise ValueError(
            f"--level {options.level} is for --in-process; an FMU has the level of its export: "
            f"`balance-rope export --level {options.level}`"
        )
    outputs = read_outputs(options.fmu)
    signals = match_signals(options.signals, [*DRIVE_UNITS, *outputs])
    if asked and (problems := Probe(options.fmu).rejection(run)):
        raise ValueError("; ".join(problems))
    kernels = {} if options.kernels == "auto" else {"solver.kernels": KERNELS.index(options.kernels)}
    recorded = ({*outputs} - {*ADDED_MASSES}).union(signals)  # of which those are dear
    return FmuRope(options.fmu, {**kernels, **run.fmu}, recorded), signals


def _run(host: Host, save_to: Path, resume: Checkpoint | None) -> Result:
    """The run under a progress bar, until it is interrupted."""
    with interruption() as interrupted, progress_bar() as progress:
        return host.run(lambda fraction, t: progress(fraction, t) and not interrupted(), save_to, resume)


def _title(options: argparse.Namespace, run: RunData, rope: RopeData) -> str:
    kind = "in process" if options.in_process else f"in the FMU {options.fmu.name}, FMI {rope.model['FMI version']}"
    at = run.winding.emergency_at
    stop = "" if at is None else f", emergency stop at {at:g} s"
    trip = f"Winding {run.winding.travel:g} m{stop}: case {options.case}, balance rope {kind}"
    return ", ".join([trip, *options.set])
