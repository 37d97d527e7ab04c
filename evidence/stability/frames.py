"""A frame of the cross-section that breaks: Tait-Bryan angles."""

from __future__ import annotations

import math

from evidence.claims import above, below
from evidence.stability.counterexamples import modified_element, tait_bryan_rate
from evidence.stability.entry import Entry, Finding
from evidence.stability.trips import hang
from rope_model.parameters import Mesh, Rope, Scene, Solver
from rope_model.simulation.ends.paths import EndMotion
from rope_model.simulation.simulator import RopeSimulator

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


ENTRIES = (Entry("tait-bryan", "Tait-Bryan angles at 90 degrees of loop yaw", tait_bryan, slow=True),)
