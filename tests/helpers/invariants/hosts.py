"""The same rope elsewhere: in the native FMU, beneath a hoist in C and in Python, beneath a mirrored hoist."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

import fmpy
import numpy as np
from exports import EXPORTS
from native_host import OK, Host

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.compiled_trip import CompiledTrip
from hoist_demo.cosimulation.host import Host as Hoisting
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_scene
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import Coupling, Hoist, Winding
from invariants.case import Array, Case, Sketch
from invariants.features import Draws
from invariants.runs import (
    FORCES,
    MEANS,
    MOMENTS,
    PLACE,
    Compared,
    Finding,
    Record,
    Refused,
    rms,
    start,
)
from invariants.symmetries import values_of

#: of the largest value: compilers contract products otherwise in FMU and library
ROUNDING = 1e-9
#: of the largest end force, RMS: the error of the level draft, which both runs may have
MIRRORED = 1e-2
COMPARED = (*FORCES, *MEANS, *MOMENTS, *PLACE)
#: gives the folder with the FMU of a kind; a test replaces it by its own
FMU: dict[str, Path] = {}


@cache
def _unpacked(kind: str) -> tuple[Path, str]:
    folder = Path(tempfile.mkdtemp(prefix="invariants-"))
    path = FMU.get(kind) or EXPORTS[kind](folder / f"{kind}.fmu")
    return path, str(fmpy.extract(str(path), str(folder / kind)))


def fmu(case: Case, draws: Draws) -> Iterator[Compared]:
    """The native FMU, given all parameters as variables, step by step beside the rope in process."""
    case = case.with_(force=None, times=case.times[:60])
    record = start(case)
    host = Host(*_unpacked("native-2"))
    try:
        yield from _compared(case, record, host)
    finally:
        host.free()


def _compared(case: Case, record: Record, host: Host) -> Iterator[Compared]:
    values = values_of(case.scene) | {"inputs_at_step_end": int(not case.late)}
    _move(host, case, case.start)
    if host.give(values) != OK:
        raise Finding(f"the FMU alone refuses a parameter: {host.said[-1]}")
    if host.enter(case.start) != OK or host.call("ExitInitializationMode") != OK:
        raise Finding(f"the FMU alone cannot hang: {host.said[-1]}")
    rows = [host.get(*COMPARED)]
    ours = [[*record.rope.signals(COMPARED).values()]]
    for k in range(1, len(case.times)):
        begin = float(case.times[k - 1])
        h = float(case.times[k] - case.times[k - 1])
        at = begin + h
        if case.late:
            at = begin
        _move(host, case, at)
        said = host.step(begin, h)
        status = record.rope.advance_to(begin + h, *case.at(at), at)
        if bool(said) == status.valid:
            raise Finding(
                f"one alone refuses the step to {begin + h:g} s: {said or status.message}"
            )
        if said:
            break
        rows.append(host.get(*COMPARED))
        ours.append([*record.rope.signals(COMPARED).values()])
    there = np.array(rows)
    here = np.array(ours)
    for group in (FORCES, MEANS, MOMENTS, PLACE):
        chosen = [COMPARED.index(name) for name in group]
        largest = max(float(np.abs(here[:, chosen]).max()), 1.0)
        # rounding of positions of 1000 m on elements of some 0.1 m
        yield Compared(
            group[0],
            float(np.abs(there - here)[:, chosen].max()),
            ROUNDING * largest + 1e-5 * (group != PLACE),
        )


def _move(host: Host, case: Case, t: float) -> None:
    for side, end in zip(("left", "right"), case.at(t), strict=True):
        for name, value in vars(end).items():
            if host.put(f"{side}.{name}", value) != OK:
                raise Refused(f"made: {host.said[-1]}")


@dataclass(frozen=True)
class Trip:
    """A short trip of the 120 m hoist, with some of what a case has on its rope."""

    hoist: Hoist
    winding: Winding
    coupling: Coupling
    rope: dict[str, Any]

    def run(self, in_python: bool = False) -> Result:
        rope = InProcessRope(rope_scene({**find_case("rope-120").rope, **self.rope}, "draft"))
        host = Hoisting(rope, self.hoist, self.winding, self.coupling)
        if not in_python:
            return host.run()
        with patch.object(CompiledTrip, "for_run", return_value=None):
            return host.run()


def _trip(case: Case, draws: Draws) -> Trip:
    ropes = Sketch(case.seed, case.number).values
    taken = (
        "left.swivel.",
        "right.swivel.",
        "air.",
        "rope.c2",
        "rope.installed_twist",
        "accuracy.",
        "guard.",
        "model.",
    )
    rope = {name: value for name, value in ropes.items() if name.startswith(taken)}
    hoist = replace(
        find_case("rope-120").hoist,
        payload_left=draws.evenly(0.0, 6e3),
        payload_right=draws.evenly(0.0, 6e3),
        conveyance_mass_right=draws.one_of(None, draws.evenly(9e3, 14e3)),
    )
    winding = Winding(
        travel=draws.sign() * draws.evenly(1.0, 10.0),
        speed=draws.evenly(1.0, 6.0),
        acceleration=draws.evenly(0.5, 1.5),
        start_delay=0.1,
        settle=0.5,
        emergency_at=draws.one_of(None, None, draws.evenly(0.5, 2.0)),
    )
    steps = draws.one_of((0.02, 0.01), (0.01, 0.02), (0.02, 0.02), (0.01, 0.01))
    return Trip(hoist, winding, Coupling(step=steps[0], sample=steps[1]), rope)


def trip_in_c(case: Case, draws: Draws) -> Iterator[Compared]:
    """A trip of a hoist in C against the loop in Python."""
    trip = _trip(case, draws)
    one = trip.run()
    two = trip.run(in_python=True)
    if (one.cause, one.completed, one.steps) != (two.cause, two.completed, two.steps):
        raise Finding(
            f"one ends with {one.cause!r} after {one.steps} steps, one with {two.cause!r} after {two.steps}"
        )
    if not one.recording.signals:
        raise Refused(f"hung: {one.cause}")
    for name, values in two.recording.signals.items():
        yield _apart(name, one.recording[name], values)


def _apart(name: str, one: Array, two: Array) -> Compared:
    if (np.isfinite(one) != np.isfinite(two)).any():
        raise Finding(f"{name} is missing in one of two")
    finite = np.isfinite(two)
    largest = float(np.abs(two[finite]).max(initial=0.0))
    return Compared(
        name, float(np.abs(one[finite] - two[finite]).max(initial=0.0)), ROUNDING * largest
    )


def mirrored_hoist(case: Case, draws: Draws) -> Iterator[Compared]:
    """The left conveyance up against the right one up, with payloads and masses exchanged."""
    trip = _trip(case, draws)
    # the wind stays where it is, an emergency stop is the same, and guards count heights alike
    trip = replace(
        trip, rope={n: x for n, x in trip.rope.items() if not n.startswith(("air.", "guard."))}
    )
    hoist = trip.hoist
    other = replace(
        trip,
        hoist=replace(
            hoist,
            payload_left=hoist.payload_right,
            payload_right=hoist.payload_left,
            conveyance_mass=hoist.conveyance_mass_right or hoist.conveyance_mass,
            conveyance_mass_right=hoist.conveyance_mass,
        ),
        winding=replace(trip.winding, travel=-trip.winding.travel),
        rope={_opposite(name): value for name, value in trip.rope.items()},
    )
    one = trip.run()
    two = other.run()
    if one.completed != two.completed or one.steps != two.steps:
        raise Finding(
            f"one ends with {one.cause!r} after {one.steps} steps, one with {two.cause!r} after {two.steps}"
        )
    if not one.recording.signals:
        raise Refused(f"hung: {one.cause}")
    # the drive's first step differs by the sign of its rounding; the rope's own decisions may
    # differ
    forces = max(float(np.abs(one.recording[f"{side}.fy"]).max()) for side in ("left", "right"))
    for name, sign in (("left.fy", 1.0), ("right.fy", 1.0), ("left.fx", -1.0), ("left.fz", -1.0)):
        difference = two.recording[_opposite(name)] - sign * one.recording[name]
        yield Compared(f"RMS of {name}", rms(difference), MIRRORED * forces)


def _opposite(name: str) -> str:
    side, dot, rest = name.partition(".")
    return {"left": "right", "right": "left"}.get(side, side) + dot + rest


SELDOM: tuple[Callable[[Case, Draws], Iterator[Compared]], ...] = (trip_in_c, mirrored_hoist)
RELATIONS: tuple[Callable[[Case, Draws], Iterator[Compared]], ...] = (fmu,)
