"""A leg that swings against a wall, and the same in a code of its own: lumped masses with springs, explicit steps.

Both ends move sideways, so that the rope lags behind, swings on and strikes the wall.  The chain has n equal pieces of
length e, whose ends r_i carry mass; with e_i = r_(i+1) - r_i and T_i = EA (|e_i| / e - 1) the force on a mass is

    T_i e_i / |e_i| - T_(i-1) e_(i-1) / |e_(i-1)| - EI (r_(i-2) - 4 r_(i-1) + 6 r_i - 4 r_(i+1) + r_(i+2)) / e^3

with weight and pressure of the wall; a place beyond either end holds the rope upright there.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from evidence.contact.scenes import GRAVITY, PLANAR
from evidence.ropes import at_rest, follow, moving, smooth_step
from evidence.tables import Array
from rope_model.parameters import Layout, Rope, Scene
from rope_model.physics.contact import ONSET
from rope_model.shaft_parameters import Contact, Lining, Shaft

#: m between the legs, from the right one to the wall, and that the ends move in so many seconds; s that are looked at
SPACING = 1.0
GAP = 0.75
WAY = 0.6
MOVES = 1.0
STOP = 2.5
EVERY = 1e-3
#: s: the first blow
BLOW = 0.015
ROPE = Rope(length=10.0, Qa=1e6, Qb=0.0, Qc=0.0, EI=50.0, beta_K=0.0)
CONTACT = Contact(friction=0.0)
WALL = 0.5 * SPACING + GAP
#: pieces of the chain; s that it comes to rest in, and its damping then, 1/s
PIECES = 200
RESTING = 8.0
DAMPING = 3.0


class Struck(NamedTuple):
    """Pressure of the wall (N) every EVERY s, and its impulse (N s)."""

    pressure: Array
    impulse: float

    @property
    def peak(self) -> float:
        """Largest pressure, N."""
        return float(self.pressure.max())

    def off(self, other: Struck) -> float:
        """Largest difference of the impulses up to any instant, of the whole."""
        return float(
            np.abs(np.cumsum(self.pressure - other.pressure)).max() * EVERY / other.impulse
        )

    def blow(self) -> Array:
        """The first blow, N, from the instant at which it begins."""
        start = int(np.argmax(self.pressure > 0.0))
        return self.pressure[start : start + round(BLOW / EVERY)]


@cache
def ours() -> Struck:
    """The rope, at the default accuracy."""
    shaft = Shaft(lining=Lining(width=40.0, depth=40.0, x=WALL - 20.0), contact=CONTACT)
    rope = at_rest(Scene(ROPE, Layout(SPACING), model=PLANAR, shaft=shaft))
    read = rope.reader(("contact.lining", "contact.lining.impulse"))
    pressure, impulse = follow(
        rope, EVERY, STOP, lambda t: 2 * (moving(WAY, t, MOVES, x=1.0),), read
    ).T
    return Struck(pressure, float(impulse[-1]))


@cache
def chain(pieces: int = PIECES) -> Struck:
    """The chain, which comes to rest first."""
    e = ROPE.length / pieces
    rho = ROPE.mass_per_length
    fastest = 2.0 * math.sqrt(ROPE.Qa / rho) / e + 4.0 * math.sqrt(ROPE.EI / rho) / e**2  # rad/s
    steps = math.ceil(EVERY * fastest / 1.6)
    r = _hanging(e, pieces)
    v = np.zeros((pieces + 1, 2))
    h = EVERY / steps
    f = np.zeros_like(r)
    found = []
    impulse = 0.0
    for k in range(-round(RESTING / h), round(STOP / h)):
        f[:] = _forces(r, e)
        pressed = _pressure(r[:, 0], v[:, 0])
        f[:, 0] -= pressed
        if k >= 0 and k % steps == 0:
            found.append(e * float(pressed.sum()))
        impulse += h * e * float(pressed.sum())
        v += h / rho * f
        v *= 1.0 - h * DAMPING if k < 0 else 1.0
        v[[0, -1]] = smooth_step((k + 0.5) * h / MOVES)[2] * WAY / MOVES * (k >= 0), 0.0
        r += h * v
    return Struck(np.array([*found[1:], 0.0]), impulse)


def _hanging(e: float, pieces: int) -> Array:
    """Two legs and half a circle between them."""
    s = e * np.arange(pieces + 1)
    radius = 0.5 * SPACING
    leg = 0.5 * (ROPE.length - math.pi * radius)
    angle = np.clip((s - leg) / radius, 0.0, math.pi)
    down = np.minimum(np.minimum(s, ROPE.length - s), leg)
    return np.stack([-radius * np.cos(angle), -down - radius * np.sin(angle)], axis=1)


def _forces(r: Array, e: float) -> Array:
    """Forces per length, N/m."""
    edges = np.diff(r, axis=0)
    long = np.sqrt(np.square(edges).sum(axis=1, keepdims=True))
    f = np.zeros_like(r)
    pull = ROPE.Qa * (1.0 / e - 1.0 / long) * edges
    f[1:-1] = np.diff(pull, axis=0) / e
    held = np.vstack([r[1], r, r[-2]])
    held[[0, -1], 1] += 2.0 * e
    curved = np.diff(held, 2, axis=0) / e**2
    f[1:-1] -= ROPE.EI / e**2 * np.diff(curved, 2, axis=0)
    f[:, 1] -= ROPE.mass_per_length * GRAVITY
    return f


def _pressure(x: Array, speed: Array) -> Array:
    """The law of the wall, N/m."""
    depth = np.maximum(x + 0.5 * ROPE.diameter - WALL, 0.0)
    onset = ONSET * ROPE.diameter
    soft = np.minimum(depth, onset)
    spring = CONTACT.stiffness * (soft * soft / (2.0 * onset) + depth - soft)
    return spring * np.maximum(1.0 + CONTACT.damping * speed, 0.0)
