"""The swivel: chattering near zero rate.

The scene hangs a 30 m rope and twists it by the left conveyance's yaw; the left end has the swivel.
"""

import math

import numpy as np

from evidence.claims import above, below
from evidence.ropes import require, smooth_step
from evidence.stability.entry import Entry, Finding, points
from evidence.tables import Array
from rope_model.numerics.generalized_alpha import restart
from rope_model.parameters import Rope, Scene, Swivel
from rope_model.physics.node import ANGLE
from rope_model.rules import quintic
from rope_model.rules.end_paths import EndMotion, EndPath
from rope_model.rules.swivel_phases import Phase, SwivelState
from rope_model.simulation.simulator import RopeSimulator
from rope_model.solver_parameters import Mesh, Model

LENGTH = 30.0  # m
UNCOUPLED = Rope(length=LENGTH, Qb=0.0, Qc=0.0)


def hang(left: Swivel) -> RopeSimulator:
    """At rest with both conveyances at height zero."""
    mesh, model = Mesh(kind="eem", elements=40), Model("torsional")
    simulator = RopeSimulator(Scene(rope=UNCOUPLED, left=left, mesh=mesh, model=model))
    require(simulator.initialize(0.0, EndMotion(), EndMotion()))
    return simulator


def relative(rope: RopeSimulator) -> tuple[float, float]:
    """Angle (rad) and rate (rad/s) of the left swivel."""
    m = rope.state.motion
    return rope.ends.relative(0, m.t, m.q[0, ANGLE], m.v[0, ANGLE])


# chattering

YAW, TURNED, END, H = 0.8, 1.0, 4.0, 0.01  # rad, s, s, s


def turn(t: float) -> EndMotion:
    """The left conveyance yaws by YAW until TURNED, then stands."""
    _, value, rate, _ = smooth_step(t / TURNED)
    return EndMotion(yaw=YAW * value, yaw_rate=YAW / TURNED * rate)


def explicit_sign(rope: RopeSimulator) -> Array:
    """Rates (rad/s) at the communication points with friction of the sign the rate had at the step's start."""
    model, rates = rope.model, [0.0]
    for k in range(1, round(END / H) + 1):
        state, (angle, rate) = rope.state, relative(rope)
        paths = _led(state.paths[0], k * H, turn(k * H)), _led(state.paths[1], k * H, EndMotion())
        slip = SwivelState(Phase.SLIP, angle, math.copysign(1.0, rate))
        state = state._replace(swivels=(slip, state.swivels[1]), paths=paths)
        system, motion = model.system(state), state.motion
        if k == 1:
            motion, _ = restart(system, motion.t, motion.q, motion.v, motion.reaction)
        result = model.trial(system, motion, k * H - motion.t)
        if result.motion is None:
            raise RuntimeError(result.newton.status.value)
        rope.restore(model.commit(state, system, result))
        rates.append(relative(rope)[1])
    return np.array(rates)


def _led(path: EndPath, stop: float, target: EndMotion) -> EndPath:
    """From the end of ``path`` to ``target`` at ``stop``, whatever that takes."""
    places, speeds, accelerations = path.motion(path.stop)
    then = (
        (*target.position, target.yaw),
        (*target.velocity, target.yaw_rate),
        (*target.acceleration, 0.0),
    )
    axes = zip(places, speeds, accelerations, *then, strict=True)
    x, y, z, yaw = (quintic.coefficients(stop - path.stop, *axis) for axis in axes)
    return EndPath(path.stop, stop, (x, y, z, yaw))


def locate(rope: RopeSimulator) -> tuple[Array, list[str]]:
    """Rates (rad/s) at the communication points, and what the swivel did, by the simulator's own switching."""
    rates, events = [0.0], []
    for k in range(1, round(END / H) + 1):
        require(rope.advance_to(k * H, turn(k * H), EndMotion()))
        rates.append(relative(rope)[1])
        events += [event.what for event in rope.state.events]
    return np.array(rates), events


def measure_chattering() -> Finding:
    bearing = Swivel(mode="coulomb", mu_static=0.08, mu_kinetic=0.04)
    chattering = explicit_sign(hang(bearing))
    rope = hang(bearing)
    rates, events = locate(rope)
    times: Array = H * np.arange(rates.size, dtype=float)
    standing = times > TURNED
    kinetic = rope.ends.friction(0, rope.state.motion.q, rope.state.motion.reaction, kinetic=True)
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
