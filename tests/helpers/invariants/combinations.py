"""Hoist files by pairs of choices, and the relations between the commands that take them.

A covering array (allpairspy) has every pair of choices of two factors in at least one row. Every
row is a hoist's file and one way to use it. The trip is wound first, by ``wind`` in process; what
another command gives must then be the same trip. A row that cannot be is refused in one sentence.
There is no third outcome.
"""

from __future__ import annotations

import math
import random
import traceback
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np
import pandas as pd
import pytest
from allpairspy import AllPairs

from hoist_demo.command_line import wind as wind_command
from hoist_demo.command_line.main import main
from hoist_demo.parameters.trip_design import CONTROLLERS

GRAVITY = 9.81
REFUSED = 2  # exit code
STOPPED = 1  # exit code
INTERRUPTED = 130  # exit code
#: Beginnings of the names of signals that every run computes.
COMPUTED = ("time", "conveyance.", "drive.", "reference.")

#: A factor and some of its choices.
Choices = tuple[str, tuple[str, ...]]

#: Factor -> choice -> lines above [[rope]]. The first choice of a factor is the default.
HOIST_LINES: dict[str, dict[str, str]] = {
    "level": {"standard": "", "draft": 'level = "draft"'},
    "fidelity": {
        "auto": "",
        "torsional": 'model.fidelity = "torsional"',
        "spatial": 'model.fidelity = "spatial"',
        "planar": 'model.fidelity = "planar"',
        "rigid": 'model.fidelity = "rigid"',
    },
    "direction": {"up": "winding.travel = 6.0", "down": "winding.travel = -6.0"},
    "stop": {
        "none": "",
        "drive": "winding.emergency_at = 3.0",
        "deceleration": 'winding.emergency_at = 3.0\nwinding.emergency_law = "deceleration"',
        "torque": 'winding.emergency_at = 3.0\nwinding.emergency_law = "torque"',
        "two-stage": 'winding.emergency_at = 3.0\nwinding.emergency_law = "two-stage"',
    },
    "controller": {name: f'controller = "{name}"' for name in CONTROLLERS},
    # one scheme of each class and accelerator
    "scheme": {
        name: f'coupling.scheme = "{name}"'
        for name in (
            "gauss-seidel-1",
            "jacobi-0",
            "semi-implicit-2",
            "impulse-preserving",
            "iterative-aitken",
            "iterative-secant",
            "implicit-impulse",
            "energy-controlled",
        )
    },
    "steps": {
        "10 ms": "",
        "20 ms, sampled at 10 ms": "coupling.step = 0.02\ncoupling.sample = 0.01",
        "5 ms, sampled at 20 ms": "coupling.step = 0.005\ncoupling.sample = 0.02",
    },
    "drive": {
        "plain": "",
        "elastic shaft": "hoist.drive_shaft.stiffness = 2e8",
        "head rope modes": "hoist.head_rope_modes = 2",
        "lining": "hoist.lining.sliding = 0.8",
        "play": "hoist.play.clearance = 0.005",
        "guides": "hoist.guides.coulomb = 1000.0",
    },
    "brake": {
        "none": "",
        "strong": "hoist.brake.torque = 5.5e5",
        "weak": "hoist.brake.torque = 4e4",
    },
    "payload": {
        "left": "",
        "right": "hoist.payload_left = 0.0\nhoist.payload_right = 5000.0",
        "none": "hoist.payload_left = 0.0",
    },
    "bodies": {
        "none": "",
        "divider": "divider_1.size = 0.2\ndivider_1.y = -12.5",
        "sump": "sump.level = -18.0",
    },
    "guard": {"none": "", "far": "guard.turns = 0.4", "near": "guard.torque = 0.5"},
    "air": {"none": "", "still": "air.density = 1.2", "wind": "air.density = 1.2\nair.vx = 3.0"},
    "contact": {"none": "", "of the rope with itself": "contact.rope_stiffness = 1e7"},
}

#: Factor -> choice -> lines in a [[rope]].
ROPE_LINES: dict[str, dict[str, str]] = {
    "swivels": {
        "locked": "",
        "free": 'swivels.mode = "free"',
        "coulomb": 'swivels.mode = "coulomb"',
        "dirty": 'swivels.mode = "coulomb"\nswivels.mu_static = 0.1\nswivels.mu_kinetic = 0.08',
    },
    "material": {
        "plain": "",
        "curved": "curvature_middle = 0.05",
        "wires": "EI_stick = 1200.0\nslip_moment = 20.0",
        "catalogue": 'construction = "34x7"\ndiameter = 0.044',
    },
    "break": {"none": "", "breaks": "breaks_at = 5.0\nbreaks_s = 30.0"},
}

#: Choice of the factor "ropes" -> lines by rope.
ROPES: dict[str, tuple[str, ...]] = {
    "one": ("",),
    "two equal": ("number = 2",),
    "two": ('name = "front"\nz = 0.3', 'name = "back"\nz = -0.3\nlength = 119.5'),
}

#: Choices of the factor "fidelity" in which ropes cannot press each other.
FLAT = ("auto", "planar", "rigid")

#: What the product refuses in one sentence: choices of two factors or more that exclude each other.
REFUSALS: tuple[tuple[Choices, ...], ...] = (
    (
        ("stop", ("drive", "deceleration", "torque", "two-stage")),
        ("controller", ("input-shaping", "optimised-trajectory")),
    ),
    (("stop", ("deceleration", "torque", "two-stage")), ("brake", ("none",))),
    (("stop", ("deceleration",)), ("brake", ("weak",))),
    (("scheme", ("energy-controlled",)), ("steps", ("20 ms, sampled at 10 ms",))),
    (("ropes", ("two equal",)), ("break", ("breaks",))),
    (("ropes", ("two",)), ("guard", ("far", "near"))),
    (("break", ("breaks",)), ("guard", ("far", "near"))),
    (("fidelity", FLAT), ("contact", ("of the rope with itself",)), ("ropes", ("two",))),
)

#: Beginnings of the names of a rope's values: one rope, one of a group, those of ``ROPES``.
PREFIXES = ("", "rope1.", "front.", "back.")

HEAD = 'name = "pair"\nlike = "rope-120"\nwinding.settle = 1.0\nwinding.start_delay = 0.2\n'


@dataclass(frozen=True)
class Wound:
    """Outcome of ``wind`` in process."""

    file: Path
    out: Path
    code: int
    messages: str

    @property
    def signals(self) -> pd.DataFrame:
        """Return the recorded signals by column, ``name [unit]``."""
        return pd.read_csv(self.out / "signals.csv")


@dataclass
class Finding(Exception):
    """A row that is neither right nor refused in a sentence."""

    row: Mapping[str, str]
    what: str
    details: str = field(default="", repr=False)

    def __str__(self) -> str:
        return f"{self.what}; {dict(self.row)}\n{self.details}"


@dataclass(frozen=True)
class Attempt:
    """One call of the command line."""

    code: int
    out: str
    err: str


@dataclass(frozen=True)
class Bench:
    """Runs the rows in a folder, with what pytest captures and patches."""

    folder: Path
    capture: pytest.CaptureFixture[str]
    patch: pytest.MonkeyPatch

    def call(self, row: Mapping[str, str], *words: str) -> Attempt:
        """Run a command; a traceback, or a refusal that is none, is a Finding."""
        self.capture.readouterr()
        try:
            code = main(words)
        except SystemExit as left:  # argparse
            code = int(left.code or 0)
        except Exception as error:
            raise Finding(row, f"{words[0]} raised {error!r}", traceback.format_exc()) from error
        out, err = self.capture.readouterr()
        attempt = Attempt(code, out, err)
        if code == REFUSED and not _is_refusal(err):
            raise Finding(row, f"{words[0]} refused without a sentence", err)
        if code not in (0, STOPPED, REFUSED, INTERRUPTED):
            raise Finding(row, f"{words[0]} left with {code}", err)
        return attempt

    def wind(self, row: Mapping[str, str], file: Path, name: str, *words: str) -> Wound | None:
        """Wind a file; None for one that is refused."""
        out = self.folder / name
        attempt = self.call(row, "wind", str(file), "--in-process", "--out", str(out), *words)
        if attempt.code == REFUSED:
            return None
        return Wound(file, out, attempt.code, attempt.out + attempt.err)


def rows(seed: int | None = None) -> list[dict[str, str]]:
    """Return the covering array; another seed gives another one."""
    factors = {
        **{name: [*choices] for name, choices in HOIST_LINES.items()},
        **{name: [*choices] for name, choices in ROPE_LINES.items()},
        "ropes": [*ROPES],
        "command": [*COMMANDS],
    }
    if seed is not None:
        generator = random.Random(seed)
        for choices in factors.values():
            generator.shuffle(choices)
    names = [*factors]
    pairs = AllPairs(
        [*factors.values()], filter_func=lambda row: _may_be(dict(zip(names, row, strict=False)))
    )
    return [dict(zip(names, row, strict=True)) for row in pairs]


def _may_be(row: Mapping[str, str]) -> bool:
    """Return whether no choices of a row, or of a part of it, exclude each other."""
    return not any(_contains(row, refusal) for refusal in REFUSALS)


def _contains(row: Mapping[str, str], refusal: Sequence[Choices]) -> bool:
    return all(row.get(name) in choices for name, choices in refusal)


def default_row() -> dict[str, str]:
    """Return the first choice of every factor."""
    factors = {**HOIST_LINES, **ROPE_LINES}
    return {name: next(iter(choices)) for name, choices in factors.items()} | {
        "ropes": "one",
        "command": "check",
    }


def text_of(row: Mapping[str, str]) -> str:
    """Return the hoist's file of a row."""
    lines = [HEAD, *(choices[row[name]] for name, choices in HOIST_LINES.items())]
    of_all_ropes = [choices[row[name]] for name, choices in ROPE_LINES.items()]
    for own in ROPES[row["ropes"]]:
        lines += ["[[rope]]", own, *of_all_ropes]
    return "\n".join(filter(None, lines)) + "\n"


def judge_row(bench: Bench, row: Mapping[str, str]) -> str:
    """Return ``refused`` or ``right``; raise the Finding of a row that is neither."""
    file = bench.folder / "hoist.toml"
    file.write_text(text_of(row), encoding="utf-8")
    wound = bench.wind(row, file, "wound")
    if wound is None:
        return _judge_refused_hoist(bench, row, file)
    _require_physics(row, wound)
    return COMMANDS[row["command"]](bench, row, wound)


def _judge_refused_hoist(bench: Bench, row: Mapping[str, str], file: Path) -> str:
    """Require that --check refuses what ``wind`` refuses, so that nobody waits for it."""
    if bench.call(row, "wind", str(file), "--in-process", "--check").code != REFUSED:
        raise Finding(row, "wind --check accepts what wind refuses")
    return "refused"


def _is_refusal(err: str) -> bool:
    """Return whether the last words are a message of ours, and no traceback."""
    lines = err.strip().splitlines()
    ours = bool(lines) and any(
        line.startswith("balance-rope: ") or ": error: " in line for line in lines
    )
    return ours and "Traceback" not in err and "internal error" not in err


def _refuse(row: Mapping[str, str], what: str, details: object = "") -> NoReturn:
    raise Finding(row, what, str(details))


# the trip itself


def _require_physics(row: Mapping[str, str], wound: Wound) -> None:
    """Require finite signals, the ropes' weight at rest, and a verdict that suits the exit code."""
    signals = wound.signals
    # outputs that a fidelity does not compute are NaN on purpose
    computed = [name for name in signals if name.startswith(COMPUTED) or ".fy [" in name]
    if bad := [name for name in computed if not np.isfinite(signals[name]).all()]:
        _refuse(row, "wind wrote values that are no numbers", bad)
    data = _data(wound.out)
    # wind blows on the legs, so that its own drag is the tolerance; else statics is solved to 1e-6
    share = 1e-5
    if row["air"] == "wind" or row["bodies"] == "sump":
        share = 1e-2
    for prefix in (name for name in PREFIXES if f"{name}rope.length" in data):
        weight = GRAVITY * data[f"{prefix}rope.mass_per_length"] * data[f"{prefix}rope.length"]
        pull = -sum(float(signals[f"{prefix}{side}.fy [N]"][0]) for side in ("left", "right"))
        if abs(pull - weight) > share * weight:
            _refuse(row, f"at rest the ropes pull with {pull} N and weigh {weight} N")
    stopped = "Stopped" in wound.messages or "stopped:" in wound.messages
    if stopped != (wound.code == STOPPED):
        _refuse(row, f"wind left with {wound.code}", wound.messages)
    if wound.code == STOPPED and "stopped: " not in wound.messages:
        _refuse(row, "wind stopped without a cause", wound.messages)


def _data(out: Path) -> dict[str, float]:
    """Return the numbers of data.csv by name."""
    data = pd.read_csv(out / "data.csv")
    values = pd.to_numeric(data["value"], errors="coerce")
    return dict(zip(data["name"], values, strict=True))


def _metrics(wound: Wound, rope: str) -> dict[str, float]:
    """Return every table's metrics from a trip's record; ``rope`` begins a rope's names."""
    signals = wound.signals
    pulls = [-signals[f"{rope}{side}.fy [N]"] for side in ("left", "right")]
    return {
        f"{rope}rope_force_peak": max(float(pull.max()) for pull in pulls),
        f"{rope}rope_force_range": max(float(pull.max() - pull.min()) for pull in pulls),
    }


def _require_equal(
    row: Mapping[str, str], found: Mapping[str, float], wound: Wound, tolerance: float
) -> None:
    ropes = ("",)
    if row["ropes"] == "two":
        ropes = ("front.", "back.")
    values = dict[str, float]()
    for rope in ropes:
        values |= _metrics(wound, rope)
    for name, value in values.items():
        if not math.isclose(found[name], value, rel_tol=tolerance):
            _refuse(row, f"{row['command']}: {name} = {found[name]}, and {value} in wind")


def _require_same_record(
    row: Mapping[str, str], other: Wound, wound: Wound, tolerance: float
) -> None:
    """Require equal signals, to a part of the largest value of each quantity's unit."""
    a = other.signals
    b = wound.signals
    if len(a) != len(b):
        _refuse(row, f"{row['command']}: {len(a)} rows, and {len(b)} in wind")
    for name in sorted({*a} & {*b}):
        largest = max(1e-9, float(np.abs(b[name]).max()))
        error = float(np.abs(a[name] - b[name]).max())
        if error > tolerance * largest:
            _refuse(row, f"{row['command']}: {name} differs by {error}, of at most {largest}")


# the commands


def _show(bench: Bench, row: Mapping[str, str], wound: Wound) -> str:
    shown = bench.call(row, "show", str(wound.file))
    if shown.code == REFUSED:
        _refuse(row, "show refuses what wind winds", shown.err)
    if "nan" in shown.out.split():
        _refuse(row, "show prints values that are no numbers", shown.out)
    return "right"


def _check(bench: Bench, row: Mapping[str, str], wound: Wound) -> str:
    if (checked := bench.call(row, "check", str(wound.file))).code == REFUSED:
        _refuse(row, "check refuses what wind winds", checked.err)
    return "right"


def _again(bench: Bench, row: Mapping[str, str], wound: Wound) -> str:
    """The file that a run writes beside its results winds to the same bits."""
    again = bench.wind(row, wound.out / "hoist.toml", "again")
    if again is None:
        _refuse(row, "the run's own file is refused")
    if (again.out / "signals.csv").read_bytes() != (wound.out / "signals.csv").read_bytes():
        _require_same_record(row, again, wound, 0.0)
        _refuse(row, "the run's own file winds to other bits")
    return "right"


def _resume(bench: Bench, row: Mapping[str, str], wound: Wound) -> str:
    """An interrupted run goes on to the same bits."""
    asked = iter(range(10**6))
    with bench.patch.context() as patch:
        patch.setattr(
            wind_command, "interruption", lambda *_: nullcontext(lambda: next(asked) > 120)
        )
        cut = bench.call(
            row, "wind", str(wound.file), "--in-process", "--out", str(bench.folder / "cut")
        )
    kept = bench.folder / "cut" / "last_good.npz"
    if cut.code == REFUSED:
        _refuse(row, "an interrupted run is refused", cut.err)
    if cut.code != INTERRUPTED:
        return "right"  # it ended before it was interrupted
    resumed = bench.wind(row, wound.file, "resumed", "--resume", str(kept))
    if resumed is None:
        _refuse(row, "a run that was interrupted cannot be resumed")
    ends = wound.signals.iloc[-1], resumed.signals.iloc[-1]
    if not ends[0].equals(ends[1]):
        _refuse(row, "a resumed run ends elsewhere", ends[0].compare(ends[1]))
    return "right"


def _export(bench: Bench, row: Mapping[str, str], wound: Wound) -> Path | None:
    fmu = bench.folder / "rope.fmu"
    words = ("--native", "--platform", "host", "--outputs", "all", "--out", str(fmu))
    made = bench.call(row, "export", str(wound.file), *words)
    if made.code == REFUSED:
        return None
    return fmu


def _fmu(bench: Bench, row: Mapping[str, str], wound: Wound) -> str:
    if (fmu := _export(bench, row, wound)) is None:
        return "refused"
    out = bench.folder / "by_fmu"
    done = bench.call(row, "wind", str(wound.file), "--fmu", str(fmu), "--out", str(out))
    if done.code == REFUSED:
        _refuse(row, "wind refuses the FMU of its own hoist", done.err)
    # compiled for another processor, so that sums may round otherwise
    _require_same_record(row, Wound(wound.file, out, done.code, done.out), wound, 1e-6)
    return "right"


def _table(
    bench: Bench, row: Mapping[str, str], words: tuple[str, ...], table: str
) -> pd.DataFrame | None:
    out = bench.folder / "table"
    done = bench.call(row, *words, "--out", str(out))
    if done.code == REFUSED:
        return None
    return pd.read_csv(out / table)


def _duty(bench: Bench, row: Mapping[str, str], wound: Wound) -> str:
    """A duty of one trip is that trip."""
    file = bench.folder / "duty.toml"
    file.write_text(f'[duty]\nhoist = "{wound.file.name}"\n[[trip]]\n', encoding="utf-8")
    trips = _table(bench, row, ("duty", str(file)), "trips.csv")
    if trips is None:
        return "refused"
    _require_equal(
        row, {name.partition(" ")[0]: float(trips[name][0]) for name in trips}, wound, 1e-8
    )
    return "right"


def _study(bench: Bench, row: Mapping[str, str], wound: Wound) -> str:
    """A study of one run is that run."""
    if (fmu := _export(bench, row, wound)) is None:
        return "refused"
    file = bench.folder / "study.toml"
    file.write_text(
        f'[study]\nhoist = "{wound.file.name}"\n[vary]\ngains.position = [1.0]\n', encoding="utf-8"
    )
    runs = _table(
        bench, row, ("study", str(file), "--fmu", str(fmu), "--workers", "1"), "results.csv"
    )
    if runs is None:
        return "refused"
    _require_equal(row, {name.partition(" ")[0]: runs[name][0] for name in runs}, wound, 1e-6)
    return "right"


def _uncertain(bench: Bench, row: Mapping[str, str], wound: Wound) -> str:
    file = bench.folder / "uncertain.toml"
    file.write_text(
        f'[uncertain]\nhoist = "{wound.file.name}"\nsamples = 8\nmeasures = ["rope_force_range"]\n'
        '[rope]\nconstruction = "34x7"\ndiameter = 0.044\n[known]\nmass_per_length = 7.7\n',
        encoding="utf-8",
    )
    runs = _table(bench, row, ("uncertain", str(file), "--workers", "1"), "windings.csv")
    if runs is None:
        return "refused"
    return "right"


def _linear(command: str) -> Callable[[Bench, Mapping[str, str], Wound], str]:
    def judged(bench: Bench, row: Mapping[str, str], wound: Wound) -> str:
        out = bench.folder / command
        words = (command, str(wound.file), "--at", "0.1", "--band", "1.0", "--out", str(out))
        if bench.call(row, *words).code == REFUSED:
            return "refused"
        return "right"

    return judged


COMMANDS: dict[str, Callable[[Bench, Mapping[str, str], Wound], str]] = {
    "show": _show,
    "check": _check,
    "again": _again,
    "resume": _resume,
    "fmu": _fmu,
    "duty": _duty,
    "study": _study,
    "uncertain": _uncertain,
    "modes": _linear("modes"),
    "linearise": _linear("linearise"),
}
