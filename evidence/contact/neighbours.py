"""Two equal ropes that hang side by side and swing against each other, and one of them against a wall midway.

By symmetry they meet where the wall would be.  That is pressed half as deep as they are, and approached half as fast:
with twice the stiffness and twice the damping it does to one of them what the other does.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from rope_model import BalanceRope, EndMotion, Neighbours, balance_rope
from rope_model.parameters import Layout, Mesh, Rope, Scene, Solver
from rope_model.shaft_parameters import Contact, Lining, Shaft

#: N/m^2, and m by which the planes of the ropes are apart
STIFFNESS, GAP = 1e6, 0.3
SCENE = Scene(
    rope=Rope(length=6.0, EI=100.0),
    layout=Layout(0.6),
    mesh=Mesh("eem", elements=16),
    solver=Solver(step_max=0.01, tolerance=1e5),
    shaft=Shaft(contact=Contact(rope_stiffness=STIFFNESS)),
)
#: m/s of the middle of each, and s that they swing
SPEED, TIME = 1.0, 0.3


class Alone:
    """A rope whose ends rest, as a partner."""

    def __init__(self, rope: BalanceRope) -> None:
        self.rope: BalanceRope | None = rope
        self._own, self._kept, self._until = rope, rope.snapshot(), 0.0

    def begin(self, t: float, h: float) -> None:
        self._kept, self._until = self._own.snapshot(), t + h

    def go(self) -> bool:
        return self._own.advance_to(self._until, EndMotion(), EndMotion()).valid

    def back(self) -> None:
        self._own.restore(self._kept)

    def accept(self) -> None:
        """Nothing more."""


def swinging(scene: Scene, speed: float) -> BalanceRope:
    """A rope at rest, the middle of which moves out of plane."""
    rope = balance_rope(scene, "native")
    status = rope.initialize(0.0, EndMotion(), EndMotion())
    if not status.valid:
        raise RuntimeError(status.message)
    state = rope.state
    v, x = state.motion.v.copy(), math.pi * state.partition.nodes_s / scene.rope.length
    v[:, 2], v[:, 5] = speed * np.sin(x) ** 2, speed * np.sin(2.0 * x) * math.pi / scene.rope.length
    v[-1] = 0.0
    rope.restore(state._replace(motion=replace(state.motion, v=v)))
    return rope


def striking(h: float, **law: float) -> tuple[Neighbours, list[BalanceRope]]:
    """Two equal ropes that have swung against each other, in steps of ``h`` (s) of their host."""
    scene = SCENE.with_(shaft=Shaft(contact=Contact(rope_stiffness=STIFFNESS, **law)))
    ropes = [swinging(scene, speed) for speed in (SPEED, -SPEED)]
    neighbours = Neighbours([scene, scene], [(0.0, 0.0, -0.5 * GAP), (0.0, 0.0, 0.5 * GAP)])
    neighbours.begin(0.0, ropes)
    partners = [Alone(rope) for rope in ropes]
    for k in range(round(TIME / h)):
        if not neighbours.step(k * h, h, partners):
            raise RuntimeError(f"ropes side by side cannot be advanced from t = {k * h:g} s")
    return neighbours, ropes


def against_a_wall(h: float, **law: float) -> BalanceRope:
    """One of them that has swung against a wall midway."""
    wide = 40.0
    wall = Lining(width=wide, depth=wide, z=0.5 * GAP - 0.5 * wide)
    contact = Contact(stiffness=2.0 * STIFFNESS, **law)
    contact = replace(contact, damping=2.0 * contact.damping)
    rope = swinging(SCENE.with_(shaft=Shaft(contact=contact, lining=wall)), SPEED)
    for k in range(1, round(TIME / h) + 1):
        status = rope.advance_to(k * h, EndMotion(), EndMotion())
        if not status.valid:
            raise RuntimeError(status.message)
    return rope


def off_the_wall(h: float) -> float:
    """By how much the nodes' places are off those at the wall, of how far they went; without friction."""
    z, wall = (rope.rows()[:, 3] for rope in (striking(h, friction=0.0)[1][0], against_a_wall(h, friction=0.0)))
    return float(np.abs(z - wall).max() / np.abs(z).max())


def energy_missed(h: float) -> float:
    """What both ropes lost and what their contact holds and took differ by, of what they swing with."""
    neighbours, ropes = striking(h)
    account = neighbours.contacts.accounts[0, 1]
    lost = -sum(rope.state.energy_balance.work_ends for rope in ropes)  # their ends rest
    data = SCENE.rope
    swing = 0.375 * data.mass_per_length * data.length * SPEED**2  # the mean of sin^4 is 3/8
    return abs(lost - account.energy - account.dissipated) / swing
