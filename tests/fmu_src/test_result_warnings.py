"""What the FMU of each flavour says of results that are valid and yet not a real rope's."""

import math
import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache, partial
from itertools import islice, product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exports import FLAVOURS
from native_host import WARNING, Host
from scenes import ends_at, hung, recorded

from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from hoist_demo.parameters import Winding
from rope_model import Air, Layout, Mesh, Model, Rope, Shaft, balance_rope, rope_120
from rope_model.boundary.end_paths import EndMotion
from rope_model.boundary.input_detectors import GridDetector, TableDetector
from rope_model.boundary.input_filter import InputFilter, Misfits, Repetitions
from rope_model.engine import NativeRope
from rope_model.messages import warning_messages
from rope_model.messages.rules import first_text
from rope_model.physics.node import SIDES
from rope_model.state import Crossing, RopeState
from rope_model.warnings.result_warnings import WARNINGS
from rope_model.warnings.warning_rules import LONG_EXTRAPOLATION, MAX_EXTRAPOLATION

OUTPUTS = (
    "status.valid",
    "status.warning",
    "left.swivel.torque",
    "stress.torsion_max",
    "stress.bending_max",
)
WITHOUT_TORQUE = {"model.fidelity": 3, "rope.Qb": 0.0, "rope.Qc": 0.0}
DEEP = {
    "rope.length": 690.0,
    "rope.mass_per_length": 8.2,
    "rope.EI": 450.0,
    "layout.spacing": 1.8,
    "right.y": 650.0,
}
AT_90_M = EndMotion(y=0.0), EndMotion(y=90.0)
#: name -> parameters, and communication steps
RUNS: dict[str, tuple[dict[str, Any], tuple[float, ...]]] = {
    "plain": ({}, (0.01, 0.02)),
    "passed": ({"rope.installed_twist": 7.0}, (0.01, 0.01)),
    "touching": (
        {"rope.installed_twist": 5.5, "rope.diameter": 0.75, "layout.spacing": 1.0},
        (0.01, 0.01),
    ),
    "yawed by its coupling": (DEEP, ()),
    "yawed by its twist": ({"rope.installed_twist": 3.0}, (0.01, 0.01)),
    "yawed by its ends": ({"left.yaw": 2.0, "right.yaw": 1.5}, (0.01, 0.01)),
    "yawed, then wound": ({"rope.installed_twist": 3.0, "right.ay": -1.0}, (0.01,)),
    "spatial": ({"model.fidelity": 2}, (0.01,)),
    "planar": ({"model.fidelity": 3}, (0.01,)),
    "rigid": ({"model.fidelity": 4}, (0.01,)),
    "planar in a cross wind": (WITHOUT_TORQUE | {"air.density": 1.2, "air.vz": 5.0}, (0.01,)),
    "planar without torque": (WITHOUT_TORQUE, (0.01,)),
    "long steps": ({}, (0.05, 0.05)),
    "a long step, then a short one": ({}, (0.05, 0.01)),
    "long steps, motion at their end": ({"inputs_at_step_end": True}, (0.05, 0.05)),
    "large step_max, no step yet": ({"solver.step_max": 0.04}, ()),
}


#: what the Python flavour runs, whose rope takes some 25 times as long
BRIEF = ("plain", "long steps", "yawed by its twist")


def runs_of(kind: str) -> list[str]:
    """Return what a flavour runs of RUNS."""
    if FLAVOURS[kind].native:
        return [*RUNS]
    return [*BRIEF]


def each(*runs: str) -> pytest.MarkDecorator:
    pairs = [(kind, run) for kind, run in product(sorted(FLAVOURS), runs) if run in runs_of(kind)]
    return pytest.mark.parametrize(("results", "run"), pairs, indirect=["results"])


native = pytest.mark.parametrize(
    "results", [kind for kind, x in FLAVOURS.items() if x.native], indirect=True
)


@pytest.fixture
def results(
    request: pytest.FixtureRequest, unpacked: Callable[[str], tuple[Path, str]]
) -> dict[str, Any]:
    return outcomes(request.param, *unpacked(request.param))


@cache
def outcomes(kind: str, path: Path, folder: str) -> dict[str, Any]:
    out = {}
    for name in runs_of(kind):
        parameters, steps = RUNS[name]
        host = Host(path, folder)
        t = 0.0
        host.start(**parameters)
        for h in steps:
            assert host.step(t, h) == ""
            t += h
        warnings = [message for status, message in host.log if status == WARNING]
        out[name] = {"warnings": warnings, **dict(zip(OUTPUTS, host.get(*OUTPUTS), strict=True))}
        host.free()
    assert all(run["status.valid"] for run in out.values())
    return out


@cache
def warnings_at_rest(run: str) -> list[str]:
    given: Mapping[str, float] = {"left.y": 0.0, "right.y": 90.0} | RUNS[run][0]
    ends: dict[str, dict[str, float]] = {side: {} for side in SIDES}
    parameters = {}
    for name, value in given.items():
        side, _, key = name.partition(".")
        if side in ends:
            ends[side][key] = value
        else:
            parameters[name] = value
    rope = balance_rope(rope_scene(parameters))
    return [*hung(rope, *(EndMotion(**ends[side]) for side in SIDES)).warnings().values()]


@each("plain", "planar without torque", "large step_max, no step yet")
def test_where_no_warning_applies_none_is_given(results: dict[str, Any], run: str) -> None:
    assert (results[run]["warnings"], results[run]["status.warning"]) == ([], "")


CROSSED = "planar in a cross wind"
YAWED = ["yawed by its coupling", "yawed by its twist", "yawed by its ends"]


@each("passed", "touching", *YAWED, "spatial", "planar", CROSSED, "rigid", "long steps")
def test_a_warning_is_logged_once_and_stays_readable(results: dict[str, Any], run: str) -> None:
    (warning,) = results[run]["warnings"]
    # numbers in it may be those of another instant
    assert results[run]["status.warning"][:40] == warning[:40]


@native
@pytest.mark.parametrize(
    ("run", "words"),
    [
        ("passed", "passed through each other"),
        ("touching", "legs have touched"),
        ("yawed by its coupling", "the coupling Qb = 233600"),
        ("yawed by its twist", "installed_twist = 3 rad"),
        ("yawed by its ends", "twist the rope by 3.5 rad"),
    ],
)
def test_an_fmu_says_of_a_turned_loop_what_the_rope_says(
    results: dict[str, Any], run: str, words: str
) -> None:
    expected = warnings_at_rest(run)
    assert results[run]["warnings"] == expected
    assert words in expected[0]


@pytest.mark.parametrize(("twist", "said"), [(1.5, False), (2.1, True)])
def test_thirty_degrees_at_rest_are_the_bound(twist: float, said: bool) -> None:
    scene = rope_120().scene
    rope = hung(
        balance_rope(scene.with_(rope=replace(scene.rope, installed_twist=twist))), *AT_90_M
    )
    assert (rope.state.loop_yaw > math.radians(30.0)) == said == bool(rope.warnings())


@native
def test_torsional_stress_is_0_like_the_torque_where_no_torsion_is_computed(
    results: dict[str, Any],
) -> None:
    keys = "left.swivel.torque", "stress.torsion_max"
    for fidelity in ("spatial", "planar", "rigid"):
        assert f"the {fidelity} model computes no" in results[fidelity]["status.warning"]
        assert [results[fidelity][key] for key in keys] == [0.0, 0.0]
    rope = Rope()
    half_circle = 0.5 * Layout().spacing
    stress = 32 * rope.EI / (math.pi * rope.diameter**3 * half_circle)
    assert results["rigid"]["stress.bending_max"] == pytest.approx(stress, rel=1e-3)
    assert min(abs(results["plain"][key]) for key in keys) > 1.0


@native
def test_a_long_step_is_told_only_of_extrapolated_inputs_and_while_it_lasts(
    results: dict[str, Any],
) -> None:
    told = warning_messages.extrapolated_too_far(0.05, MAX_EXTRAPOLATION)
    assert results["long steps"]["warnings"] == [told] == [results["long steps"]["status.warning"]]
    assert results["long steps, motion at their end"]["warnings"] == []
    after = results["a long step, then a short one"]
    assert (len(after["warnings"]), after["status.warning"]) == (1, "")


def test_a_loop_that_turns_with_its_ends_is_not_called_yawed() -> None:
    turn = 3.0  # rad, of both suspension points about their middle, and of the conveyances
    scene = rope_120().scene
    rope = balance_rope(scene.with_(rope=replace(scene.rope, installed_twist=1.0)))
    x = 1.0 - math.cos(turn)
    z = math.sin(turn)
    left = EndMotion(x=x, y=0.0, z=z, yaw=turn)
    right = EndMotion(x=-x, y=90.0, z=-z, yaw=turn)
    assert hung(rope, left, right).state.loop_yaw > math.pi
    assert rope.warnings() == {}


PLAIN = replace(rope_120().scene.rope, Qb=0.0, Qc=0.0)
ROPES = {
    "coupled": rope_120().scene.rope,
    "twisted": replace(PLAIN, installed_twist=0.5),
    "plain": PLAIN,
}


def following_of_misfits(chance: random.Random) -> InputFilter:
    return InputFilter(
        misfits=Misfits(
            position=chance.choice((0.0, 3e-4, 0.2)),
            speed=chance.uniform(0.0, 0.3),
            acceleration=chance.choice((0.0, 0.3)),
        ),
        repetitions=Repetitions(number=chance.choice((0.0, 0.0, 12.0)), sent_every=0.02),
        grid=GridDetector(
            size=chance.choice((1.0, 0.0, 1e-3)), samples=chance.choice((3.0, 300.0))
        ),
        table=TableDetector(breaks=chance.choice((0.0, 2.0, 9.0)), piece=0.1),
    )


def altered_states(state: RopeState, chance: random.Random) -> Iterator[RopeState]:
    def instant_and_height() -> tuple[float, float]:
        return chance.uniform(0.0, 9.0), chance.uniform(-60.0, 0.0)

    while True:
        audit = state.audit._replace(
            force=1e4,
            missing_force=chance.uniform(0.0, 20.0),
            missing_moment=chance.uniform(0.0, 200.0),
            force_change=chance.uniform(0.0, 1e3),
            period_fraction=chance.choice((0.0, chance.uniform(0.2, 0.5))),
            bend=chance.choice((0.0, chance.uniform(0.3, 4.5))),
        )
        number = float(chance.choice((0, 0, 1, 3)))
        overlap = chance.choice((0.0, chance.uniform(0.0, 0.1)))
        yield state._replace(
            audit=audit,
            crossing=Crossing(
                number, number, *instant_and_height(), overlap, *instant_and_height()
            ),
            energy_balance=state.energy_balance._replace(kinetic=chance.choice((0.0, 1e-6, 1.0))),
            loop_yaw=chance.uniform(-4.0, 4.0),
            offsets=(0.0, chance.uniform(-6.0, 6.0)),
            snap_twist=chance.choice((0.0, 2.5)),
            counts=state.counts._replace(given_up=chance.choice((0, 7))),
            given_up_since=chance.uniform(0.0, 9.0),
            filters=(following_of_misfits(chance), following_of_misfits(chance)),
        )


@pytest.mark.parametrize("name", ROPES)
def test_both_forms_warn_of_the_same_in_the_same_words(name: str) -> None:
    mesh = Mesh(kind="eem", elements=16)
    parts: Any = {
        "mesh": mesh,
        "model": Model(fidelity="torsional"),
        "shaft": Shaft(air=Air(buffet=0.1, vz=2.0)),
    }
    scene = rope_120().scene.with_(rope=ROPES[name], **parts)
    rope = hung(NativeRope(scene), *AT_90_M)
    seen = set()
    yawed = set()
    for state in islice(altered_states(rope.state, random.Random(name)), 200):
        rope.restore(state)
        told = {subject: text for subject, warn in WARNINGS.items() if (text := warn(scene, state))}
        assert rope.warnings() == told
        seen |= told.keys()
        yawed |= {text.split(" mostly by ")[1][:8] for text in told.values() if "mostly by" in text}
    assert seen == WARNINGS.keys() - {"passed_bodies", "neglected_effects", "blind_guards"}
    assert len(yawed) >= 2 or name == "plain"


@pytest.mark.parametrize("start", [0.0, 1.7e9])
def test_a_step_of_the_bound_is_not_too_long_at_any_time(start: float) -> None:
    """Between instants in s since 1970 it is 2e-7 s longer or shorter."""
    rope = hung(NativeRope(rope_120("draft").scene), *AT_90_M, start)
    for k in range(1, 11):
        assert rope.advance_to(start + k * MAX_EXTRAPOLATION, *AT_90_M).valid
        assert first_text(LONG_EXTRAPOLATION, rope.scene, rope.state) == ""
    assert rope.advance_to(rope.state.motion.t + 0.021, *AT_90_M).valid
    assert first_text(LONG_EXTRAPOLATION, rope.scene, rope.state)


@pytest.mark.parametrize(
    ("stop", "missed"),
    [
        pytest.param(None, {0.02: 0.0008, 0.05: 0.0205}, marks=pytest.mark.slow),
        (8.0, {0.02: 0.044, 0.05: 0.197}),
    ],
)
def test_forces_of_extrapolated_motions_are_off_as_is_said(
    stop: float | None, missed: dict[float, float]
) -> None:
    trip = Winding(travel=90.0, start_delay=0.0, emergency_at=stop)
    exact = end_forces(trip, 0.0025, extrapolated=False)
    largest = np.abs(exact).max()
    for h, part in missed.items():
        errors = (
            end_forces(trip, h, extrapolated=True)
            - exact[round(h / 0.0025) - 1 :: round(h / 0.0025)]
        )
        assert np.abs(errors).max() == pytest.approx(part * largest, rel=0.05)
        # twice the mass of a leg of 105 m times what the path misses of the acceleration, by test_masters; longer steps
        # fall in with the rope's axial swings
        jerk = trip.jerk
        if stop is not None:
            jerk = trip.emergency_jerk
        mass = rope_120().scene.rope.mass_per_length * 105.0
        assert h > MAX_EXTRAPOLATION or np.abs(errors).max() < 2 * 2.94 * jerk * h * mass


def end_forces(trip: Winding, h: float, extrapolated: bool) -> np.ndarray:
    """(steps, 2), N: vertical end forces of the 120 m rope after each step ``h`` of the first 14 s of a winding."""
    rope = NativeRope(rope_120().scene)
    motion = partial(ends_at, s_curve(trip), trip.travel)
    return recorded(
        rope, motion, round(14.0 / h), ["left.fy", "right.fy"], h, late=int(extrapolated)
    )
