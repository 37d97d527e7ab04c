"""Friction of a swivel in each phase, and the event function of a phase; codegen.formulas lists what C has of it.

``swivel_state`` is its SwivelState, ``constraint_moment`` the moment (N m) with which the
conveyance would hold the rope's end, and ``rate`` that of the swivel's angle (rad/s).
"""

import math
from enum import Enum
from typing import NamedTuple

from rope_model.parameters import Swivel
from rope_model.physics.elementary import (
    SMALLEST_DIVISOR,
    Scalar,
    logical_and,
    logical_or,
    maximum,
    where,
)
from rope_model.physics.swivel import Friction, friction_law, friction_moment

#: of the tension times the mean diameter, excess of a moment over the static limit that is
#: rounding: 1e-9 N m at 5 kN and 0.1 m.  An absolute value would put the events of a light rope and
#: a heavy one at different instants.
MOMENT_RESOLUTION = 2e-12


class Phase(Enum):
    """Phase of a swivel."""

    LOCKED = 0
    STICK = 1
    SLIP = 2


class SwivelState(NamedTuple):
    """Phase; the relative angle b (rad) while it holds; the sign of b_t while it slips."""

    phase: Phase
    angle: float
    sign: float


def bearing_friction(swivel: Swivel, mu: Scalar) -> Friction:
    """Return the largest moment of its friction with this coefficient: none if it turns freely."""
    law = friction_law(mu, swivel.mean_diameter, swivel.seal_moment)
    free = swivel.mode == "free"
    return Friction(*(where(free, 0.0, term) for term in law))


def frictionless(swivel: Swivel) -> Scalar:
    """Return whether the swivel turns without friction."""
    return logical_and(*(term == 0.0 for term in bearing_friction(swivel, swivel.mu_kinetic)))


def released_at(swivel: Swivel, swivel_state: SwivelState) -> Scalar:
    """Return the instant (s) at which its lock ends; infinite if it is not locked, or locked for ever."""
    waits = logical_and(swivel_state.phase == Phase.LOCKED, swivel.mode != "locked")
    return where(waits, swivel.release_time, math.inf)


def relaxes(swivel: Swivel, swivel_state: SwivelState, t: Scalar) -> Scalar:
    """Return whether a run that starts at ``t`` (s) starts from the angle to which the swivel has slid."""
    return logical_and(swivel.start == "relaxed", t >= released_at(swivel, swivel_state))


def kinetic_friction(swivel: Swivel, tension: Scalar) -> Scalar:
    """Return the moment (N m) of its friction while it slips."""
    return friction_moment(bearing_friction(swivel, swivel.mu_kinetic), tension)


def beyond_rest(swivel: Swivel, tension: Scalar, constraint_moment: Scalar) -> Scalar:
    """Return the share by which ``constraint_moment`` exceeds the static friction; negative while the swivel holds."""
    static = friction_moment(bearing_friction(swivel, swivel.mu_static), tension)
    holds = where(frictionless(swivel), 0.0, static)
    limit = holds + MOMENT_RESOLUTION * swivel.mean_diameter * abs(tension)
    return abs(constraint_moment) / maximum(limit, SMALLEST_DIVISOR) - 1.0


def moment_of_swivel(
    swivel: Swivel, swivel_state: SwivelState, tension: Scalar, constraint_moment: Scalar
) -> Scalar:
    """Return the moment (N m, about the tangent) of the conveyance on the rope's end."""
    slipping = friction_moment(slip_load(swivel, swivel_state), tension)
    return where(swivel_state.phase == Phase.SLIP, slipping, constraint_moment)


def slip_load(swivel: Swivel, swivel_state: SwivelState) -> Friction:
    """Return the moment, about the tangent, on the rope's end where the swivel slips; 0 where it does not."""
    slips = swivel_state.phase == Phase.SLIP
    law = bearing_friction(swivel, swivel.mu_kinetic)
    return Friction(*(where(slips, -swivel_state.sign * term, 0.0) for term in law))


def slip_constant(swivel: Swivel, swivel_state: SwivelState) -> Scalar:
    """Return the part of ``slip_load`` at any tension, N m."""
    return slip_load(swivel, swivel_state).constant


def slip_per_tension(swivel: Swivel, swivel_state: SwivelState) -> Scalar:
    """Return the part of ``slip_load`` per newton of tension, N m."""
    return slip_load(swivel, swivel_state).per_tension


def swivel_excess(
    swivel: Swivel,
    swivel_state: SwivelState,
    tension: Scalar,
    constraint_moment: Scalar,
    rate: Scalar,
) -> Scalar:
    """Return the event function: negative while the swivel may stay in its phase."""
    phase = swivel_state.phase
    beyond = beyond_rest(swivel, tension, constraint_moment)
    stays = logical_or(
        phase == Phase.LOCKED, logical_and(phase == Phase.SLIP, frictionless(swivel))
    )
    return where(stays, -math.inf, where(phase == Phase.STICK, beyond, -swivel_state.sign * rate))


EVENT_WIDTH = 1e-9  #: s, width to which events are located
#: event function at the start of a phase that has just begun: a slip has no rate yet
JUST_BEFORE = -1e-12
# a swivel chatters with more events in a shorter time
CHATTER_EVENTS = 50
CHATTER_TIME = 1e-3  #: s
