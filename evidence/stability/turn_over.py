"""Installed twist turns the loop over: plain Newton, and ours."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from evidence.claims import above, below
from rope_model.parameters import Layout, Mesh, Model, Rope, Scene
from rope_model.simulation.ends.ends import Phase, SwivelState
from rope_model.simulation.ends.paths import EndMotion
from rope_model.simulation.mesh.adaptation import with_loop_yaw
from rope_model.simulation.outputs.modal import natural_modes
from rope_model.simulation.rope_system import ANGLE, RopeSystem
from rope_model.simulation.simulator import RopeSimulator
from rope_model.simulation.state import RopeState

from .chain import Solve, by_continuation, by_newton, is_stable, plain_newton
from .entry import Array, Entry, Finding

TWISTS = np.concatenate((np.arange(1.0, 7.0), np.arange(7.0, 9.01, 0.2)))  # rad
LONG = Scene(
    rope=Rope(length=240.0, Qb=0.0, Qc=0.0),
    layout=Layout(spacing=3.0),
    mesh=Mesh(kind="eem", elements=160),
    model=Model("torsional"),
)


def start(scene: Scene) -> RopeSimulator:
    rope = RopeSimulator(scene)
    status = rope.initialize(0.0, EndMotion(), EndMotion())
    if not status.valid:
        raise RuntimeError(status.message)
    return rope


def twist(state: RopeState, angle: float) -> RopeState:
    """The right end turned by ``angle`` (rad) in its conveyance."""
    return state._replace(swivels=(state.swivels[0], SwivelState(Phase.LOCKED, angle, 0.0)))


def find_rest(rope: RopeSimulator, state: RopeState, solve: Solve) -> RopeState | None:
    """At rest by ``solve``."""
    system = rope.model.system(state)
    q = solve(system, state.motion.q)
    if q is None:
        return None
    turn = float(
        q[-1, ANGLE] - system.prescribed_motion(state.motion.t)[0, -1, ANGLE]
    )  # of the frame, the end being held
    offsets = state.offsets[0], state.offsets[1] + turn
    # a loop that yaws by psi turns the frame of the right end by -2 psi
    yaw = state.loop_yaw - 0.5 * turn
    return with_loop_yaw(state._replace(motion=replace(state.motion, q=q), offsets=offsets, loop_yaw=yaw))


def turn(rope: RopeSimulator, solve: Solve) -> list[RopeState]:
    """The rope at rest at each of TWISTS, or as far as ``solve`` gets."""
    state, states = rope.state, []
    for angle in TWISTS:
        found = find_rest(rope, twist(state, float(angle)), solve)
        if found is None:
            break
        state = found
        states.append(state)
    return states


def turn_over(rope: RopeSimulator) -> tuple[RopeState, Array]:
    """The planar loop that a full turn leaves without twist, its legs crossed; and how it is disturbed, 2 cm."""
    q, s = rope.state.motion.q.copy(), rope.state.partition.nodes_s
    part = np.clip(np.minimum(s, s[-1] - s) / (0.45 * s[-1]), 0.0, 1.0)
    mirrored = 1 - 2 * part**2 * (3 - 2 * part)
    q[:, 3] = mirrored * q[:, 3] + q[:, 0] * np.gradient(mirrored, s)
    q[:, 0] *= mirrored
    q[:, [2, 5, ANGLE]] = 0.0
    aside = np.zeros_like(q)
    aside[:, 2] = 0.02 * np.sin(np.pi * s / s[-1]) * np.sin(2 * np.pi * s / s[-1])
    state = rope.state._replace(offsets=(0.0, 0.0), loop_yaw=math.pi)
    return state._replace(motion=replace(state.motion, q=q)), aside


def is_refused(system: RopeSystem, q: Array) -> bool:
    """Whether natural_modes refuses the equilibrium as unstable."""
    try:
        natural_modes(system, q, 2)
    except ValueError:
        return True
    return False


def bifilar_limit(yaw: float, torque: float, scene: Scene) -> float:
    """Twist (rad) past which two legs and a torsion spring have no equilibrium before the full turn.

    M = Qd (twist - 2 yaw) / L and 2 M = K sin(yaw); K from a small yaw and its torque.
    """
    K, k = 2 * torque / math.sin(yaw), 2 * scene.rope.Qd / scene.rope.length
    critical = math.acos(-2 * k / K)
    return 2 * critical + K / k * math.sin(critical)


def measure_turn_over() -> Finding:
    rope = start(LONG)
    newton, ours = turn(rope, by_newton), turn(rope, by_continuation)
    yaws = np.array([state.loop_yaw for state in ours])
    jump = int(np.argmax(np.diff(yaws) > 0.5))  # at most 0.33 rad before
    critical = 0.5 * (TWISTS[jump] + TWISTS[jump + 1])
    first = rope.model.system(ours[0])
    rest = np.zeros_like(ours[0].motion.q)
    torque = float(first.evaluate(ours[0].motion.q, rest, rest, rest).reaction[-1, ANGLE])
    bound = bifilar_limit(ours[0].loop_yaw, torque, LONG)
    unstable = sum(not is_stable(rope.model.system(x), x.motion.q) for x in ours)

    # a full turn at once: the planar loop with crossed legs, disturbed
    planar, aside = turn_over(rope)
    system = rope.model.system(planar)
    flat = plain_newton(system, plain_newton(system, planar.motion.q).q + aside)
    left = find_rest(rope, planar._replace(motion=replace(planar.motion, q=flat.q + aside)), by_continuation)
    assert left is not None
    same = np.interp(2 * math.pi, TWISTS, yaws)

    at_once = find_rest(rope, twist(rope.state, float(TWISTS[-1])), by_continuation)
    assert at_once is not None
    return Finding(
        counterexample=(
            below("Newton: twist from which it finds nothing more", TWISTS[len(newton)], float(TWISTS[-1]), "rad"),
            below(
                "Newton from the disturbed planar loop: distance from the plane", np.abs(flat.q[:, 2]).max(), 1e-6, "m"
            ),
            above("that planar loop is refused as unstable by natural_modes", is_refused(system, flat.q), 0.5),
        ),
        ours=(
            above("yaw at the last twist", yaws[-1], math.pi, "rad"),
            below("the same when it is put in at once: difference", abs(at_once.loop_yaw - yaws[-1]), 1e-3, "rad"),
            below("unstable shapes on the way", unstable, 1),
            # the estimate takes the legs for a pendulum of constant stiffness and knows two twists 0.2 rad apart
            below(
                f"critical twist {critical:.3g} rad against the bifilar estimate {bound:.3g} rad",
                abs(critical / bound - 1),
                0.1,
            ),
            below(
                "from the disturbed planar loop to the yaw that stepwise twisting gives",
                abs(left.loop_yaw - same),
                0.1,
                "rad",
            ),
        ),
    )


ENTRIES = (Entry("turn-over", "The loop turns over when too much twist is put in", measure_turn_over, slow=True),)
