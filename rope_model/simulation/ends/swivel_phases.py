"""Friction of a swivel in each phase, and the end of a phase; codegen.rules makes the C of it.

``now`` is the swivel's SwivelState, ``held`` the moment (N m) by which the conveyance would hold the rope's end, and
``rate`` that of the swivel's angle (rad/s).
"""

import math
from enum import Enum
from typing import Any, NamedTuple

from rope_model.physics.elementary import both, either, where
from rope_model.physics.swivel import friction_moment

#: N m by which a moment must pass the static limit: less is rounding
MOMENT_RESOLUTION = 1e-9


class Phase(Enum):
    """Phase of a swivel."""

    LOCKED = 0
    STICK = 1
    SLIP = 2


class SwivelState(NamedTuple):
    """Phase; while it holds, the relative angle b (rad); while it slips, the sign of b_t."""

    phase: Phase
    angle: float
    sign: float


def frictionless(swivel: Any) -> Any:
    """Whether it turns by itself."""
    return either(swivel.mode == "free", both(swivel.mu_kinetic == 0.0, swivel.seal_moment == 0.0))


def released_at(swivel: Any, swivel_state: Any) -> Any:
    """The instant (s) at which its lock ends; infinite where it is not locked, or for ever."""
    waits = both(swivel_state.phase == Phase.LOCKED, swivel.mode != "locked")
    return where(waits, swivel.release_time, math.inf)


def relaxes(swivel: Any, swivel_state: Any, t: Any) -> Any:
    """Whether a run that starts at ``t`` (s) starts from where it has slid to."""
    return both(swivel.start == "relaxed", t >= released_at(swivel, swivel_state))


def swivel_friction(swivel: Any, mu: Any, tension: Any) -> Any:
    """Largest moment (N m) of its friction with this coefficient."""
    return where(swivel.mode == "free", 0.0, friction_moment(mu, swivel.mean_diameter, swivel.seal_moment, tension))


def beyond_rest(swivel: Any, tension: Any, held: Any) -> Any:
    """Moment (N m) by which ``held`` passes what the swivel can hold at rest; negative while it holds."""
    holds = where(frictionless(swivel), 0.0, swivel_friction(swivel, swivel.mu_static, tension))
    return abs(held) - (holds + MOMENT_RESOLUTION)


def moment_of_swivel(swivel: Any, swivel_state: Any, tension: Any, held: Any) -> Any:
    """Moment (N m, about the tangent) of the conveyance on the rope's end."""
    return where(
        swivel_state.phase == Phase.SLIP, -swivel_state.sign * swivel_friction(swivel, swivel.mu_kinetic, tension), held
    )


def swivel_excess(swivel: Any, swivel_state: Any, tension: Any, held: Any, rate: Any) -> Any:
    """Event function: negative while the swivel may stay in its phase."""
    stays = either(swivel_state.phase == Phase.LOCKED, both(swivel_state.phase == Phase.SLIP, frictionless(swivel)))
    beyond = beyond_rest(swivel, tension, held)
    return where(stays, -math.inf, where(swivel_state.phase == Phase.STICK, beyond, -swivel_state.sign * rate))
