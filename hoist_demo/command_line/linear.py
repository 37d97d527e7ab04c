"""The commands ``balance-rope linearise`` and ``balance-rope modes``."""

from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from tqdm import tqdm

from hoist_demo.cases.case import BUILTIN_HOISTS, DEFAULT_HOIST, Case
from hoist_demo.cases.table import find_case
from hoist_demo.command_line.support import (
    RunCommand,
    describe,
    nonempty_path,
    results_folder,
)
from rope_model.files import whole_file

_CHANNELS = ("torque_command",), ("rate", "pull_left", "pull_right")
_BAR = "modes {desc} {percentage:3.0f}% |{bar}| [{elapsed} < {remaining}]"
_HEIGHTS = (0.0, 0.25, 0.5, 0.75, 1.0)

_LINEARISE = """\
Linear models of hoist and balance ropes, at rest or at constant speed, for controller design: A, B, C, D of few states
for each height, in plant.npz, plant.mat and plant.json, with the error measured against the complete linear model."""

_MODES = """\
Frequencies, damping and shapes of hoist and balance ropes along the trip: modes.csv has all of them, modes.png draws
them over the height, the poles, and what the torque does with and without the balance ropes."""

_EPILOG = """\
examples:
  balance-rope {name} monopol-1000
  balance-rope {name} --at 0 0.1 0.2 --swivels free

Coulomb friction, play, slip on the lining, and the events of a trip (jams, a rope's break) are left out; see
docs/howto/control.md.
"""


def add_linearise(linearise: argparse.ArgumentParser) -> None:
    """Add description and options of the command ``linearise``."""
    _add(linearise, "linearise", _linearise, _LINEARISE)
    text = "of the left conveyance, upwards (%(default)s)"
    linearise.add_argument("--speed", type=float, default=0.0, metavar="M/S", help=text)
    linearise.add_argument(
        "--held-by", choices=("motor", "brake"), default="motor", help="(%(default)s)"
    )
    text = "of each model (the fewest whose measured error is small enough to use them)"
    linearise.add_argument("--states", type=int, metavar="N", help=text)
    for name, channels in zip(("--inputs", "--outputs"), _CHANNELS, strict=True):
        linearise.add_argument(
            name, nargs="+", default=channels, metavar="NAME", help=f"({' '.join(channels)})"
        )


def add_modes(modes: argparse.ArgumentParser) -> None:
    """Add description and options of the command ``modes``."""
    _add(modes, "modes", _modes, _MODES)
    modes.add_argument(
        "--count",
        type=int,
        default=8,
        metavar="N",
        help="modes printed at each height (%(default)s)",
    )


def _add(command: argparse.ArgumentParser, name: str, run: RunCommand, description: str) -> None:
    """Add description and the options that both commands have."""
    describe(command, run, description, _EPILOG.format(name=name))
    text = f"a file, or one of {', '.join(BUILTIN_HOISTS)} (%(default)s)"
    command.add_argument("hoist", nargs="?", default=DEFAULT_HOIST, metavar="HOIST", help=text)
    text = "left height over travel (five from 0 to 1)"
    command.add_argument("--at", type=float, nargs="+", default=_HEIGHTS, metavar="PART", help=text)
    swivels = ("as given", "locked", "free", "sticking")
    command.add_argument("--swivels", choices=swivels, default=swivels[0], help="(%(default)s)")
    command.add_argument(
        "--band", type=float, default=2.0, metavar="HZ", help="highest frequency (%(default)s)"
    )
    command.add_argument(
        "--out",
        type=nonempty_path,
        default=Path("out") / name,
        metavar="DIR",
        help="results (%(default)s)",
    )


def _hoist(options: argparse.Namespace) -> Case:
    """Return the hoist; ValueError for a band that holds no response."""
    from hoist_demo.design.reduced_model import SLOWEST

    if not SLOWEST < options.band < math.inf:
        raise ValueError(
            f"--band {options.band:g} must be above {SLOWEST:g} Hz: 2 suits a hoist, 10 a stiff one"
        )
    return find_case(options.hoist)


def _linearise(options: argparse.Namespace) -> int:
    """Write small models of a hoist into a folder."""
    from hoist_demo.design.linearise import linearise
    from hoist_demo.design.reduction import reduced

    case = _hoist(options)
    models = linearise(
        case, options.at, options.swivels, options.held_by, case.level, options.speed
    )
    selected = [model.selected(options.inputs, options.outputs) for model in models]
    small = reduced(selected, options.states, options.band)
    written = small.write(results_folder(options.out))
    print(f"{small.A.shape[1]} states; largest errors to {small.band:g} Hz:")
    print(f"{'at':>6}{'output':>16}{'input':>18}{'dB':>10}{'degrees':>10}{'of peak':>10}")
    for k, at in enumerate(small.at):
        for i, output in enumerate(small.outputs):
            for j, input_name in enumerate(small.inputs):
                errors = "".join(
                    f"{float(x[k, i, j]):10.2g}"
                    for x in (small.decibels, small.degrees, small.share)
                )
                print(f"{at:6.3g}{output:>16}{input_name:>18}{errors}")
    print("\nwritten: " + ", ".join(map(str, written)))
    return 0


def _followed(bar: tqdm[NoReturn]) -> Callable[[float], None]:
    """Return a function that moves the bar to a part of the whole."""

    def move(part: float) -> None:
        bar.update(part - bar.n)

    return move


def _bar(title: str) -> tqdm[NoReturn]:
    """Return a bar of progress on a terminal, from 0 to 1."""
    return tqdm(
        total=1.0,
        desc=title,
        bar_format=_BAR,
        file=sys.stderr,
        leave=False,
        disable=None,
    )


def _modes(options: argparse.Namespace) -> int:
    """Write all modes of a hoist up to a frequency, and print those that the torque moves most."""
    import numpy as np

    from hoist_demo.design.linear_model import PARTS, UndampedModes
    from hoist_demo.design.linearise import linearise, linearise_hoist
    from hoist_demo.design.reduction import modal_participation
    from hoist_demo.report.linear_figures import write_modes_figure

    if options.count < 1:
        raise ValueError(
            f"--count {options.count} must be at least 1: give how many modes to print"
        )
    case = _hoist(options)
    band = options.band
    out = results_folder(options.out)
    models = linearise(case, options.at, options.swivels, level=case.level)
    head = ("at", "frequency [Hz]", "damping", "felt by the drive", *PARTS)
    rows: list[list[float]] = []
    modes: list[UndampedModes] = []
    print("".join(f"{name:>18}" for name in head), flush=True)
    for model in models:
        with _bar(f"at {model.at:g}") as bar:
            of_model = model.modes(band, _followed(bar))
        modes.append(of_model)
        felt = modal_participation(model.selected(*_CHANNELS), of_model, band)
        at = np.full(felt.size, model.at)
        columns = (at, of_model.frequencies, of_model.damping, felt, of_model.shares.T)
        table = np.column_stack(columns)
        rows += table.tolist()
        most_felt = np.sort(np.argsort(-felt)[: options.count])
        for row in table[most_felt].tolist():
            quantities = [f"{x:18.4g}" for x in row[: -len(PARTS)]]
            shares = [f"{x:18.2f}" for x in row[-len(PARTS) :]]
            print("".join([*quantities, *shares]), flush=True)
    with (
        whole_file(out / "modes.csv") as draft,
        draft.open("w", newline="", encoding="utf-8") as file,
    ):
        csv.writer(file).writerows([head, *rows])
    without = linearise_hoist(case, options.at[len(options.at) // 2], level=case.level)
    figure = write_modes_figure(models, modes, without, band, out / "modes.png")
    print(f"\nwritten: {out / 'modes.csv'}, {figure}")
    return 0
