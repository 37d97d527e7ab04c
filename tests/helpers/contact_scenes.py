"""Ropes that press themselves or each other: strings that cross with a force in closed form, two that strike."""

import math
from dataclasses import replace

import numpy as np
from native_parts import find_self_contacts
from scenes import hung

from rope_model import (
    BalanceRope,
    EndMotion,
    Layout,
    Mesh,
    Neighbours,
    Rope,
    Scene,
    Solver,
    balance_rope,
)
from rope_model.physics.contact import (
    ONSET,
)
from rope_model.shaft_parameters import Contact, Conveyance, Divider, HeadRopes, Lining, Shaft, Sump

DIAMETER = Rope().diameter  #: m
STIFFNESS = 1e6  #: N/m^2
GAP = 0.3  #: m, between the planes of two ropes

SHORT = Scene(Rope(length=6.0, EI=100.0), Layout(0.6), solver=Solver(step_max=0.01, tolerance=1e5))
SCENE = SHORT.with_(
    mesh=Mesh("eem", elements=16), shaft=Shaft(contact=Contact(rope_stiffness=STIFFNESS))
)
#: m, where two hang that swing against each other
FACING = [(0.0, 0.0, -0.5 * GAP), (0.0, 0.0, 0.5 * GAP)]
#: s that two swing against each other, the middle of each at 1 m/s
TIME = 0.3


def crossing(gap: float, angle: float, along: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """A rope in which two straight strings of 2 m cross, the second above the first: rows (nodes, 7), lengths."""
    q = np.zeros((6, 7))
    for k, (nodes, turn, z) in enumerate(
        ((range(3), 0.0, 0.0), (range(3, 6), math.pi + angle, gap))
    ):
        tangent = np.array([math.cos(turn), math.sin(turn), 0.0])
        for node, s in zip(nodes, (-1.0, along + 0.013 * k, 1.0), strict=True):
            q[node, :3] = s * tangent + [0.0, 0.0, z]
            q[node, 3:6] = tangent
    return q, np.array([1.0 + along, 1.0 - along, 6.0, 1.013 + along, 0.987 - along])


def exact_force(gap: float, sine: float) -> float:
    """Force between strings whose angle has this sine, one per length of the first at its places' distances:

    F = int s(D - sqrt(g^2 + x^2 sin^2 a)) g / sqrt(g^2 + x^2 sin^2 a) dx
    """
    number = 200000
    reach = math.sqrt(DIAMETER**2 - gap**2) / sine
    onset = ONSET * DIAMETER
    distance = np.hypot(gap, (np.arange(number) + 0.5) / number * reach * sine)
    pressed = DIAMETER - distance
    soft = np.minimum(pressed, onset)
    spring = STIFFNESS * (soft * soft / (2.0 * onset) + pressed - soft)
    return 2.0 * reach * float((spring * gap / distance).mean())


def force_error(degrees: float) -> float:
    """Largest relative error of the force as the strings move along each other."""
    scene = Scene(shaft=SCENE.shaft)
    angle = math.radians(degrees)
    gap = 0.85 * DIAMETER
    exact = exact_force(gap, math.sin(angle))
    worst = 0.0
    for along in (0.0, 0.002, 0.004, 0.006, 0.008):
        q, lengths = crossing(gap, angle, along)
        R = np.zeros_like(q)
        find_self_contacts(scene, q, np.zeros_like(q), lengths).take_force(R)
        worst = max(worst, abs(float(R[:3, 2].sum()) / exact - 1.0))
    return worst


class Alone:
    """A rope whose ends rest, as a partner."""

    def __init__(self, rope: BalanceRope) -> None:
        self.rope: BalanceRope | None = rope
        self._own = rope
        self._kept = rope.snapshot()
        self._until = 0.0

    def begin(self, t: float, h: float) -> None:
        self._kept = self._own.snapshot()
        self._until = t + h

    def go(self) -> bool:
        return self._own.advance_to(self._until, EndMotion(), EndMotion()).valid

    def back(self) -> None:
        self._own.restore(self._kept)

    def accept(self) -> None:
        pass


Group = tuple[Neighbours, list[BalanceRope], list[Alone]]


def swinging(scene: Scene, speed: float) -> BalanceRope:
    """A rope at rest, the middle of which moves out of plane."""
    rope = hung(balance_rope(scene, "native"))
    state = rope.state
    v = state.motion.v.copy()
    x = math.pi * state.partition.nodes_s / scene.rope.length
    v[:, 2] = speed * np.sin(x) ** 2
    v[:, 5] = speed * np.sin(2.0 * x) * math.pi / scene.rope.length
    v[-1] = 0.0
    rope.restore(state._replace(motion=replace(state.motion, v=v)))
    return rope


def begun(
    scenes: list[Scene], speeds: tuple[float, ...], places: list[tuple[float, float, float]]
) -> Group:
    """Ropes at these places, whose middles move out of plane, and themselves as partners."""
    ropes = [swinging(scene, speed) for scene, speed in zip(scenes, speeds, strict=True)]
    neighbours = Neighbours(scenes, places)
    neighbours.begin(0.0, ropes)
    return neighbours, ropes, [Alone(rope) for rope in ropes]


def striking(h: float, **law: float) -> tuple[Neighbours, list[BalanceRope]]:
    """Two equal ropes that have swung against each other, in steps of ``h`` (s) of their host."""
    scene = SCENE.with_(shaft=Shaft(contact=Contact(rope_stiffness=STIFFNESS, **law)))
    neighbours, ropes, partners = begun([scene, scene], (1.0, -1.0), FACING)
    assert all(neighbours.step(k * h, h, partners) for k in range(round(TIME / h)))
    return neighbours, ropes


def against_a_wall(h: float, **law: float) -> BalanceRope:
    """One of them that has swung against a wall midway, pressed half as deep and approached half as fast.

    With twice the stiffness and twice the damping it does to one of them what the other does.
    """
    wall = Lining(width=40.0, depth=40.0, z=0.5 * GAP - 20.0)
    contact = Contact(stiffness=2.0 * STIFFNESS, **law)
    contact = replace(contact, damping=2.0 * contact.damping)
    rope = swinging(SCENE.with_(shaft=Shaft(contact=contact, lining=wall)), 1.0)
    for k in range(1, round(TIME / h) + 1):
        assert rope.advance_to(k * h, EndMotion(), EndMotion()).valid
    return rope


def narrow() -> Scene:
    """A short rope in a narrow shaft with bodies of every kind."""
    shaft = Shaft(
        sump=Sump(level=-4.2),
        divider_1=Divider(size=0.2, y=-3.5, offset=0.3),
        lining=Lining(width=2.8, depth=2.0),
        conveyance=Conveyance(width=1.0, depth=1.0, height=3.0, above=0.3),
        head_ropes=HeadRopes(diameter=0.04, row=0.5),
    )
    return Scene(rope=Rope(length=10.0), mesh=Mesh("eem", elements=10), shaft=shaft)


def ends(t: float) -> tuple[EndMotion, EndMotion]:
    """Both go down at a growing speed, the right one less."""
    left, right = (EndMotion(y=-y * t**3, vy=-3 * y * t**2, ay=-6 * y * t) for y in (2.0, 1.0))
    return left, right
