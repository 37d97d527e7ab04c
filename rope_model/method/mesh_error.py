"""Errors of the loop at rest by the mesh, and the elements that keep them small.

On elements of x w, w = (EI / rho g)^(1/3) the length of a bend, the loop is off by

    LOOP_POSITION w x^4                                 it hangs too low (evidence.mesh_rule.laws)

Every transformation of the mesh leaves LEFT of that error behind: a mesh that follows the loop for
the whole length of the rope makes some L / (8 x w) of them.

A loop of longer elements slips aside and yaws until another node is lowest
(evidence.mesh_rule.coarse): its error grows by (1 + (x / SLIPS_FROM)^4) / (1 + (x / SLIPS_TO)^6), and
it yaws by TURNED x^5 / (TURNS_FROM^4 + x^4).
"""

from rope_model.parameters import Scene
from rope_model.physics.elementary import Scalar, minimum, sqrt
from rope_model.physics.estimates import bending_length

LOOP_POSITION = 0.0025
LEFT = 0.04  #: part of the error that a transformation leaves behind
#: transformations of a trip times w / L, with elements of half of w
TRANSFORMATIONS = 0.25
SLIPS_FROM = 1.03  #: x from which elements are so long that the loop slips aside
SLIPS_TO = 1.52  #: x from which it slips no longer with the fourth power of their length
TURNED = 0.0105  #: rad, yaw of the loop over x
TURNS_FROM = 2.45  #: x at which half of that yaw is reached
LONGEST = 100.0  #: largest x that tells elements apart
LEG_MESH_ERROR = 4e-7  #: part by joined elements of the legs, over grading_length times length


def bend_error(scene: Scene, l: Scalar) -> Scalar:
    """Return the distance (m) by which the loop hangs too low on elements of length ``l``."""
    w = bending_length(scene)
    x = l / w
    square = x * x
    return LOOP_POSITION * w * (square * square)


def length_for(scene: Scene, error: Scalar) -> Scalar:
    """Return the length (m) of elements whose ``bend_error`` is ``error`` (m)."""
    w = bending_length(scene)
    return w * sqrt(sqrt(error / (LOOP_POSITION * w)))


def travelling_length_for(scene: Scene, error: Scalar) -> Scalar:
    """Return the length (m) of elements whose error is ``error`` (m) after the rope has run through the loop."""
    number = TRANSFORMATIONS * scene.rope.length / bending_length(scene)
    return length_for(scene, error / (1.0 + LEFT * number))


def mesh_error(scene: Scene, l: Scalar, grading_length: Scalar, transformations: Scalar) -> Scalar:
    """Return the loop's position error (m) on elements of length ``l``, with ``grading_length`` in the legs."""
    x = _relative_length(scene, l)
    slipped = (1.0 + (x / SLIPS_FROM) ** 4) / (1.0 + (x / SLIPS_TO) ** 6)
    legs = LEG_MESH_ERROR * grading_length * scene.rope.length
    return bend_error(scene, l) * slipped * (1.0 + LEFT * transformations) + legs


def turned_by_mesh(scene: Scene, l: Scalar) -> Scalar:
    """Return the angle (rad) by which elements of length ``l`` turn the loop about the vertical."""
    x = _relative_length(scene, l)
    power = x**4
    return TURNED * x * power / (TURNS_FROM**4 + power)


def _relative_length(scene: Scene, l: Scalar) -> Scalar:
    return minimum(l / bending_length(scene), LONGEST)
