"""A frame of the cross-section that breaks: Tait-Bryan angles."""

import math

from evidence.claims import above, below
from evidence.ropes import at_rest, follow, smooth_step
from evidence.stability.counterexamples import modified_frame, tait_bryan_rate
from evidence.stability.entry import Entry, Finding
from rope_model.boundary.end_paths import EndMotion
from rope_model.parameters import Rope, Scene
from rope_model.public import Form
from rope_model.solver_parameters import Mesh, Solver

# Tait-Bryan angles

#: s of the turn, and of a step
DURATION = 6.0
H = 0.02
TURNED = Scene(
    rope=Rope(length=30.0),
    mesh=Mesh(kind="eem", elements=40),
    solver=Solver(step_max=H),
)


def turn(t: float) -> tuple[EndMotion, EndMotion]:
    """Both conveyances turning together about Y, 1 m from the axis, by 180 degrees."""
    _, value, rate, second = smooth_step(t / DURATION)
    a = math.pi * value
    w = math.pi * rate / DURATION
    e = math.pi * second / DURATION**2
    c = math.cos(a)
    d = math.sin(a)
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


def yaw(form: Form) -> float:
    """Return the yaw (deg) of the loop when its ends have turned."""
    rope = at_rest(TURNED, form=form)
    follow(rope, H, DURATION, turn)
    return math.degrees(rope.state.loop_yaw)


def tait_bryan() -> Finding:
    """Yaw of the loop while its ends turn by 180 degrees."""
    ours = yaw("native")
    with modified_frame(tait_bryan_rate):
        singular = yaw("reference")
    return Finding(
        # the singularity is at 90 degrees: a wall that the loop, swinging, passes by a tenth at most
        counterexample=(
            below(
                "loop yaw when the ends have turned by 180 deg, Tait-Bryan", singular, 99.0, "deg"
            ),
        ),
        # the loop lags on the way and swings past the ends afterwards
        ours=(above("loop yaw when the ends have turned by 180 deg", ours, 170.0, "deg"),),
    )


ENTRIES = (
    Entry("tait-bryan", "Tait-Bryan angles at 90 degrees of loop yaw", tait_bryan, slow=True),
)
