"""Head ropes that slide on the lining of the sheave.

``plant.py`` finds when they slide over the wrap angle alpha, towards the side of the larger tension
T_1 (Euler and Eytelwein),

    T_1 - mu_r w^2 = exp(mu alpha) (T_2 - mu_r w^2) ,

where ropes of the mass mu_r per length and the speed w press on the sheave by that much less. The
lining takes F = T_1 - T_2 from them, and the tensions follow F through the accelerations:
T_2 = T_20 + T_2' F. So

    F = (exp(mu alpha) - 1) max(T_20 - mu_r w^2, 0) / (1 - (exp(mu alpha) - 1) T_2') ,   T_2' < 0 ,

as F slows the ropes' sliding, which the slack side resists. The mass of the ropes on the sheave
itself is neglected.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import casadi as ca

from hoist_demo.drive.friction import DryFriction
from hoist_demo.parameters import Hoist


class Sliding(NamedTuple):
    """Friction of head ropes that slide, and the accelerations under it."""

    lining: DryFriction
    accelerations: Any


def sliding_friction(
    hoist: Hoist,
    a_stick: ca.SX,
    a_per_force: ca.SX,
    tensions: Callable[[ca.SX], list[Any]],
    w: ca.SX,
) -> Sliding:
    """Return the lining's force on head ropes that slide [N], and the accelerations under it.

    Its state is the sense of their sliding, 1 as the sheave's positive rotation or -1, which does
    not change; the force is 0 where they hold. ``a_stick`` are the accelerations without it,
    ``a_per_force`` those of 1 N along the slip, ``tensions`` follow from accelerations, ``w`` is
    the ropes' speed.
    """
    if hoist.lining is None:
        return Sliding(DryFriction(), a_stick)
    sense = ca.SX.sym("sense")
    a = ca.SX.sym("a", a_stick.numel())
    left, right = (tension - hoist.rope_mass * w**2 for tension in tensions(a))
    low = ((1.0 + sense) * left + (1.0 - sense) * right) / 2.0
    against_slip = -sense * a_per_force
    gain = ca.exp(hoist.lining.sliding * hoist.friction_coefficient * hoist.wrap_angle) - 1.0
    pressing = ca.fmax(ca.substitute(low, a, a_stick), 0.0)
    force = gain * pressing / (1.0 - gain * ca.dot(ca.gradient(low, a), against_slip))
    lining = DryFriction(force, states=(sense,), rates=(0.0,))
    return Sliding(lining, a_stick + force * against_slip)
