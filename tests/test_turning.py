"""The loop turned about the vertical: the frame that stays regular, and the one that does not."""

from __future__ import annotations

import math

import pytest
from numpy.testing import assert_allclose
from tait_bryan import tait_bryan_rate

from rope_model.parameters import Mesh, Rope, Scene, Solver
from rope_model.physics.element import element_functions
from rope_model.simulation import rope_system
from rope_model.simulation.ends import EndMotion
from rope_model.simulation.simulator import RopeSimulator
from rope_model.simulation.statics import find_equilibrium


def turned(angle: float, duration: float, t: float) -> tuple[EndMotion, EndMotion]:
    """Both conveyances turning together about Y, 1 m from the axis."""
    s = min(t / duration, 1.0)
    a = angle * (10 * s**3 - 15 * s**4 + 6 * s**5)
    w = angle / duration * 30 * s**2 * (1 - s) ** 2
    e = angle / duration**2 * (60 * s - 180 * s**2 + 120 * s**3)
    c, d = math.cos(a), math.sin(a)
    return tuple(
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


def turn_through(scene: Scene, angle: float, duration: float) -> tuple[RopeSimulator, str]:
    """The rope after its ends have turned, and why it stopped ('' if it did not)."""
    rope = RopeSimulator(scene)
    assert rope.initialize(0.0, EndMotion(), EndMotion()).valid
    for k in range(round(duration / 0.02)):
        t = (k + 1) * 0.02
        status = rope.advance_to(t, *turned(angle, duration, t))
        if not status.valid:
            return rope, status.message
    return rope, ""


TURNED = Scene(
    rope=Rope(length=30.0), mesh=Mesh(kind="eem", elements=40), solver=Solver(step_max=0.02, kernels="portable")
)


@pytest.mark.parametrize(
    ("elements", "bound"), [(40, 0.08), pytest.param(120, 0.01, marks=pytest.mark.slow, id="0.25 m elements")]
)
def test_loop_yaws_through_90_degrees_and_on_to_a_full_turn(elements: int, bound: float) -> None:
    scene = TURNED.with_(mesh=Mesh(kind="eem", elements=elements))
    rope, stopped = turn_through(scene, 2 * math.pi, 20.0)
    assert stopped == ""
    assert rope.state.loop_yaw > 1.5 * math.pi
    assert rope.state.counts.pole_changes >= 4
    # the ends are back where they were, and so are shape and torque at rest: theta counts on through pole changes.
    # what is left is the interpolation of theta, 5 % of the torque on elements of 0.75 m and 0.3 % on 0.25 m
    first = RopeSimulator(scene)
    assert first.initialize(0.0, EndMotion(), EndMotion()).valid
    motion = rope.state.motion
    rest = find_equilibrium(rope.system, motion.q, motion.t)
    before = first.ends.moment(0, first.state.motion.reaction)
    assert_allclose(rope.ends.moment(0, rest.reaction), before, rtol=bound)
    assert_allclose(rest.q[:, :3], first.state.motion.q[:, :3], rtol=0, atol=2e-3)


def test_tait_bryan_frame_fails_where_the_loop_yaws_90_degrees(monkeypatch: pytest.MonkeyPatch) -> None:
    # its singularity at t parallel to Z is a wall: the ends go on to 180 degrees, the loop hangs at 90
    regular, _ = turn_through(TURNED, math.pi, 6.0)
    monkeypatch.setattr(rope_system, "element_functions", lambda rung: element_functions(rung, tait_bryan_rate))
    stuck, _ = turn_through(TURNED, math.pi, 6.0)
    assert regular.state.loop_yaw > math.pi
    assert stuck.state.loop_yaw < 0.55 * math.pi
