"""Drag of the air and forces that a host puts on places of the rope: elements and ropes that have them."""

import json
import math
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from air_scenes import LENGTH, STEP, ends, scene
from checkout import ROOT
from numpy.testing import assert_allclose, assert_array_equal
from scenes import followed, hung, wound
from shared import difference

from rope_model import (
    BalanceRope,
    EndMotion,
    Mesh,
    Model,
    PointForces,
    Solver,
    balance_rope,
)
from rope_model.parameters import Layout, Rope, Scene
from rope_model.physics.air import AirCoefficients, air_acts, air_coefficients
from rope_model.physics.air_element import AIR_BALANCE, air_functions
from rope_model.physics.element import ELEMENT_DOF, ElementFidelity
from rope_model.physics.node import NODE_DOF
from rope_model.reference.scope import unpublished
from rope_model.shaft_parameters import Air, Shaft, Sump

LAW = air_coefficients(Air(density=1.2, drag=1.1, vx=1.0, vy=2.0, vz=-3.0), 0.044, 2.0)
#: numbers of the law, and of conveyances at rest
A = [*LAW.numbers(), *8 * [0.0]]


def moved(fidelity: ElementFidelity, seed: int) -> tuple[np.ndarray[Any, Any], ...]:
    """q and v of an element that is bent, stretched and moves."""
    chance = np.random.default_rng(seed)
    kept = list(ELEMENT_DOF[fidelity])
    q = np.zeros((2, NODE_DOF))
    v = chance.normal(size=(2, NODE_DOF))
    q[:, 3:6] = np.array([0.6, -0.8, 0.0]) + 0.1 * chance.normal(size=(2, 3))
    q[1, :3] = [1.2, -1.6, 0.1]
    return q[:, kept].ravel(), v[:, kept].ravel()


def test_a_straight_element_has_the_drag_of_a_cylinder() -> None:
    l = 2.0
    t = np.array([0.6, -0.8, 0.0])
    w = np.array([1.5, 0.5, 2.0])
    q = np.zeros((2, NODE_DOF))
    v = np.zeros((2, NODE_DOF))
    q[:, 3:6] = t
    q[1, :3] = l * t
    v[:, :3] = w
    against = w - np.array(LAW.velocity)
    across = against - (against @ t) * t
    force = -LAW.factor * np.linalg.norm(across) * across * l
    sums = air_sums(q, v, l, A)
    moment = np.cross(0.5 * l * t, force)
    assert_allclose(
        [sums[f"air_{kind}{axis}"] for kind, axis in product("fm", "xyz")],
        [*force, *moment],
        rtol=1e-12,
    )
    assert sums["given_to_air"] == pytest.approx(-force @ w)
    # what the air does to r of both nodes is the whole force; across no length of the rope twice
    R = np.array(air_functions("torsional").residual(q.ravel(), v.ravel(), l, A)).reshape(
        2, NODE_DOF
    )
    assert_allclose(-R[:, :3].sum(axis=0), force, rtol=1e-12)


SPACING = 0.4  #: m
#: m, of a conveyance so high that what its bow does is over before its tail comes
HEIGHT = 80.0
SPEED = 10.0  #: m/s, at which it rises
PUSH = air_coefficients(
    Air(density=1.2, drag=1.1, buffet=0.3, buffet_length=HEIGHT), 0.044, SPACING
)


def air_sums(q: np.ndarray, v: np.ndarray, l: float, numbers: list[float]) -> dict[str, float]:
    sums = air_functions("torsional").sums(q.ravel(), v.ravel(), l, numbers)
    return dict(zip(AIR_BALANCE, np.array(sums).ravel().tolist(), strict=True))


def pulse(x: float, y: float, l: float = 0.1) -> dict[str, float]:
    """What an upright element at (x, y) gets of a conveyance whose bow is at the origin; the other one stands."""
    q = np.zeros((2, NODE_DOF))
    v = np.zeros(2 * NODE_DOF)
    q[:, 0] = x
    q[:, 1] = (y, y - l)
    q[:, 4] = -1.0
    return air_sums(
        q,
        v,
        l,
        [*PUSH.numbers(), *(0.0, -HEIGHT, 0.0, SPEED), *(x, 0.0, 0.0, 0.0)],
    )


def test_the_bow_gives_a_rigid_leg_the_impulse_of_its_pulse() -> None:
    """By the integral of (1 + h^2)^-3 over all h, 3 pi/8; the tail draws it back by as much."""
    places = np.arange(-20.0, 20.0, 0.1)
    impulse = (
        sum(pulse(SPACING, y)["air_fx"] for y in places) / SPEED
    )  # of 0.1 m, past which the bow moves
    expected = PUSH.factor * (PUSH.buffet * SPEED) ** 2 * 3 * np.pi / 8 * SPACING / SPEED
    assert impulse == pytest.approx(expected, rel=1e-4)  # the tail is 200 spacings away
    drawn = sum(pulse(SPACING, y - HEIGHT)["air_fx"] for y in places) / SPEED
    assert drawn == pytest.approx(-expected, rel=1e-4)
    # on the other leg away from itself, and on none that hangs above it
    assert pulse(-SPACING, 0.0)["air_fx"] == -pulse(SPACING, 0.0)["air_fx"]
    assert pulse(0.0, 0.0)["air_fx"] == pulse(0.0, -HEIGHT)["air_fx"] == 0.0


#: a gallery's flow, and one that has an upper end only
GALLERY = air_coefficients(
    Air(density=1.2, vx=3.0, vy=2.0, vz=-4.0, cross_y=-11.0, cross_height=4.3), 0.044, 2.0
)


def upright(law: AirCoefficients, top: float, l: float) -> dict[str, float]:
    """What 60 m of straight rope below ``top``, of equal elements, get of the air."""
    q = np.zeros((2, NODE_DOF))
    v = np.zeros(2 * NODE_DOF)
    q[:, 4] = -1.0
    sums = np.zeros(len(AIR_BALANCE))
    numbers = [*law.numbers(), *8 * [0.0]]
    for y in top - np.arange(0.0, 60.0, l):
        q[:, 1] = y, y - l
        sums += np.array(air_functions("torsional").sums(q.ravel(), v, l, numbers)).ravel()
    return dict(zip(AIR_BALANCE, sums.tolist(), strict=True))


# on long elements four places are looked at over edges of e = l + EDGE: the worst of all places of
# the leg
@pytest.mark.parametrize(("l", "missed"), [(1.0, 1e-3), (2.5, 3e-3), (7.5, 0.01), (15.0, 0.03)])
def test_a_leg_through_a_gallerys_flow_takes_its_drag_over_that_height(
    l: float, missed: float
) -> None:
    sums = [upright(GALLERY, top, l) for top in np.linspace(18.0, 18.0 + l, 10, endpoint=False)]
    # per m/s in X and Z, of 5 m/s: rho_a c_d d |u| u h / 2
    side = 0.5 * 1.2 * 1.2 * 0.044 * 5.0 * 4.3
    for axis, speed in (("x", 3.0), ("z", -4.0)):
        assert_allclose([one[f"air_f{axis}"] for one in sums], speed * side, rtol=missed)
    # at the gallery's height on average
    assert np.mean([one["air_mz"] for one in sums]) == pytest.approx(11.0 * 3.0 * side, rel=missed)


@pytest.mark.parametrize("fidelity", ELEMENT_DOF)
def test_the_tangent_is_the_derivative_to_the_speed(fidelity: ElementFidelity) -> None:
    air = air_functions(fidelity)
    q, v = moved(fidelity, 1)
    law = LAW._replace(buffet=0.8, height=3.0, spacing=2.0, cross_y=-0.5, cross_height=1.5)
    passing = [*law.numbers(), *(-1.0, -2.0, 0.5, 4.0), *(1.5, 0.5, -0.2, -5.0)]
    J = np.array(air.tangent(q, v, 2.0, passing, 1.0))
    assert np.abs(J - np.array(air.tangent(q, v, 2.0, A, 1.0))).max() > 0.01
    assert_allclose(
        J,
        difference(lambda x: np.array(air.residual(q, x, 2.0, passing)).ravel(), v, 1e-6),
        atol=1e-8,
    )
    assert_allclose(J, J.T, atol=1e-15)
    assert np.abs(J).max() > 0.01


def gust() -> BalanceRope:
    """``scene``'s rope in still air, into which the host blows across its plane from .1 s on."""
    shafts = [Shaft(air=Air(density=1.2, vz=vz), sump=Sump(level=-20.0)) for vz in (0.0, 20.0)]
    still, blown = (replace(scene(), shaft=shaft) for shaft in shafts)
    rope = balance_rope(still)
    for k in followed(rope, lambda _: (EndMotion(), EndMotion()), 30, STEP):
        if k == 10:
            assert abs(rope.signals()["loop.z"]) < 1e-3
            rope.retune(blown)
    return rope


def test_a_host_blows_gusts_between_steps() -> None:
    native = gust()
    # pushed all along for t, a free rope is aside by f t^2 / (2 rho): the middle feels nothing of
    # its ends yet.  A load that jumps between steps comes in over the step behind it, half a step
    # late
    t = 20 * STEP - 0.5 * STEP
    pushed = 0.5 * 1.2 * 1.2 * Rope().diameter * 20.0**2 * t**2 / (2 * Rope().mass_per_length)
    assert native.signals()["loop.z"] == pytest.approx(pushed, rel=0.05)
    assert native.state.audit.missing_force < 1e-3 * native.state.audit.force
    energy = native.state.energy_balance
    assert abs(energy.residual) < 0.02 * abs(energy.given_to_air)


@pytest.mark.parametrize(
    "flow_across", [{}, {"vx": -3.0, "vz": 3.0, "cross_y": -2.5, "cross_height": 2.0}]
)
def test_what_a_rope_loses_to_the_air_is_in_the_energy_balance(
    flow_across: dict[str, float],
) -> None:
    """Denser than air, so that it counts: the drag takes a good part of the work done."""
    dense = replace(scene(), shaft=Shaft(air=Air(density=50.0, **flow_across)))
    energy = wound(balance_rope(dense, "native"), ends, 100).state.energy_balance
    assert energy.given_to_air > 0.2 * energy.work_ends > 10
    assert abs(energy.residual) < 2e-3 * energy.given_to_air


def test_a_leg_hangs_aside_below_a_gallery() -> None:
    """Above it each leg pulls what blew on it, F, with its tension, which is the weight below: rho g y z' = F."""
    rope = Rope(length=60.0)
    speed = 10.0
    h = 5.0
    air = Air(density=1.2, drag=1.2, vz=speed, cross_height=h, cross_y=-8.0)
    of = Scene(rope=rope, mesh=Mesh("eem", elements=120), shaft=Shaft(air=air))
    found = hung(balance_rope(of, "native")).signals()
    f = 0.5 * 1.2 * 1.2 * rope.diameter * speed**2
    # heights above those where the legs' tension, the weight of half the rope at its end, would be
    # 0
    top = 30.0
    roof = 30.0 - 5.5
    floor = 30.0 - 10.5
    aside = (
        f
        * (h * np.log(top / roof) + h - floor * np.log(roof / floor))
        / (rope.mass_per_length * 9.81)
    )
    # the clamped end turns into the slope over sqrt(EI/T)
    weight = rope.mass_per_length * 9.81 * top
    aside -= f * h / weight * np.sqrt(rope.EI / weight)
    assert found["loop.z"] == pytest.approx(aside, rel=0.01)
    assert found["left.fz"] + found["right.fz"] == pytest.approx(2 * f * h, rel=1e-3)


def short_rope(**parts: Any) -> BalanceRope:
    solver = Solver(step_max=STEP, tolerance=1e3)
    scene = Scene(
        Rope(length=6.0, EI=100.0), Layout(0.6), mesh=Mesh("eem", elements=10), solver=solver
    )
    return hung(balance_rope(scene.with_(**parts)))


def pushing(t: float, h: float) -> PointForces:
    s = np.array([1.0, 1.3, 3.0, 4.7])
    way = np.array([[0.0, 0.0, 9.0], [3.0, 1.0, 2.0], [0.0, 20.0, 5.0], [-4.0, 0.0, 6.0]])
    return PointForces(s, way * math.sin(3.0 * t), way * math.sin(3.0 * (t + h)), t, t + h)


def push(rope: BalanceRope, steps: int, start: int = 0) -> BalanceRope:
    for k in range(start, start + steps):
        rope.apply(pushing(k * STEP, STEP))
        assert rope.advance_to((k + 1) * STEP, EndMotion(), EndMotion()).valid
    return rope


def test_a_rope_at_rest_under_a_force_pulls_with_it_at_its_ends() -> None:
    rope = short_rope()
    force = np.array([[2.0, -30.0, 4.0]])
    before = rope.signals(["left.fx", "right.fx", "left.fy", "right.fy", "left.fz", "right.fz"])
    ramp = PointForces(np.array([2.0]), 0 * force, force, 0.0, 2.0)
    rope.apply(ramp)
    held: dict[str, float] = {}
    for k in range(1500):
        assert rope.advance_to((k + 1) * STEP, EndMotion(), EndMotion()).valid
        if k > 500:
            for name, value in rope.signals([*before]).items():
                mean = held.get(name, value)
                held[name] = mean + 0.01 * (value - mean)
    gained = {name: held[name] - before[name] for name in before}
    # swings about the new rest, with hardly any damping, are averaged
    for axis, of in zip("xyz", force[0], strict=True):
        assert gained[f"left.f{axis}"] + gained[f"right.f{axis}"] == pytest.approx(of, abs=0.5)


def test_their_work_and_their_impulse_are_in_the_balances() -> None:
    rope = push(short_rope(), 100)
    energy = rope.state.energy_balance
    audit = rope.state.audit
    assert energy.work_ends > 0.5
    # what the integrator dissipates at 10 ms
    assert abs(energy.residual) < 1e-3 * energy.work_ends
    # of some 30 N
    assert audit.missing_force < 0.03


def test_the_displacement_is_what_the_next_step_moves_its_places_by() -> None:
    rope = push(short_rope(), 20)
    t = 20 * STEP
    size = 1e-3
    saved = rope.snapshot()
    given = pushing(t, STEP)
    ends = []
    for part in (0.0, 1.0):
        rope.restore(saved)
        rope.apply(
            PointForces(
                given.s, given.at_start, given.at_stop + part * size * given.at_start, t, t + STEP
            )
        )
        assert rope.advance_to(t + STEP, EndMotion(), EndMotion()).valid
        ends.append(rope.rows())
    moved = rope.displacement(given)
    # the loop's place is a node: the fifth of ten elements ends there
    assert_allclose(
        (ends[1] - ends[0])[5, 1:4] / size, moved[2], rtol=2e-2, atol=1e-3 * np.abs(moved).max()
    )


def test_no_forces_change_no_bit_and_given_again_after_restoring_they_go_on_bit_by_bit() -> None:
    rope = short_rope()
    alone = short_rope()
    nothing = pushing(0.0, STEP)
    rope.apply(PointForces(nothing.s[:0], nothing.at_start[:0], nothing.at_stop[:0], 0.0, STEP))
    for one in (rope, alone):
        assert one.advance_to(STEP, EndMotion(y=1e-3, vy=0.1), EndMotion()).valid
    assert_array_equal(rope.state.motion.q, alone.state.motion.q)
    one = push(short_rope(), 10)
    saved = one.save()
    other = short_rope()
    other.restore(saved)
    assert_array_equal(push(other, 5, 10).state.motion.q, push(one, 5, 10).state.motion.q)


def test_a_rope_that_chooses_its_model_takes_the_one_that_feels_forces() -> None:
    rope = short_rope(model=Model("auto", force_tolerance=1.0))
    assert rope.fidelity == "rigid"
    rope.apply(pushing(0.0, STEP))
    assert rope.advance_to(STEP, EndMotion(), EndMotion()).valid
    assert (rope.fidelity, rope.fidelity_reason[:21]) == ("torsional", "the rigid model canno")
    assert hung(rope).fidelity_reason == "forces are applied to places of the rope"


@pytest.mark.parametrize("inert", [{"density": 1.2, "drag": 0.0}, {"density": 0.0, "drag": 1.2}])
def test_air_without_density_or_drag_acts_nowhere(inert: dict[str, float]) -> None:
    """Neither on the motion, nor on the choice of the model, nor on what the reference rope knows."""
    blown = Air(vx=3.0, vy=-1.0, vz=2.0, buffet=1.0, **inert)
    assert air_acts(blown, Rope().diameter) == 0
    assert air_acts(replace(blown, density=1.2, drag=1.2), Rope().diameter) == 1
    short = Scene(
        Rope(length=LENGTH, Qb=0.0, Qc=0.0), mesh=Mesh("eem", elements=10), model=Model("auto", 1.0)
    )
    in_wind = short.with_(shaft=Shaft(air=blown))
    ropes = [wound(balance_rope(scene), ends, 10, STEP) for scene in (short, in_wind)]
    assert ropes[0].fidelity == ropes[1].fidelity == "planar"
    assert_array_equal(*(rope.state.motion.q for rope in ropes))
    assert unpublished(in_wind.with_(model=Model())) is None


#: a law of the air that acts without drag, a force per length along X, as docs/extending.md adds it
SECOND_LAW = {
    "shaft_parameters.py": (
        (
            '    vx: float = _velocity("X", _ACROSS)\n',
            '    push: float = parameter(0.0, "N/m", "force", Bounds(-9.0, 9.0, "use 0 for none"))\n'
            '    vx: float = _velocity("X", _ACROSS)\n',
        ),
    ),
    "physics/air.py": (
        ("dot, sqrt, where\n", "dot, logical_or, sqrt, where\n"),
        (
            "    cross_height: float  # height of the gallery's mouth\n",
            "    cross_height: float  # height of the gallery's mouth\n    push: float\n",
        ),
        ("spacing, *cross)\n", "spacing, *cross, air.push)\n"),
        (
            "    return where(drag_factor(air, diameter) > 0, 1.0, 0.0)\n",
            "    acts = logical_or(drag_factor(air, diameter) > 0, air.push != 0)\n"
            "    return where(acts, 1.0, 0.0)\n",
        ),
        (
            "    force = [-air.factor * size * x for x in across]\n",
            "    force = [-air.factor * size * x for x in across]\n"
            "    force[0] = force[0] + air.push\n",
        ),
    ),
}
#: prints the forces along X of a rope of 10 m at rest without drag under 3 N/m, why it takes the
#: complete model, why it is no reference rope, and its warnings in motion
PUSHED = """
import json
from rope_model import EndMotion, Mesh, Rope, Scene, Shaft, balance_rope
from rope_model.reference.scope import unpublished
from rope_model.shaft_parameters import Air
air = Air(push=3.0)
scene = Scene(Rope(length=10.0), mesh=Mesh("eem", elements=10), shaft=Shaft(air=air))
rope = balance_rope(scene)
status = rope.initialize(0.0, EndMotion(), EndMotion())
assert status.valid, status.message
forces = [*rope.signals(["left.fx", "right.fx"]).values()]
for k in range(1, 21):
    t = 0.01 * k
    up = EndMotion(y=t**3, vy=3 * t**2, ay=6 * t)
    status = rope.advance_to(t, EndMotion(), up)
    assert status.valid, status.message
reasons = [rope.fidelity_reason, unpublished(scene)]
print(json.dumps({"forces": forces, "reasons": reasons, "warnings": rope.warnings()}))
"""


@pytest.mark.slow
def test_an_engine_with_a_second_law_of_the_air_feels_it_without_drag(tmp_path: Path) -> None:
    """Force and momentum: a copy of the package, with the law added in the two files of the recipe, is compiled."""
    package = tmp_path / "rope_model"
    shutil.copytree(ROOT / "rope_model", package, ignore=shutil.ignore_patterns("__pycache__"))
    for name, changes in SECOND_LAW.items():
        text = (package / name).read_text(encoding="utf-8")
        for old, new in changes:
            assert text.count(old) == 1, (name, old)
            text = text.replace(old, new)
        (package / name).write_text(text, encoding="utf-8")
    own = {"PYTHONPATH": str(tmp_path), "BALANCE_ROPE_CACHE": str(tmp_path / "cache")}
    done = subprocess.run(
        [sys.executable, "-c", PUSHED],
        cwd=tmp_path,
        env=os.environ | own,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    # the sum along the rope, whatever its shape; the statics balance to rounding of its stiffness
    assert_allclose(sum(found["forces"]), 3.0 * 10.0, rtol=1e-6)
    assert "missing_loads" not in found["warnings"]
    of_model, of_reference = found["reasons"]
    assert of_model == "the air may carry the rope along"
    assert of_reference.startswith("air.push = 3 must be 0 for the reference rope")
