"""Swivels: friction law, stick without creep, located switching, energy; at a rest that friction can hold."""

import re
from dataclasses import replace
from functools import partial
from typing import Literal

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import Ends, followed, hung, smooth_step, smooth_trip, wound
from scipy.integrate import solve_ivp

from rope_model import (
    BalanceRope,
    EndMotion,
    Mesh,
    Model,
    PointForces,
    Rope,
    Scene,
    Solver,
    Swivel,
    balance_rope,
)
from rope_model.boundary.end_conditions import YAW_SENSE
from rope_model.codegen.build import written
from rope_model.codegen.formula_functions import formulas_code
from rope_model.method import swivel_phases
from rope_model.method.statics import lacks_symmetry
from rope_model.method.swivel_phases import Phase, SwivelState, swivel_excess
from rope_model.physics.swivel import Friction, friction_law, friction_moment
from rope_model.reference.ends import EndQuintic, onwards
from rope_model.reference.rope import ReferenceRope
from rope_model.reference.swivel import Ends as ReferenceEnds
from rope_model.state import Event

# a short soft rope whose axial waves an explicit reference integrator can follow
SOFT = Rope(length=8.0, Qa=2e4, Qb=0.0, Qc=0.0, Qd=10.0, EI=60.0, rhoJ=0.02, beta_K=2e-3)
STIFF_BEARING = Swivel(mode="coulomb", mu_static=0.02, mu_kinetic=0.014, start="locked")


def scene(step: float = 2e-3, **swivels: Swivel) -> Scene:
    solver = Solver(step_max=step, tolerance=1.0, newton_tolerance=1e-10)
    mesh = Mesh(kind="eem", elements=8)
    model = Model(fidelity="torsional")
    return Scene(rope=SOFT, mesh=mesh, solver=solver, model=model, **swivels)


#: rad by which the right conveyance yaws
YAW = 1.5
YAWED = 1.2  #: s, when it has yawed
END = 2.4  #: s, until which it stands


def twist(data: Scene) -> tuple[BalanceRope, tuple[Event, ...]]:
    rope = hung(balance_rope(data))
    events = ()
    for t in (YAWED, END):
        assert rope.advance_to(t, EndMotion(), EndMotion(yaw=YAW)).valid
        events += rope.state.events
    return rope, events


def test_friction_follows_the_tension_and_never_turns_negative() -> None:
    assert_allclose(
        friction_moment(friction_law(0.0018, 0.09, 0.2), 4700.0),
        0.2 + 0.5 * 0.0018 * 0.09 * 4700.0,
        rtol=1e-15,
    )
    assert friction_moment(friction_law(0.1, 0.09, 0.2), -500.0) == 0.2


def _another_law(mu: float, mean_diameter: float, seal_moment: float) -> Friction:
    law = friction_law(mu, mean_diameter, seal_moment)
    return Friction(constant=law.constant + 0.375, per_tension=3.0 * law.per_tension)


@pytest.mark.parametrize("tension", [4700.0, -500.0])
@pytest.mark.parametrize("mode", ["coulomb", "free"])
def test_equations_and_outputs_follow_one_friction_law(
    mode: Literal["coulomb", "free"], tension: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    bearing = replace(STIFF_BEARING, mode=mode, seal_moment=0.25)
    start = hung(balance_rope(scene(left=bearing, right=bearing), form="reference")).state
    slipping = SwivelState(Phase.SLIP, 0.0, -1.0)
    ends = replace(start.ends(scene(left=bearing, right=bearing)), swivels=(slipping, slipping))
    reaction = np.zeros_like(start.motion.q)
    reaction[:, 1] = tension
    moments = []
    for law in (friction_law, _another_law):
        monkeypatch.setattr(swivel_phases, "friction_law", law)
        equations = ends.equations(start.mesh, start.motion.q)
        output = ends.moment(0, replace(start.motion, reaction=reaction))
        assert output == equations.load[0, 6] + equations.friction[0] * max(tension, 0.0)
        moments.append(output)
    expected = 0.25 + 0.5 * 0.014 * bearing.mean_diameter * max(tension, 0.0)
    another = 0.625 + 3.0 * (expected - 0.25)
    assert_allclose(moments, [expected, another] if mode == "coulomb" else 0.0, rtol=1e-14)


def test_all_c_of_a_swivels_friction_follows_one_law(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(swivel_phases, "friction_law", _another_law)
    code = formulas_code()
    for name in (
        "swivel_phases_frictionless",
        "swivel_phases_kinetic_friction",
        "swivel_phases_slip_constant",
        "swivel_phases_beyond_rest",
        "moment_of_swivel",
        "swivel_excess",
    ):
        text = code.partition(f"double {name}(")[2].partition("\n}\n")[0]
        assert "seal_moment + 0.375" in text, name
    for path in written():  # nor does C that is not generated repeat it
        text = path.read_text(encoding="utf-8")
        assert not re.search("mu_kinetic|mu_static|mean_diameter|seal_moment", text), path.name


def test_stick_does_not_creep() -> None:
    seized = replace(STIFF_BEARING, mu_static=1.0, mu_kinetic=0.9)
    rope, events = twist(scene(left=seized, right=seized))
    assert events == ()
    for side in ("left", "right"):
        angle, rate = rope.signals((f"{side}.swivel.angle", f"{side}.swivel.rate")).values()
        # exact but for the rounding of theta = offset + yaw + b
        assert abs(angle) < 1e-12
        assert abs(rate) < 1e-12


class Stopping(EndQuintic):
    """Path that rests after its end."""

    def at(self, t: float) -> np.ndarray:
        found = super().at(min(t, self.stop))
        if t > self.stop:
            found[1:] = 0.0
        return found


class Phased:
    """The equations of the reference with both swivels in given phases, for scipy: y = (q, v)."""

    def __init__(self, start: ReferenceRope, ends: ReferenceEnds, since: float) -> None:
        self.ends = ends
        self.since = since
        q = start.state.motion.q
        self.shape = q.shape
        self.equations = ends.equations(start.state.mesh, q)

    def motion(self, t: float, y: np.ndarray) -> tuple[np.ndarray, ...]:
        held = self.equations.held
        q, v, a = self.equations.held_motion(t)
        q = np.where(held, q, y[: q.size].reshape(self.shape))
        v = np.where(held, v, y[q.size :].reshape(self.shape))
        a = np.where(held, a, 0.0)
        # the residual is linear in the accelerations, also by its friction
        R, mass = self.equations.linearised(q, v, a, (0.0, 0.0, 1.0), prestress=q)
        return q, v, a + mass.solve(-R)

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        _, v, a = self.motion(t, y)
        return np.concatenate((v.ravel(), a.ravel()))

    def may_stay(self, side: int, t: float, y: np.ndarray) -> float:
        """Positive while the swivel may stay in its phase."""
        q, v, a = self.motion(t, y)
        state = self.ends.swivels[side]
        if state.phase is Phase.SLIP:
            yaw_rate = self.ends.paths[side].at(t)[1, 3] * YAW_SENSE[side]
            rate = float(state.sign * (v[-side, 6] - yaw_rate))
            # just after release the rate is zero: look a little later
            if t < self.since + 1e-4:
                rate += 1e-3
            return rate
        reaction = self.equations.residual(q, v, a)
        hold = 0.5 * STIFF_BEARING.mu_static * STIFF_BEARING.mean_diameter
        return float(hold * reaction[-side, 1] - abs(reaction[-side, 6]))

    def next_state(self, side: int, t: float, y: np.ndarray) -> SwivelState:
        q, v, a = self.motion(t, y)
        state = self.ends.swivels[side]
        if state.phase is Phase.STICK:
            moment = self.equations.residual(q, v, a)[-side, 6]
            return state._replace(phase=Phase.SLIP, sign=-np.sign(moment))
        yaw = YAW_SENSE[side] * self.ends.paths[side].at(t)[0, 3]
        return SwivelState(Phase.STICK, float(q[-side, 6] - self.ends.offsets[side] - yaw), 0.0)


def reference_events(
    start: ReferenceRope, ends: ReferenceEnds, duration: float
) -> list[tuple[float, int, Phase]]:
    q = start.state.motion.q
    time = 0.0
    y = np.concatenate((q.ravel(), np.zeros(q.size)))
    events = []
    states = [state._replace(phase=Phase.STICK) for state in ends.swivels]
    while time < duration:
        rope = Phased(start, replace(ends, swivels=(states[0], states[1])), time)
        leaves = [partial(rope.may_stay, side) for side in (0, 1)]
        for event in leaves:
            event.terminal = True
            event.direction = -1
        # far below what the instants may differ by; stability keeps the steps short
        exact: dict[str, float] = {"rtol": 1e-8, "atol": 1e-9, "max_step": 0.02}
        solution = solve_ivp(rope.rates, (time, duration), y, "DOP853", events=leaves, **exact)
        time = float(solution.t[-1])
        y = solution.y[:, -1]
        hit = [side for side in (0, 1) if solution.t_events[side].size]
        for side in hit:
            states[side] = rope.next_state(side, time, y)
            events.append((time, side, states[side].phase))
        if not hit:
            break
    return events


def test_switching_instants_agree_with_an_independent_event_located_solution() -> None:
    bearings = {"left": STIFF_BEARING, "right": STIFF_BEARING}
    start = hung(ReferenceRope(scene(**bearings)))
    errors: list[float] = []
    for step in (2e-3, 1e-3):
        _, events = twist(scene(step, **bearings))
        if not errors:
            ends = start.state.ends(start.scene)
            left, right = (
                onwards(path, YAWED, EndMotion(yaw=yaw), age=0.0)
                for path, yaw in zip(ends.paths, (0.0, YAW), strict=True)
            )
            moving = replace(ends, paths=(Stopping(**vars(left)), Stopping(**vars(right))))
            expected = reference_events(start, moving, END)
        assert len(events) == len(expected) >= 3
        assert [("left", "right").index(e.what.split()[0]) for e in events] == [
            side for _, side, _ in expected
        ]
        errors.append(max(abs(e.t - t) for e, (t, _, _) in zip(events, expected, strict=True)))
    # second order in the step: a quarter, and the first error as small as the step squared times
    # the rates allow
    assert errors[0] < 2e-3
    assert errors[1] < 0.35 * errors[0]


def test_friction_only_takes_energy_and_the_balance_closes() -> None:
    def yawing(t: float) -> Ends:
        yaw, rate, _ = (YAW * x for x in smooth_step(t, 0.0, YAWED))
        return EndMotion(), EndMotion(yaw=yaw, yaw_rate=rate)

    residuals = []
    for step in (2e-3, 1e-3):
        rope = balance_rope(scene(step, left=STIFF_BEARING, right=STIFF_BEARING))
        dissipated = [
            rope.state.energy_balance.dissipated_swivel for _ in followed(rope, yawing, 60, 0.02)
        ]
        assert np.all(np.diff(dissipated) >= -1e-15)
        assert dissipated[-1] > 0.01
        residuals.append(rope.state.energy_balance.residual)
    # the method and the trapezoidal rule of the powers are of second order, and events are located:
    # the balance closes with the square of the step, up to terms of the next order (found: 4.02)
    assert_allclose(residuals[0] / residuals[1], 4.0, rtol=0.05)


def test_release_at_its_time_and_not_before() -> None:
    late = replace(STIFF_BEARING, release_time=0.5, mu_static=0.001, mu_kinetic=0.001)
    _, events = twist(scene(left=late, right=Swivel()))
    assert events
    assert_allclose(events[0].t, 0.5, rtol=0, atol=1e-12)
    assert all(event.t >= 0.5 for event in events)


SIDES = ("left", "right")
HEALTHY = Swivel(mode="coulomb")
FREE = Swivel(mode="free")
ROPE = Rope(length=40.0)
RIGHT = EndMotion(y=20.0)
PLAIN = Scene(rope=ROPE, mesh=Mesh("eem", elements=24), left=HEALTHY, right=HEALTHY)
CURVED = Rope(length=40.0, initial_curvature=0.3, initial_curvature_angle=0.8)
SCENES = {
    "healthy": PLAIN,
    "one seized": PLAIN.with_(left=Swivel(), rope=Rope(length=40.0, installed_twist=1.0)),
    "free": PLAIN.with_(left=FREE, right=FREE),
    "one coefficient": PLAIN.with_(
        left=replace(HEALTHY, mu_static=0.0013), right=replace(HEALTHY, mu_static=0.0013)
    ),
    # locked, its loop would wind up by more than a turn
    "twisted": PLAIN.with_(rope=Rope(length=40.0, installed_twist=15.0)),
    # its torque is not the same all along: both swivels slide
    "curved": PLAIN.with_(rope=CURVED),
}


def limit(rope: BalanceRope, swivel: Swivel, side: str) -> float:
    """Moment (N m) that the bearing holds, from the end's tension; the statics end within some 1e-8 N m."""
    if swivel.mode == "free":
        return 0.0
    if swivel.mode == "locked":
        return 1e3
    tension = -rope.signals()[f"{side}.fy"]
    law = friction_law(swivel.mu_static, swivel.mean_diameter, swivel.seal_moment)
    return friction_moment(law, tension)


@pytest.mark.parametrize("name", SCENES)
def test_friction_holds_the_rope_at_the_start_and_nothing_moves_then(name: str) -> None:
    scene = SCENES[name]
    rope = hung(balance_rope(scene), right=RIGHT)
    start = rope.signals()
    saved = rope.save()
    for side, swivel in zip(SIDES, (scene.left, scene.right), strict=True):
        assert abs(start[f"{side}.swivel.torque"]) <= limit(rope, swivel, side) + 1e-8
    for _ in range(2):
        rope.restore(saved)
        for k in range(1, 51):
            assert rope.advance_to(0.02 * k, EndMotion(), RIGHT).valid
        later = rope.signals()
        for key in ("left.swivel.angle", "right.swivel.angle", "loop.yaw", "loop.x", "loop.y"):
            assert abs(later[key] - start[key]) < 1e-7
        if name == "healthy":
            assert later["count.swivel_events"] == 0


@pytest.mark.parametrize("twist", [0.0, 15.0])
def test_the_weaker_swivel_slides_by_the_angle_of_the_torque_that_it_does_not_hold(
    twist: float,
) -> None:
    rope = hung(balance_rope(PLAIN.with_(rope=replace(ROPE, installed_twist=twist))), right=RIGHT)
    now = rope.signals()
    short = 10.0
    long = 30.0
    # of vertical legs with their ends held: D / L times the twist, and by the mean tension; that of
    # 1 m of loop is not
    torsion = ROPE.Qd - ROPE.Qs**2 / ROPE.Qa
    held = (
        ROPE.Qc / ROPE.Qa * ROPE.mass_per_length * 9.81 * (short**2 + long**2) / (2 * ROPE.length)
    )
    law = friction_law(HEALTHY.mu_kinetic, HEALTHY.mean_diameter, 0.0)
    kinetic = friction_moment(law, -now["left.fy"])
    assert_allclose(now["right.swivel.torque"], kinetic, rtol=1e-6)
    slid = (held - kinetic) * ROPE.length / torsion - 2 * now["loop.yaw"]
    assert_allclose(now["left.swivel.angle"], twist + slid, rtol=0, atol=0.05 * slid)
    assert_allclose(now["right.swivel.angle"], twist, rtol=0, atol=1e-12)


STRONG = replace(HEALTHY, mu_static=1.0, mu_kinetic=0.9)
HELD = {
    "friction that holds": PLAIN.with_(left=STRONG, right=STRONG),
    "released later": PLAIN.with_(
        left=replace(HEALTHY, release_time=0.5), right=replace(HEALTHY, release_time=0.5)
    ),
    "spatial": PLAIN.with_(left=FREE, right=FREE, model=Model("spatial")),
    "planar": PLAIN.with_(model=Model("planar")),
    "rigid": PLAIN.with_(model=Model("rigid")),
}


@pytest.mark.parametrize("name", HELD)
def test_a_swivel_without_cause_to_slide_starts_as_it_was_hung_up(name: str) -> None:
    scene = HELD[name]
    locked = scene.with_(
        left=replace(scene.left, start="locked"), right=replace(scene.right, start="locked")
    )
    one, other = (hung(balance_rope(x), right=RIGHT) for x in (scene, locked))
    assert one.signals() == other.signals()
    assert (one.rows() == other.rows()).all()


def test_a_rope_hung_anew_after_a_trip_rests_within_the_limits_band() -> None:
    dirty = replace(HEALTHY, mu_static=0.02, mu_kinetic=0.015)
    scene = PLAIN.with_(
        left=dirty, right=dirty, rope=replace(ROPE, beta_K=0.02, torsion_damping=10.0)
    )
    rope = wound(
        balance_rope(scene), lambda t: (smooth_trip(t, 10.0, 5.0, 0.0)[0], RIGHT), 3000, 0.02
    )
    assert rope.state.counts.swivel_events > 0
    after = rope.signals()
    anew = hung(balance_rope(scene), EndMotion(y=10.0), RIGHT).signals()
    # the same rope, its ends at the same places: its torque differs by that of its twist, D / L of
    # docs/theory/rope.md
    torsion = (ROPE.Qd - ROPE.Qs**2 / ROPE.Qa) / ROPE.length
    torque, twist = (
        after[f"right.swivel.{key}"] - anew[f"right.swivel.{key}"] for key in ("torque", "angle")
    )
    twist -= after["left.swivel.angle"] - anew["left.swivel.angle"]
    twist -= 2 * (after["loop.yaw"] - anew["loop.yaw"])
    band = 2 * min(limit(rope, dirty, side) for side in SIDES)
    assert abs(torque) <= band
    assert_allclose(torque, torsion * twist, rtol=0, atol=0.05 * band)


def test_a_swivel_is_free_from_the_start_of_a_run_that_begins_before_zero() -> None:
    free = Swivel("free")
    rope = hung(balance_rope(PLAIN.with_(left=free, right=free)), t=-5.0)
    assert rope.advance_to(-4.99, EndMotion(), EndMotion()).valid
    assert [x.phase for x in rope.state.swivels] == [Phase.SLIP, Phase.SLIP]


@pytest.mark.parametrize("phase", [Phase.STICK, Phase.SLIP])
@pytest.mark.parametrize("moment", [0.0, 3.0, 80.0])
def test_events_are_at_the_same_instants_in_any_unit_of_mass(phase: Phase, moment: float) -> None:
    """The function whose root they are does not change by a bit, whatever the other swivel's is compared with."""
    state = SwivelState(phase, 0.0, 1.0)
    one, heavy = (
        swivel_excess(STIFF_BEARING, state, unit * 5e3, unit * moment, 0.1) for unit in (1.0, 8.0)
    )
    assert one == heavy
    assert (one < 0) == (phase is Phase.SLIP or moment < 80.0)


@pytest.mark.parametrize("rounding", [1e-15, 1e-12, 1e-9])
def test_a_rounding_of_the_coupling_leaves_the_rest_as_it_is(rounding: float) -> None:
    """The search takes full corrections, as of a symmetric coupling: shortened by noise they need not converge."""
    air = replace(PLAIN.shaft.air, density=1.2, vz=5.0)
    blown = PLAIN.with_(shaft=replace(PLAIN.shaft, air=air), left=HEALTHY, right=HEALTHY)
    pushed = PointForces(
        np.array([20.0]), np.array([[10.0, 0.0, 40.0]]), np.array([[10.0, 0.0, 40.0]]), -1.0, 10.0
    )
    rests = []
    for excess in (0.0, rounding):
        rope = balance_rope(
            blown.with_(rope=replace(blown.rope, Qb=1e5, Qc=1e5 * (1.0 + excess))), "native"
        )
        rope.apply(pushed)
        rests.append([*hung(rope).signals(["left.fy", "left.my", "right.my", "loop.yaw"]).values()])
    assert lacks_symmetry(1e5, 0.5e5 * rounding) == 0
    assert lacks_symmetry(1e5, 10.0) == 1
    assert_allclose(rests[1], rests[0], rtol=1e-7, atol=1e-6)
