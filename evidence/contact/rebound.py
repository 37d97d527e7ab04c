"""A straight rope that strikes a floor flat, all of it at once: exact for any spring, by Hunt and Crossley's integral.

Without weight the rope's depth p obeys rho p_tt = -s(p) (1 + lambda p_t), so that over the whole contact

    p_t / lambda - log(1 + lambda p_t) / lambda^2

is the same as it comes and as it goes: the rebound depends on the speed alone, not on the spring.
"""

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.optimize import brentq

from evidence.statics import OUT_OF_PLANE, held, rod
from evidence.tables import Array
from rope_model.method.generalized_alpha import Motion
from rope_model.parameters import Rope
from rope_model.physics import shaft
from rope_model.physics.contact_element import CONTACT_BALANCE, LAW
from rope_model.physics.element import BALANCE, ElementFunctions
from rope_model.physics.rope_element import rope_element
from rope_model.physics.shaft import KINDS
from rope_model.reference.equations import Equations, of_elements
from rope_model.reference.generalized_alpha import restart, step
from rope_model.shaft_parameters import Contact, Sump

#: m of rope, in so many elements, and the gap below it
LENGTH = 2.0
ELEMENTS = 2
GAP = 0.01
RHO_INF = 1.0  # no numerical dissipation
NEWTON = 1e-12  # m, last correction of a step


@dataclass(frozen=True)
class Rebound:
    """Result of an impact."""

    speed: float  # m/s
    depth: float  # m, largest
    unexplained: float  # energy over the kinetic energy before


@cache
def _element() -> ElementFunctions:
    """Return the published element with a floor, which takes most of a second to derive."""
    return rope_element("torsional", (KINDS.index("floor"),))


def rebound(speed: float, damping: float, stiffness: float, h: float) -> Rebound:
    """Return an impact at ``speed`` (m/s), with steps of ``h`` (s)."""
    rope = Rope(length=LENGTH, Qb=0.0, Qc=0.0, beta_K=0.0)
    q = np.zeros((ELEMENTS + 1, 7))
    q[:, 0] = np.linspace(0.0, LENGTH, ELEMENTS + 1)
    q[:, 3] = 1.0
    contact = Contact(stiffness=stiffness, damping=damping, friction=0.0)
    flying = rod(rope, 0.0, q, held(q, OUT_OF_PLANE))
    v = np.zeros_like(q)
    v[:, 1] = -speed
    return _impact(_above_floor(flying, rope, contact), q, v, h)


def _above_floor(equations: Equations, rope: Rope, contact: Contact) -> Equations:
    """Return the equations for the element with a floor, all elements near a floor that is GAP below them."""
    floor = shaft.floor(Sump(level=-GAP - 0.5 * rope.diameter))
    law = {"diameter": rope.diameter} | vars(contact)
    at_rest = (0.0, 0.0, 0.0)
    numbers = [law[name] for name in LAW]
    numbers += [*floor.centre, *floor.half, *floor[2:], *at_rest]
    near = np.ones((1, equations.lengths.size))
    return replace(
        equations,
        law=_element(),
        material=np.append(equations.material, numbers),
        frame=np.vstack((equations.frame, near)),
    )


def _impact(equations: Equations, q: Array, v: Array, h: float) -> Rebound:
    """Return what becomes of the rope ``q`` that falls with ``v``, as soon as it has left the floor."""
    motion = restart(equations, 0.0, q, v)
    assert isinstance(motion, Motion)
    before = _balance(equations, q, v)["kinetic"]
    dissipated = 0.0
    depth = 0.0
    while motion.v[0, 1] <= 0 or motion.q[0, 1] < -GAP:
        tried = step(equations, motion, h, RHO_INF, NEWTON)
        new = tried.motion
        if new is None:
            raise RuntimeError(f"at t = {motion.t:g} s a step of {h:g} s fails: {tried.cause}")
        middle = _balance(equations, 0.5 * (motion.q + new.q), (new.q - motion.q) / h)
        dissipated += h * middle["contact_dissipated"]
        motion = new
        depth = max(depth, -GAP - float(motion.q[0, 1]))
    after = _balance(equations, motion.q, motion.v)
    left = after["kinetic"] + after["contact"] + dissipated - before
    return Rebound(float(motion.v[:, 1].mean()), depth, left / before)


def _balance(equations: Equations, q: Array, v: Array) -> dict[str, float]:
    """Return energies (J) and powers (W) of the rope, and those of contact."""
    sums = _element().balance(
        of_elements(q),
        of_elements(v),
        equations.lengths[None, :],
        equations.frame,
        equations.material,
    )
    names = (*BALANCE, *CONTACT_BALANCE)
    return dict(zip(names, sums.full().sum(axis=1).tolist(), strict=True))


def exact_speed(speed: float, damping: float) -> float:
    """Speed of the rebound, m/s."""

    def integral(p_t: float) -> float:
        return p_t / damping - math.log1p(damping * p_t) / damping**2

    most = min(speed, (1.0 - 1e-12) / damping)
    return float(brentq(lambda x: integral(-x) - integral(speed), 0.0, most, xtol=1e-14))
