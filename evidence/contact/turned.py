"""Legs that are turned about each other until they lie in a two-strand ply: with what is exact about it.

Both held ends turn and twist the rope, slowly and in thick air, so that it is at rest all the time.  Two strands with
bending stiffness B and twisting moment M lie in helices of radius a and angle alpha to the vertical, without friction;
the vertical force in each is n, and no moment about their axis comes from below.  Moments balance where

    -M cos 2 alpha / a = 2 B sin^3 alpha cos alpha / a^2 + n sin alpha

Source: Thompson, van der Heijden and Neukirch, Proc. R. Soc. A 458 (2002), for the ply.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rope_model import BalanceRope, EndMotion
from rope_model.parameters import Layout, Mesh, Rope, Scene, Swivel
from rope_model.physics.hermite import interpolate
from rope_model.shaft_parameters import Air, Contact, Shaft

from .scenes import WEIGHT, Array, made

#: m, m, elements; s that the ends turn, and by how many turns each
LENGTH, SPACING, ELEMENTS = 10.0, 0.5, 40
TIME, TURNS = 60.0, 4.0
#: s: half of the time that they take where the legs strike each other
FAST = 4.0
#: m: between these heights the ply is far from both its ends
PLY = (-3.4, -2.2)


@dataclass(frozen=True)
class Turned:
    """Turns of the legs about each other and torque (N m) in the rope as they grow, from the first touch on.

    ``angle`` is that of the helices where the ply is even, ``exact`` what the moments' balance gives; ``unexplained``
    is energy over the work of the ends, ``crossings`` the times that the legs passed through each other.
    """

    turns: Array
    torque: Array
    angle: float
    exact: float
    unexplained: float
    crossings: float


def turned(friction: float) -> Turned:
    """The rope turned by ``TURNS`` at either end."""
    air = Air(density=100.0, drag=10.0)
    scene = _scene(Shaft(contact=Contact(rope_stiffness=1e7, friction=friction), air=air))
    found, H = made(scene, EndMotion(), EndMotion()), 0.02
    read, course = found.reader(("loop.turns", "left.swivel.torque", "contact.rope")), []
    for k in range(1, round(TIME / H) + 1):
        _advance(found, k * H, TIME)
        course.append(np.abs(read()))
    turns, torque, force = np.array(course).T
    first = int(np.argmax(force > 0))
    ply = helix(found.state.motion.q, found.state.partition.lengths, np.linspace(*PLY, 200))
    exact = _exact_angle(float(torque[-1]) / ply.radius, scene.rope.EI / ply.radius**2, 0.5 * WEIGHT * ply.below)
    crossings = found.signals(["loop.crossings"])["loop.crossings"]
    return Turned(turns[first:], torque[first:], ply.angle, exact, _unexplained(found), crossings)


def struck_legs(stiffness: float) -> float:
    """Energy unexplained, of the work, where the rope is turned so fast that its legs strike and rebound."""
    found, H = made(_scene(Shaft(contact=Contact(rope_stiffness=stiffness))), EndMotion(), EndMotion()), 0.01
    for k in range(1, round(FAST / H) + 1):
        _advance(found, k * H, 2.0 * FAST)
    return _unexplained(found)


def _scene(shaft: Shaft) -> Scene:
    locked = Swivel("locked")
    return Scene(
        rope=Rope(length=LENGTH, EI=200.0, Qb=0.0, Qc=0.0),
        layout=Layout(spacing=SPACING),
        mesh=Mesh("eem", elements=ELEMENTS),
        left=locked,
        right=locked,
        shaft=shaft,
    )


def _advance(rope: BalanceRope, t: float, time: float) -> None:
    """Both ends turn at an even rate, which they come to within a second, by ``TURNS`` in this ``time`` (s)."""
    rate = 2.0 * math.pi * TURNS / (time - 1.0)
    end = EndMotion(yaw=rate * (t - 1.0 + math.exp(-t)), yaw_rate=rate * (1.0 - math.exp(-t)))
    status = rope.advance_to(t, end, end)
    if not status.valid:
        raise RuntimeError(status.message)


def _unexplained(rope: BalanceRope) -> float:
    energies = rope.state.energy_balance
    return float(energies.residual / energies.work_ends)


class Helix(NamedTuple):
    """Two strands about a vertical axis: angle (rad), radius, and how long the rope is below (m)."""

    angle: float
    radius: float
    below: float


def helix(q: Array, lengths: Array, heights: Array) -> Helix:
    """Of the legs between the ``heights``, means."""
    xi, place, below = np.linspace(0.0, 1.0, 21)[:-1], [], []
    for k, l in enumerate(lengths):
        place.append([interpolate(xi, l, *(q[n, i] for n in (k, k + 1) for i in (j, 3 + j)))[0] for j in range(3)])
        below.append(lengths[:k].sum() + l * xi)
    points, s = np.hstack(place), np.concatenate(below)
    bottom = int(np.argmin(points[1]))
    legs = [
        np.array([np.interp(heights, points[1, part], x[part]) for x in (points[0], points[2], s)])
        for part in (slice(bottom, None, -1), slice(bottom, None))
    ]
    x, z, between = legs[1] - legs[0]
    radius = 0.5 * float(np.hypot(x, z).mean())
    turn = np.unwrap(np.arctan2(z, x))
    angle = math.atan(radius * abs(float(np.polyfit(heights, turn, 1)[0])))
    return Helix(angle, radius, float(between.mean()))


def _exact_angle(moment: float, bending: float, n: float) -> float:
    low, high = 0.0, 0.25 * math.pi
    for _ in range(60):
        angle = 0.5 * (low + high)
        sine, cosine = math.sin(angle), math.cos(angle)
        more = moment * math.cos(2.0 * angle) > 2.0 * bending * sine**3 * cosine + n * sine
        low, high = (angle, high) if more else (low, angle)
    return low
