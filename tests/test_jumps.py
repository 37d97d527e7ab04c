"""End loads where the description of the rope's state changes: frame, mesh, fidelity of the model."""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray
from scenes import hung, smooth_step, smooth_trip, wound

from rope_model import EndMotion, Model, Rope, Scene, at_level, rope_120, rope_240
from rope_model.engine import NativeRope

pytest.importorskip("rope_model.codegen.build")

H = 0.01
LOADS = [f"{side}.{kind}{axis}" for kind in "fm" for side in ("left", "right") for axis in "xyz"]
UNCOUPLED = Scene(rope=Rope(Qb=0.0, Qc=0.0))


@dataclass(frozen=True)
class Turn:
    """A trip of the left end, m in s, while the right end is turned by ``yaw`` (rad) from ``begin`` to ``end`` (s)."""

    travel: float
    yaw: float
    begin: float
    end: float
    duration: float

    def __call__(self, t: float, height: float) -> tuple[EndMotion, EndMotion]:
        left, right = smooth_trip(t, self.travel, self.duration, height)
        turn, rate, _ = (self.yaw * x for x in smooth_step(t, self.begin, self.end - self.begin))
        return left, replace(right, yaw=turn, yaw_rate=rate)


FOUR_TURNS = Turn(0.0, 8 * math.pi, 0.0, 40.0, 40.0)
DEEP = replace(rope_240().scene, left=Scene().left, right=Scene().right)
RIGID = replace(at_level(UNCOUPLED, "draft"), model=Model(force_tolerance=0.05))
SCENES = {
    "four turns at rest": (rope_120().scene, FOUR_TURNS),
    "two turns in a winding": (rope_120().scene, Turn(90.0, 4 * math.pi, 2.0, 22.0, 25.0)),
    "a turn backwards on a deep rope": (DEEP, Turn(200.0, -2 * math.pi, 2.0, 28.0, 30.0)),
    "planar rope that is turned": (UNCOUPLED, Turn(90.0, 0.5, 10.0, 15.0, 25.0)),
    "draft that is turned": (rope_120("draft").scene, Turn(90.0, 0.5, 10.0, 15.0, 25.0)),
    "rigid rope that is turned": (RIGID, Turn(90.0, 0.5, 10.3, 15.3, 25.0)),
}


@pytest.mark.parametrize("name", SCENES)
def test_no_end_force_jumps_where_only_the_description_changes(name: str) -> None:
    scene, motion = SCENES[name]
    # the loop's place errs by a part that goes with the step's length: where an error changes that, a wave of some
    # newtons runs along the rope
    scene = scene.with_(solver=replace(scene.solver, tolerance=1e6))
    height = 90.0 if scene.rope.length < 200 else 200.0
    rope = hung(NativeRope(scene), *motion(0.0, height))
    record: list[list[float]] = []
    changes: dict[str, list[int]] = {"transformation": [], "model": []}
    before = 0.0, rope.fidelity
    for k in range(1, round(motion.duration / H) + 1):
        assert rope.advance_to(k * H, *motion(k * H, height)).valid
        record.append([*rope.signals(LOADS).values()])
        # events are read where there are any: a whole state each step takes longer than the step
        now = *rope.signals(["count.transformations"]).values(), rope.fidelity
        for event in rope.state.events if now != before else ():
            changes["model" if event.what.startswith("model") else event.what].append(k - 1)
        before = now
    jumps = jumps_of(np.array(record))
    of = {x: [j for k in at for j in (k - 2, k - 1, k) if 0 <= j < len(jumps)] for x, at in changes.items()}
    # horizontal forces, which a rigid rope leaves out, come back at once: some 17 N
    assert jumps[of["model"], :6].max(initial=0.0) <= 20.0
    smooth_ones = jumps if "turns" in name or "backwards" in name else jumps[of["transformation"]]
    # the motions last for seconds and bend the curve of 10 ms samples by a tenth of that
    assert smooth_ones[:, :6].max() < 1.0
    assert smooth_ones[:, 6:].max() < 0.05


def test_a_change_of_the_steps_length_sends_a_wave_along_the_rope_and_even_steps_send_none() -> None:
    scene, motion = SCENES["a turn backwards on a deep rope"]
    largest = {}
    for name, lengths in (("long", (H, H)), ("short", (H / 4, H / 4)), ("changed", (H, H / 4))):
        at = [scene.with_(solver=replace(scene.solver, tolerance=1e6, step_max=h)) for h in lengths]
        rope, record = wound(NativeRope(at[0]), partial(motion, height=200.0), 1380), []
        for k in range(1381, 1421):
            if k == 1400:
                rope.retune(at[1])
            assert rope.advance_to(k * H, *motion(k * H, 200.0)).valid
            record.append([*rope.signals(LOADS[:6]).values()])
        largest[name] = jumps_of(np.array(record)).max()
    assert max(largest["long"], largest["short"]) < 1.0 < 3.0 < largest["changed"] < 20.0


def jumps_of(forces: NDArray[np.float64]) -> NDArray[np.float64]:
    """(samples - 2, forces): distance of each sample from the mean of its neighbours."""
    return np.abs(forces[1:-1] - 0.5 * (forces[2:] + forces[:-2]))
