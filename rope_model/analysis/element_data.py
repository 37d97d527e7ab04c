"""Arguments of the element's functions at the engine's present state: physics.rope_element."""

from dataclasses import dataclass

import numpy as np

from rope_model.arrays import Array
from rope_model.engine import NativeRope
from rope_model.physics.air import air_acts, air_coefficients
from rope_model.physics.air_element import COEFFICIENTS_SIZE
from rope_model.physics.element import parameters
from rope_model.physics.node import NODE_DOF
from rope_model.physics.rope_element import AIR, CURVED, WIRES, Features
from rope_model.physics.wire_element import TANGENT_SIZE


@dataclass(frozen=True)
class ElementData:
    """Elements of a rope away from bodies: their features, lengths (m), frames F and parameters P."""

    features: Features
    lengths: Array  #: (elements,)
    frames: Array  #: (elements, ...), at the rope that they are referred to
    parameters: Array  #: (...), those of the material alone
    air: Array  #: numbers of the air, empty without air

    def parameters_at(self, q: Array, v: Array) -> Array:
        """Return P of a rope ``q`` that moves with ``v`` (nodes, 7): the conveyances move as its ends do."""
        if not self.air.size:
            return self.parameters
        ends = [0, -1]
        passing = np.column_stack((q[ends, :3], v[ends, 1]))
        return np.concatenate((self.parameters, self.air, passing.ravel()))


def element_data(rope: NativeRope) -> ElementData:
    """Return the elements of a torsional rope with their frames at its present state."""
    scene = rope.scene
    facts = rope.linear_facts()
    frames = rope.frames()
    features: list[int] = []
    if facts.curved:
        features.append(CURVED)
    if facts.rubs:
        features.append(WIRES)
        # the residual does not depend on the latest tangents
        frames = np.hstack((frames, np.zeros((len(frames), TANGENT_SIZE))))
    air = np.zeros(0)
    if air_acts(scene.shaft.air, scene.rope.diameter):
        features.append(AIR)
        law = air_coefficients(scene.shaft.air, scene.rope.diameter, scene.layout.spacing)
        air = np.array(law.numbers())
        assert air.size == COEFFICIENTS_SIZE
    return ElementData(
        tuple(features),
        rope.state.partition.lengths,
        frames,
        np.array(parameters(scene.rope, scene.layout.gravity)),
        air,
    )


def of_elements(x: Array) -> Array:
    """Return values at the nodes (nodes, 7) as columns of elements, those of both nodes (14, elements)."""
    return np.concatenate((x[:-1], x[1:]), axis=1).T


def to_nodes(R: Array) -> Array:
    """Return the sum at the nodes (nodes, 7) of values of elements (14, elements)."""
    of_first = R[:NODE_DOF].T
    of_second = R[NODE_DOF:].T
    nodes = np.zeros((R.shape[1] + 1, NODE_DOF))
    nodes[:-1] += of_first
    nodes[1:] += of_second
    return nodes
