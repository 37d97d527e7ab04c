"""Bodies around a rope for its equations of motion: positions, velocities, and distances from its elements.

A moving body follows an end of the rope, whose rows in q and v give its position and velocity.  Rope below a conveyance
touches neither it nor its head ropes within OWN_LENGTH of the suspension.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from rope_model.arrays import Array
from rope_model.parameters import Scene
from rope_model.physics.centreline import enclosing_box
from rope_model.physics.contact import OWN_LENGTH
from rope_model.physics.contact_element import LAW
from rope_model.physics.node import POSITION
from rope_model.physics.shaft import Body, least_distance
from rope_model.rules.bodies import FIXED, may_touch, placed_bodies
from rope_model.rules.end_paths import END_NODE


@dataclass(frozen=True)
class Obstacles:
    """Bodies of a scene, with their kinds in order."""

    scene: Scene
    kinds: tuple[int, ...]

    def numbers(self, q: Array, v: Array) -> Array:
        """Return the contact entries of P for physics.contact_element."""
        law = {"diameter": self.scene.rope.diameter} | vars(self.scene.shaft.contact)
        numbers = [law[name] for name in LAW]
        for _, end, body in placed_bodies(self.scene.shaft, q[[0, -1], POSITION].tolist()):
            speed = (0.0, 0.0, 0.0) if end == FIXED else v[END_NODE[end], POSITION]
            numbers += [*body.centre, *body.half, *body[2:], *speed]
        return np.array(numbers)

    def distances(self, q: Array, lengths: Array) -> Array:
        """Return the least distance (m) of each element's surface from each body (elements, bodies)."""
        box = np.array(enclosing_box(lengths, q[:-1].T, q[1:].T))[:, :, None]
        _, ends, placed = zip(
            *placed_bodies(self.scene.shaft, q[[0, -1], POSITION].tolist()), strict=True
        )
        distances = least_distance(box[:3], box[3:], _together(placed))
        along = np.cumsum(lengths) - 0.5 * lengths
        own = np.array([along, along[-1] + 0.5 * lengths[-1] - along]) < OWN_LENGTH
        for k, end in enumerate(ends):
            if end != FIXED:
                distances[own[end], k] = np.inf
        return np.asarray(distances - 0.5 * self.scene.rope.diameter)


def find_obstacles(scene: Scene) -> Obstacles | None:
    """Return the bodies that the rope of ``scene`` may touch, or None."""
    kinds = tuple(placed.kind for placed in placed_bodies(scene.shaft, 2 * [(0.0, 0.0, 0.0)]))
    return Obstacles(scene, kinds) if may_touch(scene.shaft) else None


def _together(placed: tuple[Body, ...]) -> Any:
    """Return the bodies as one Body whose entries are arrays."""
    numbers = np.array([[*body.centre, *body.half, *body[2:]] for body in placed]).T
    return Body(tuple(numbers[:3]), tuple(numbers[3:6]), *numbers[6:])
