"""Warnings about results that are valid: they are those of the model, and a real rope would do something else.

    passed_bodies       the rope has passed into bodies of its shaft: contact is not in the model
    passed_sides        the legs have passed through each other, or one through what hangs above the other
    neglected_effects   the model computes no torsion, and the rope carries torque; or it is the rigid one
    leg_contact         the loop is turned over, or the legs touch
    yaw_at_rest         the loop hangs far out of its ends' plane at rest, by a torque that is too large for a shaft
    other_rests         the rope has more than one way to hang, and snapped over on the way to this one
    missing_loads       momentum changes otherwise than the end forces and the weight say
    unresolved_waves    end forces change at once in steps that are too long for the waves that this sends off
    unresolved_bend     elements are too long for the sharpest bend
    accuracy_given_up   steps err more than they should because work_max allows for no more of them

Two straight legs between ends a width apart and a loop of about that width, turned by psi, come as near to each other
as cos(psi / 2) of it: they meet at half a turn.  On a deep rope they need not: the long leg can swing around the short
one and what hangs above it.  That is half a turn over the height (diagnostics.loop_turns), too.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from ..parameters import Scene
from ..physics.estimates import coupling_torque, loop_width, twist_torque
from ..physics.shaft import KINDS
from . import messages
from .audit import (
    FEWEST_ELEMENTS,
    FEWEST_STEPS,
    LARGE_CHANGE,
    MISSING_FORCE,
    MISSING_MOMENT,
    axial_step,
    elements_per_bend,
)
from .bodies import may_touch
from .diagnostics import leg_clearance, loop_bottom, loop_turns
from .fidelity import carries_torque
from .neglected_effects import neglected_text
from .rope_system import ANGLE
from .shaft import BODIES, TURNED_FAR, direction
from .state import RopeState

#: of the legs: the loop is turned over
HALF_A_TURN = 0.5
#: rad: yaw at rest of a rope whose data should be looked at
YAWED_FAR = math.pi / 6
#: m/s: a rope with less kinetic energy than all of it has at this speed is at rest
REST_SPEED = 1e-3


def neglected_effects(scene: Scene, state: RopeState) -> str:
    """'' where the fidelity computes all that the rope does; otherwise which outputs are 0 and no results."""
    return neglected_text(state.fidelity) if state.fidelity == "rigid" or carries_torque(scene) else ""


def passed_bodies(scene: Scene, state: RopeState) -> str:
    """'' while the rope touches nothing; otherwise what it struck or passed into, when and where."""
    told = ""
    for name, x in zip(KINDS, state.nearest, strict=True):
        if x.clearance <= 0:
            passed = messages.passed_into(BODIES[name], x.touched_at, -x.clearance, x.time, x.s, x.y)
            told = messages.and_another(told, passed) if told else passed
    if not told or not may_touch(scene.shaft):
        return messages.rope_passed_into(told) if told else ""
    if min(x.clearance for x in state.nearest) > -scene.rope.diameter:
        return messages.rope_struck(told)
    return messages.rope_pressed_into(told, scene.shaft.contact.stiffness)


def passed_sides(scene: Scene, state: RopeState) -> str:
    """'' while no side of the rope has passed through the other; otherwise how often, and since when."""
    _, number, since, y = state.crossing
    return messages.sides_passed(number, since, y) if number else ""


def leg_contact(scene: Scene, state: RopeState) -> str:
    """'' while the legs hang free of each other; otherwise how they do not."""
    q, lengths, yaw = state.motion.q, state.partition.lengths, _yaw(state)
    if abs(yaw) > TURNED_FAR and not state.crossing.number:
        bottom, loop = loop_bottom(q, lengths), loop_width(scene)
        if abs(turns := loop_turns(q, lengths, bottom).number) >= HALF_A_TURN:
            return messages.turned_around(turns)
        clearance = leg_clearance(q, lengths, bottom, loop, scene.rope.diameter, scene.layout.spacing)
        if clearance <= 0:
            return messages.legs_touch(clearance, yaw)
    return ""


def yaw_at_rest(scene: Scene, state: RopeState) -> str:
    """'' unless the loop hangs yawed at rest; then by how much, and which datum turns it."""
    if (
        not _rests(scene, state)
        or state.fidelity != "torsional"
        or abs(_yaw(state)) <= YAWED_FAR
        or state.crossing.number
        or leg_contact(scene, state)
    ):
        return ""
    return messages.yawed_at_rest(_yaw(state), YAWED_FAR, _torque_source(scene, state))


def other_rests(scene: Scene, state: RopeState) -> str:
    """'' unless the rope hangs as it does because it snapped over; then at which twist."""
    if state.snapped_at == 0 or not _rests(scene, state):
        return ""
    return messages.other_rests(state.snapped_at)


def _rests(scene: Scene, state: RopeState) -> bool:
    data = scene.rope
    return state.energy_balance.kinetic < 0.5 * data.mass_per_length * data.length * REST_SPEED**2


def missing_loads(scene: Scene, state: RopeState) -> str:
    """'' unless a force or a moment is missing; then how much of it."""
    audit = state.audit
    if audit.missing_force > (bound := MISSING_FORCE * audit.force):
        return messages.forces_missing(audit.missing_force, bound)
    bound = MISSING_MOMENT * audit.force * scene.layout.spacing
    return messages.moments_missing(audit.missing_moment, bound) if audit.missing_moment > bound else ""


def unresolved_waves(scene: Scene, state: RopeState) -> str:
    """'' unless end forces changed a lot in steps too long to follow; then by how much, and the step that would do."""
    audit = state.audit
    if audit.share * FEWEST_STEPS <= 1.0 or audit.force_change <= LARGE_CHANGE * audit.force:
        return ""
    return messages.waves_unresolved(audit.force_change, 1.0 / audit.share, FEWEST_STEPS, axial_step(scene.rope))


def unresolved_bend(scene: Scene, state: RopeState) -> str:
    """'' unless an element turns too far; then how many a bend has."""
    elements = elements_per_bend(state.audit.bend) if state.audit.bend else FEWEST_ELEMENTS
    return messages.bend_unresolved(elements, FEWEST_ELEMENTS) if elements < FEWEST_ELEMENTS else ""


def accuracy_given_up(scene: Scene, state: RopeState) -> str:
    """'' unless the bound on work was reached; then how often, and since when."""
    if not state.counts.given_up:
        return ""
    return messages.accuracy_given_up(state.counts.given_up, state.given_up_since, scene.solver.work_max)


def _torque_source(scene: Scene, state: RopeState) -> str:
    """What makes the largest torque, and its cure."""
    rope, turned = scene.rope, _end_twist(state)
    causes = {
        messages.torque_of_coupling(rope.Qb, rope.Qc): coupling_torque(rope, scene.layout.gravity),
        messages.torque_of_twist(rope.installed_twist): twist_torque(rope, rope.installed_twist),
        # the installed twist is part of it
        messages.torque_of_ends(turned): twist_torque(rope, turned) * (1 - 1e-9),
    }
    return max(causes, key=causes.__getitem__)


def _yaw(state: RopeState) -> float:
    """Yaw (rad) of the loop against its ends."""
    return state.loop_yaw - direction(state.motion.q)


def _end_twist(state: RopeState) -> float:
    """Twist (rad) of the rope from end to end by conveyances and swivels that have turned against the ends' line."""
    (left, right), q = state.offsets, state.motion.q
    # a yaw about Y twists either end by itself, and both when the whole rope is turned
    return float(q[-1, ANGLE]) - right - (float(q[0, ANGLE]) - left) - 2 * direction(q)


#: each tells of one thing, in the order of rope_warning in rope.h
WARNINGS: tuple[Callable[[Scene, RopeState], str], ...] = (
    passed_bodies,
    passed_sides,
    neglected_effects,
    leg_contact,
    yaw_at_rest,
    other_rests,
    missing_loads,
    unresolved_waves,
    unresolved_bend,
    accuracy_given_up,
)
