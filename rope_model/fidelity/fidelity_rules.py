"""Decision rules of the fidelity, with their error estimates; fidelity.choice and its C apply them.

carries_torque, force_error and unsupported_input also serve mesh, stepping and outputs.
"""

import math
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from rope_model.boundary.bodies import may_touch
from rope_model.boundary.end_paths import EndMotion
from rope_model.messages import fidelity_messages
from rope_model.messages.rules import Rules
from rope_model.parameters import AT_START, Scene
from rope_model.physics import estimates
from rope_model.physics.air import air_acts
from rope_model.physics.elementary import Scalar, logical_and, logical_or, maximum, where
from rope_model.physics.estimates import Travel
from rope_model.physics.guard import any_threshold
from rope_model.physics.inextensible import min_tension, rigid_tensions
from rope_model.physics.initial_curvature import max_curvature
from rope_model.solver_parameters import FidelityChoice

TURNED = ("yaw", "yaw_rate")  #: inputs that turn a rope whose swivels hold
OUT_OF_PLANE = ("z", "vz", "az", "lean_z")  #: inputs out of the plane
ALONG = ("vx", "ax", "lean")  #: inputs that move the ends in the plane
#: inputs in the order of their numbers
INPUTS = tuple(field.name for field in fields(EndMotion))


def carries_torque(scene: Scene) -> Scalar:
    """Return whether the rope carries torque even in the plane while its ends do not turn."""
    return logical_or(_coupled(scene)[0], _twisted(scene)[0], _curved(scene)[0])


def not_plumb(scene: Scene) -> Scalar:
    """Return whether an end of the rope is clamped otherwise, or hinged."""
    return logical_or(scene.left.attachment != "plumb", scene.right.attachment != "plumb")


def expected_travel(ends: Sequence[EndMotion]) -> estimates.Travel:
    """Return the motion to expect of ends that move like this."""
    left, right = ends
    speed = maximum(abs(left.vy), abs(right.vy))
    acceleration = maximum(abs(left.ay), abs(right.ay))
    return estimates.travel_estimate(abs(left.y - right.y), speed, acceleration)


def force_error(scene: Scene, fidelity: FidelityChoice, travel: Travel) -> Scalar:
    """Return the estimated error of the end forces against the complete model; inf if the loop may turn far."""
    locked = logical_and(scene.left.mode == "locked", scene.right.mode == "locked")
    torque_error = estimates.held_error(scene, travel) + where(
        locked, 0.0, estimates.release_error(scene, travel)
    )
    torque_error = where(estimates.loop_yaw(scene) > estimates.MAX_YAW, math.inf, torque_error)
    error = where(logical_and(fidelity != "torsional", carries_torque(scene)), torque_error, 0.0)
    loop_error = estimates.longitudinal_error(scene, travel) + estimates.lean_error(scene, travel)
    return error + where(fidelity == "rigid", loop_error, 0.0)


def first_input(
    left: EndMotion, right: EndMotion, turned: Scalar, across: Scalar, along: Scalar
) -> Scalar:
    """Return the number, from 1 on, of the first input that is not zero, of the kinds that count; 0: none."""
    first: Any = 0.0
    kinds = (along, ALONG), (across, OUT_OF_PLANE), (turned, TURNED)
    for counts, names in ((counts, names) for counts, names in kinds if counts is not False):
        for before, end in ((len(INPUTS), right), (0, left)):
            for name in reversed(names):
                number = float(1 + before + INPUTS.index(name))
                first = where(logical_and(counts, getattr(end, name) != 0), number, first)
    return first


def out_of_plane(number: Scalar) -> Scalar:
    """Return whether the input of this number acts out of the plane."""
    numbers = (
        before + 1 + INPUTS.index(name) for before in (0, len(INPUTS)) for name in OUT_OF_PLANE
    )
    return logical_or(*(number == own for own in numbers))


def held_input(left: EndMotion, right: EndMotion) -> Scalar:
    """Return the number of the input that twists or bends the rope where it starts with its swivels held; 0: none."""
    return first_input(left, right, True, True, False)


def unsupported_input(
    scene: Scene, fidelity: FidelityChoice, left: EndMotion, right: EndMotion
) -> Scalar:
    """Return the number of the first input that ``fidelity``, not torsional, leaves out; 0: none."""
    held = _turns_freely(scene) == 0
    across = logical_or(fidelity != "spatial", logical_and(held, scene.model.fidelity == "auto"))
    return first_input(left, right, held, across, fidelity == "rigid")


def _turns_freely(scene: Scene) -> Scalar:
    """Return whether both swivels turn from the start of any run; one that waits for 0 is held before."""
    free = (
        logical_and(x.mode == "free", x.release_time <= AT_START) for x in (scene.left, scene.right)
    )
    return logical_and(*free)


def _coupled(scene: Scene) -> tuple[Scalar, ...]:
    rope = scene.rope
    return logical_or(rope.Qs != 0, rope.Qk != 0), rope.Qb, rope.Qc


def _twisted(scene: Scene) -> tuple[Scalar, ...]:
    return scene.rope.installed_twist != 0, scene.rope.installed_twist


def _curved(scene: Scene) -> tuple[Scalar, ...]:
    largest = max_curvature(scene.rope)
    return largest > 0, largest


def _error_above_tolerance(
    scene: Scene, fidelity: FidelityChoice, left: EndMotion, right: EndMotion, forces: Scalar
) -> tuple[Scalar, ...]:
    error = force_error(scene, fidelity, expected_travel((left, right)))
    tolerance = scene.model.force_tolerance
    return error > tolerance, 100 * tolerance, 100 * error


def _would_go_slack(
    scene: Scene, fidelity: FidelityChoice, left: EndMotion, right: EndMotion, forces: Scalar
) -> tuple[Scalar, ...]:
    tension = min_tension(rigid_tensions(scene.rope, scene.layout, left, right))
    return logical_and(fidelity == "rigid", tension < 0), tension


def _no_torque(
    scene: Scene, fidelity: FidelityChoice, left: EndMotion, right: EndMotion
) -> tuple[Scalar, ...]:
    return (logical_and(fidelity != "rigid", carries_torque(scene) == 0),)


def _error_within_tolerance(
    scene: Scene, fidelity: FidelityChoice, left: EndMotion, right: EndMotion
) -> tuple[Scalar, ...]:
    travel = expected_travel((left, right))
    tolerance = scene.model.force_tolerance
    error = force_error(scene, fidelity, travel)
    return fidelity != "torsional", fidelity, 100 * error, 100 * tolerance, *travel[1:]


def _air_acts(scene: Scene) -> Scalar:
    return air_acts(scene.shaft.air, scene.rope.diameter) > 0


#: reasons why a rope carries torque
TORQUE: Rules = {fidelity_messages.coupled: _coupled, fidelity_messages.twisted: _twisted}
#: reasons for the complete model wherever the ends are; ``forces`` is the number of points with
#: applied forces
COMPLETE: Rules = {
    fidelity_messages.may_touch: lambda scene, forces: (may_touch(scene.shaft),),
    fidelity_messages.may_touch_itself: lambda scene, forces: (
        scene.shaft.contact.rope_stiffness > 0,
    ),
    fidelity_messages.guards_watch: lambda scene, forces: (any_threshold(scene.shaft.guard) > 0,),
    fidelity_messages.in_air: lambda scene, forces: (_air_acts(scene),),
    fidelity_messages.is_curved: lambda scene, forces: _curved(scene),
    fidelity_messages.not_plumb: lambda scene, forces: (not_plumb(scene),),
    fidelity_messages.is_pushed: lambda scene, forces: (forces > 0,),
}
#: reasons of 'auto' against a fidelity that supports all inputs
UNSUPPORTED: Rules = {
    fidelity_messages.applied_forces: lambda scene, fidelity, left, right, forces: (forces > 0,),
    fidelity_messages.error_above_tolerance: _error_above_tolerance,
    fidelity_messages.would_go_slack: _would_go_slack,
}
#: reasons why a fidelity below the complete one serves; without torque the planar one does, except
#: for a rigid rope
SUFFICIENT: Rules = {
    fidelity_messages.no_torque: _no_torque,
    fidelity_messages.error_within_tolerance: _error_within_tolerance,
}
