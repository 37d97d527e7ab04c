"""Bodies of a scene at their present positions, and the check that they leave room for the rope's ends."""

import math
from functools import reduce

from rope_model.boundary.end_paths import EndMotion
from rope_model.messages import messages
from rope_model.messages.rules import Rules
from rope_model.parameters import Scene
from rope_model.physics import shaft as physics
from rope_model.physics.centreline import (
    suspension_points,
)
from rope_model.physics.elementary import (
    Scalar,
    logical_and,
    logical_or,
    minimum,
    sum_of,
    where,
)
from rope_model.physics.shaft import Body
from rope_model.shaft_parameters import FAR, Shaft
from rope_model.solver_parameters import FidelityChoice


def may_touch(shaft: Shaft) -> Scalar:
    """Return whether there are bodies that hold the rope."""
    dividers = shaft.divider_1, shaft.divider_2, shaft.divider_3, shaft.divider_4
    sizes = sum_of((divider.size for divider in dividers), shaft.lining.width)
    sizes += shaft.conveyance.width + shaft.head_ropes.diameter
    return logical_and(shaft.contact.stiffness > 0, logical_or(sizes > 0, shaft.sump.level > -FAR))


def min_body_thickness(scene: Scene) -> Scalar:
    """Return the shortest way (m) of the rope's centre line through a body that holds it; infinite without one.

    Linings, conveyances and the ground are thick.
    """
    shaft = scene.shaft
    diameter = scene.rope.diameter
    dividers = shaft.divider_1, shaft.divider_2, shaft.divider_3, shaft.divider_4
    thin = [
        where(body > 0, body, math.inf)
        for body in (*(x.size for x in dividers), shaft.head_ropes.diameter)
    ]
    return where(shaft.contact.stiffness > 0, reduce(minimum, thin), math.inf) + diameter


def _in_lining(
    scene: Scene, fidelity: FidelityChoice, left: EndMotion, right: EndMotion
) -> tuple[Scalar, ...]:
    shaft = scene.shaft
    lining = scene.shaft.lining
    diameter = scene.rope.diameter
    distance = _min_distance(scene, left, right, physics.lining(lining))
    # ends are accepted while their centre line is free
    beyond = logical_or(distance < 0, minimum(lining.width, lining.depth) < diameter)
    applies = logical_and(
        fidelity != "rigid", shaft.contact.stiffness > 0, lining.width > 0, beyond
    )
    return applies, 0.5 * diameter - distance, lining.width, lining.depth, lining.x, lining.z


def _below_floor(
    scene: Scene, fidelity: FidelityChoice, left: EndMotion, right: EndMotion
) -> tuple[Scalar, ...]:
    shaft = scene.shaft
    level = scene.shaft.sump.level
    distance = _min_distance(scene, left, right, physics.floor(shaft.sump))
    return (
        logical_and(fidelity != "rigid", shaft.contact.stiffness > 0, level > -FAR, distance < 0),
        -distance,
        level,
    )


def _min_distance(scene: Scene, left: EndMotion, right: EndMotion, body: Body) -> Scalar:
    """Return the least distance (m) of the rope's ends from the body."""
    return minimum(
        *(physics.distance(point, body) for point in suspension_points(scene.layout, left, right))
    )


#: reasons why a rope finds no equilibrium between bodies
NO_ROOM: Rules = {messages.end_in_lining: _in_lining, messages.end_below_floor: _below_floor}

#: kinds of bodies in words
BODIES = {
    "lining": "the shaft's lining",
    "conveyance": "a conveyance",
    "head_ropes": "head ropes",
    "divider": "a divider",
    "floor": "the sump's floor",
}
#: m, possible excess of a clearance
RESOLUTION = 1e-3
#: rad, yaw of the loop beyond which legs that are apart have crossed
TURNED_FAR = 0.5 * math.pi
#: s, interval of the checks: a rope that swings at 10 m/s moves by less than bodies are thick
MONITOR_INTERVAL = 0.01
