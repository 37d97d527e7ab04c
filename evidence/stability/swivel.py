"""The swivel: chattering near zero rate.

The scene hangs a 30 m rope and twists it by the left conveyance's yaw; the left end has the swivel.
"""

import math
from dataclasses import replace

import numpy as np

from evidence.claims import above, below
from evidence.ropes import AT_ZERO, at_rest, require, smooth_step
from evidence.stability.entry import Entry, Finding, points
from evidence.tables import Array
from rope_model import BalanceRope, EndMotion
from rope_model.method.generalized_alpha import Motion
from rope_model.method.swivel_phases import Phase, SwivelState, kinetic_friction
from rope_model.parameters import Rope, Scene, Swivel
from rope_model.reference.ends import onwards
from rope_model.reference.generalized_alpha import restart, step
from rope_model.reference.state import State
from rope_model.solver_parameters import Mesh, Model

LENGTH = 30.0  # m
UNCOUPLED = Rope(length=LENGTH, Qb=0.0, Qc=0.0)


def scene_of(left: Swivel) -> Scene:
    """Return the scene with this left swivel."""
    return Scene(
        rope=UNCOUPLED,
        left=left,
        mesh=Mesh(kind="eem", elements=40),
        model=Model("torsional"),
    )


# chattering

YAW = 0.8  # rad
TURNED = 1.0  # s
END = 4.0  # s
H = 0.01  # s


def turn(t: float) -> EndMotion:
    """The left conveyance yaws by YAW until TURNED, then stands."""
    _, value, rate, _ = smooth_step(t / TURNED)
    return EndMotion(yaw=YAW * value, yaw_rate=YAW / TURNED * rate)


def explicit_sign(scene: Scene) -> Array:
    """Return the rates (rad/s) of the left swivel at the communication points.

    Its friction has the sign that the rate had at the step's start: the reference rope's step
    without its switching.
    """
    state = at_rest(scene, form="reference").state
    assert isinstance(state, State)
    rates = [0.0]
    for k in range(1, round(END / H) + 1):
        left, right = state.paths
        paths = onwards(left, k * H, turn(k * H), 0.0), onwards(right, k * H, AT_ZERO, 0.0)
        state = replace(state, paths=paths)
        angle, rate = state.ends(scene).relative(0, state.motion)
        slips = SwivelState(Phase.SLIP, angle, math.copysign(1.0, rate))
        state = replace(state, swivels=(slips, state.swivels[1]))
        equations = state.equations(scene)
        motion = state.motion
        if k == 1:
            restarted = restart(equations, motion.t, motion.q, motion.v)
            assert isinstance(restarted, Motion)
            motion = restarted
        tried = step(
            equations, motion, k * H - motion.t, scene.solver.rho_inf, scene.solver.newton_tolerance
        )
        if tried.motion is None:
            raise RuntimeError(f"at t = {motion.t:g} s a step of {H:g} s fails: {tried.cause}")
        state = replace(state, motion=tried.motion).with_angles(equations)
        rates.append(state.ends(scene).relative(0, state.motion)[1])
    return np.array(rates)


def locate(rope: BalanceRope) -> tuple[Array, list[str]]:
    """Return the rates (rad/s) at the communication points, and the events of the rope's own switching."""
    rates = [0.0]
    events = []
    for k in range(1, round(END / H) + 1):
        require(rope.advance_to(k * H, turn(k * H), EndMotion()))
        rates.append(rope.signals(["left.swivel.rate"])["left.swivel.rate"])
        events += [event.what for event in rope.state.events]
    return np.array(rates), events


def measure_chattering() -> Finding:
    bearing = Swivel(mode="coulomb", mu_static=0.08, mu_kinetic=0.04)
    scene = scene_of(bearing)
    chattering = explicit_sign(scene)
    rope = at_rest(scene)
    rates, events = locate(rope)
    times: Array = H * np.arange(rates.size, dtype=float)
    standing = times > TURNED
    tension = -rope.signals(["left.fy"])["left.fy"]
    kinetic = float(kinetic_friction(bearing, tension))
    changes = float(np.count_nonzero(np.diff(np.sign(chattering[standing]))))
    shown = (times > 0.8) & (times < 2.0)
    return Finding(
        counterexample=(
            # a pair of steps there and back at the least often enough to notice: one change in four steps
            above(
                "changes of sign while the conveyance stands", changes, 0.25 * (END - TURNED) / H
            ),
            # friction of a whole step, h M / J, is what the rate can jump by; a tenth of it is no rounding
            above(
                "rate in the last second, largest",
                np.abs(chattering[times > END - 1.0]).max(),
                0.1 * H * kinetic / bearing.inertia,
                "rad/s",
            ),
        ),
        ours=(
            below("times the swivel sticks", sum("sticks" in e for e in events), 2),
            below("switchings in all: slips once, sticks once", len(events), 3),
            below(
                "rate in the last second, largest",
                np.abs(rates[times > END - 1.0]).max(),
                1e-12,
                "rad/s",
            ),
        ),
        curves=points(
            ("time, s", "rate of the swivel, rad/s"),
            {
                "friction by the sign at the step's start": (times[shown], chattering[shown]),
                "ours: located switching": (times[shown], rates[shown]),
            },
        ),
    )


ENTRIES = (
    Entry(
        "swivel-chattering",
        "Friction of the last rate's sign chatters",
        measure_chattering,
        slow=True,
    ),
)
