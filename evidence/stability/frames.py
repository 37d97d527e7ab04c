"""Frames of the cross-section that break: Tait-Bryan angles, Frenet's frame, and none at all."""

from __future__ import annotations

import math

import numpy as np

from evidence.claims import above, below
from rope_model.parameters import Mesh, Rope, Scene, Solver
from rope_model.simulation.ends.paths import EndMotion
from rope_model.simulation.simulator import RopeSimulator

from .counterexamples import modified_element, no_rate, tait_bryan_rate
from .entry import Entry, Finding
from .trips import hang

# Tait-Bryan angles

TURNED = Scene(
    rope=Rope(length=30.0), mesh=Mesh(kind="eem", elements=40), solver=Solver(step_max=0.02, kernels="portable")
)


def turn(angle: float, duration: float, t: float) -> tuple[EndMotion, EndMotion]:
    """Both conveyances turning together about Y, 1 m from the axis."""
    s = min(t / duration, 1.0)
    a = angle * (10 * s**3 - 15 * s**4 + 6 * s**5)
    w = angle / duration * 30 * s**2 * (1 - s) ** 2
    e = angle / duration**2 * (60 * s - 180 * s**2 + 120 * s**3)
    c, d = math.cos(a), math.sin(a)
    left, right = (
        EndMotion(
            x=r * c - r,
            z=-r * d,
            vx=-r * d * w,
            vz=-r * c * w,
            ax=-r * (c * w * w + d * e),
            az=-r * (c * e - d * w * w),
            yaw=a,
            yaw_rate=w,
        )
        for r in (-1.0, 1.0)
    )
    return left, right


def turn_through(scene: Scene, angle: float, duration: float) -> RopeSimulator:
    """The rope after its ends have turned, or where it stopped."""
    rope = hang(scene)
    for k in range(round(duration / 0.02)):
        t = (k + 1) * 0.02
        status = rope.advance_to(t, *turn(angle, duration, t))
        if not status.valid:
            break
    return rope


def tait_bryan() -> Finding:
    """Yaw of the loop while its ends turn by 180 degrees."""
    duration = 6.0

    def yaw(rope: RopeSimulator) -> float:
        return math.degrees(rope.state.loop_yaw)

    ours = turn_through(TURNED, math.pi, duration)
    with modified_element(frame_rate=tait_bryan_rate):
        counterexample = turn_through(TURNED, math.pi, duration)
    return Finding(
        # the singularity is at 90 degrees: a wall that the loop, swinging, passes by a tenth at most
        counterexample=(
            below("loop yaw when the ends have turned by 180 deg, Tait-Bryan", yaw(counterexample), 99.0, "deg"),
        ),
        ours=(
            # the loop lags on the way and swings past the ends afterwards
            above("loop yaw when the ends have turned by 180 deg", yaw(ours), 170.0, "deg"),
        ),
    )


# no frame


def yaw_and_torque(twist: float) -> tuple[float, float]:
    """Loop yaw (deg) and torque (N m) of an uncoupled 120 m rope that is fastened with ``twist`` (rad)."""
    rope = hang(Scene(rope=Rope(Qb=0.0, Qc=0.0, installed_twist=twist), solver=Solver(kernels="portable")))
    return math.degrees(rope.loop.yaw), rope.ends.moment(1, rope.state.motion.reaction)


def theta_prime() -> Finding:
    """Loop yaw over torque, with and without the frame's own twist in the torsional strain."""
    twists = np.array([0.02, 0.04, 0.06, 0.08])
    ours = np.array([yaw_and_torque(x) for x in twists])
    with modified_element(frame_rate=no_rate):
        counterexample = np.array([yaw_and_torque(x) for x in twists])
    rates = [abs(x[0, 0] / x[0, 1]) for x in (ours, counterexample)]
    return Finding(
        counterexample=(below("loop yaw per torque, tau = theta'", rates[1], 1e-6, "deg/(N m)"),),
        ours=(
            # 1.23 deg at 1 N m, independently calculated; the theory asks for 2 %
            below("error of the loop yaw per torque of 1.23 deg/(N m)", 100 * abs(rates[0] / 1.23 - 1), 2.0, "%"),
        ),
    )


ENTRIES = (
    Entry("tait-bryan", "Tait-Bryan angles at 90 degrees of loop yaw", tait_bryan, slow=True),
    Entry("theta-prime", "Torsional strain without the frame's twist", theta_prime, slow=True),
)
