"""Warnings about valid results for which a real rope would behave differently, or which are inaccurate.

    passed_bodies       the rope has passed into bodies of its shaft: contact is not in the model
    passed_sides        the legs have passed through each other, or one through what hangs above the other
    neglected_effects   the model computes no torsion, and the rope carries torque; or it is the rigid one
    leg_contact         the loop is turned over, or the legs touch, or have touched
    yaw_at_rest         the loop hangs far out of its ends' plane at rest, by a torque that is too large for a shaft
    other_rests         the rope has several equilibria, and snapped through on the way to this one
    missing_loads       the change of momentum differs from the end forces and the weight
    unresolved_waves    end forces jump in steps that are too long for the waves of such a jump, or an
                        end shakes sideways with waves that are too short for the legs' elements
    unresolved_bend     elements are too long for the sharpest bend
    accuracy_given_up   errors of steps exceed the tolerance because work_max allows no more steps
    blind_guards        the model does not compute the quantity of a guard
    no_air              wind or conveyances move the air, which has no density
    unfit_inputs        the given motions are inconsistent: rounded, interpolated, repeated or of two motions

Two straight legs between ends a width apart and a loop of about that width, turned by psi, come as
near to each other as cos(psi / 2) of it: they meet at half a turn.  On a deep rope they need not:
the long leg can swing around the short one, its conveyance and head ropes.  That is half a turn
over the height (diagnostics.loop_turns), too.
"""

from collections.abc import Callable
from functools import partial

from rope_model.arrays import Array
from rope_model.boundary.bodies import BODIES, may_touch
from rope_model.fidelity.neglected_effects import neglected_text
from rope_model.messages import warning_messages
from rope_model.messages.rules import first_text
from rope_model.parameters import Scene
from rope_model.physics import centreline
from rope_model.physics.node import ANGLE, SIDES
from rope_model.physics.shaft import KINDS
from rope_model.state import RopeState
from rope_model.warnings import warning_rules


def neglected_effects(scene: Scene, state: RopeState) -> str:
    """Return '' if the fidelity computes all effects on the rope; otherwise the outputs that are 0 and no results."""
    if warning_rules.leaves_out(scene, state):
        return neglected_text(state.fidelity)
    return ""


def passed_bodies(scene: Scene, state: RopeState) -> str:
    """Return '' while the rope touches nothing; otherwise the bodies that it struck or passed into, time and place."""
    text = ""
    for name, x in zip(KINDS, state.nearest, strict=True):
        if x.clearance <= 0:
            passed = warning_messages.passed_into(
                BODIES[name], x.touched_at, -x.clearance, x.time, x.s, x.y
            )
            text = warning_messages.and_another(text, passed) if text else passed
    if not text or not may_touch(scene.shaft):
        return warning_messages.rope_passed_into(text) if text else ""
    if min(x.clearance for x in state.nearest) > -scene.rope.diameter:
        return warning_messages.rope_struck(text)
    return warning_messages.rope_pressed_into(text, scene.shaft.contact.stiffness)


def leg_contact(scene: Scene, state: RopeState) -> str:
    """Return '' while the legs hang, and have hung, free of each other; otherwise how they do not."""
    return first_text(warning_rules.LEG_CONTACT, scene, state, _yaw(state))


def yaw_at_rest(scene: Scene, state: RopeState) -> str:
    """Return '' unless the loop hangs yawed at rest; then its yaw, and the parameter that turns it."""
    yaw = _yaw(state)
    if not warning_rules.yawed_far_at_rest(scene, state, yaw):
        return ""
    source = first_text(warning_rules.TORQUE_SOURCE, scene, _end_twist(state))
    return warning_messages.yawed_at_rest(yaw, warning_rules.YAWED_FAR, source)


def unfit_inputs(scene: Scene, state: RopeState) -> str:
    """Return '' while the given motions are consistent; otherwise their likely fault, and a cure."""
    for side, end_filter in zip(SIDES, state.filters, strict=True):
        if text := first_text(warning_rules.INPUTS, scene, end_filter, state.last_interval):
            return warning_messages.of_end(side, text)
    return ""


def _yaw(state: RopeState) -> float:
    """Return the yaw (rad) of the loop against its ends."""
    return state.loop_yaw - ends_yaw(state.motion.q)


def _end_twist(state: RopeState) -> float:
    """Return the twist (rad) of the rope from end to end by conveyances and swivels turned against the ends' line."""
    left, right = state.offsets
    q = state.motion.q
    # a yaw about Y twists either end separately, and both when the whole rope is turned
    return float(q[-1, ANGLE]) - right - (float(q[0, ANGLE]) - left) - 2 * ends_yaw(q)


#: warnings in the order of rope_warning in rope.h
WARNINGS: dict[str, Callable[[Scene, RopeState], str]] = {
    "passed_bodies": passed_bodies,
    "passed_sides": partial(first_text, warning_rules.PASSED_SIDES),
    "neglected_effects": neglected_effects,
    "leg_contact": leg_contact,
    "yaw_at_rest": yaw_at_rest,
    "other_rests": partial(first_text, warning_rules.OTHER_RESTS),
    "missing_loads": partial(first_text, warning_rules.MISSING_LOADS),
    "unresolved_waves": partial(first_text, warning_rules.UNRESOLVED_WAVES),
    "unresolved_bend": partial(first_text, warning_rules.UNRESOLVED_BEND),
    "accuracy_given_up": partial(first_text, warning_rules.ACCURACY_GIVEN_UP),
    "blind_guards": partial(first_text, warning_rules.BLIND_GUARDS),
    "no_air": partial(first_text, warning_rules.NO_AIR),
    "unfit_inputs": unfit_inputs,
}


def ends_yaw(q: Array) -> float:
    """Return the yaw (rad) of the line from the left to the right end."""
    return float(centreline.line_yaw(q[0], q[-1]))
