"""Errors of the loop at rest by the mesh, and the elements that keep them small.

On elements of x w, w = (EI / rho g)^(1/3) the length of a bend, the loop hangs too low by

    LOOP_POSITION w x^4                                                     (evidence.mesh_rule.laws)

On longer elements it slips aside and yaws until another node is lowest: its error grows by
(1 + (x / SLIPS_FROM)^4) / (1 + (x / SLIPS_TO)^6), and it yaws by TURNED x^5 / (TURNS_FROM^4 + x^4)
(evidence.mesh_rule.coarse).

Every transformation of the mesh adds ADDED of that error.  A mesh that follows the loop for the whole
length L of the rope makes L / (8 x w) of them.
"""

from rope_model.parameters import Scene
from rope_model.physics.elementary import Scalar, minimum, sqrt
from rope_model.physics.estimates import bending_length

LOOP_POSITION = 0.0025
#: from ropes of 750 to 1190 m with a tenth of the default errors; a rope of 120 m that goes to and
#: fro adds a third to a half of it
ADDED = 0.04
#: of the loop's elements, between two transformations
ELEMENTS_OF_TRANSFORMATION = 8.0
SLIPS_FROM = 1.03  #: x at which the loop's slip doubles the error
SLIPS_TO = 1.52  #: x from which it slips no longer with the fourth power of their length
TURNED = 0.0105  #: rad, yaw of the loop over x
TURNS_FROM = 2.45  #: x at which half of that yaw is reached
LARGEST = 100.0  #: x from which on errors are those of x
LEG_MESH_ERROR = 4e-7  #: part by joined elements of the legs, over grading_length times length


def bend_error(scene: Scene, l: Scalar) -> Scalar:
    """Return the distance (m) by which the loop hangs too low on elements of length ``l``, but for its slip."""
    x = _relative_length(scene, l)
    square = x * x
    return LOOP_POSITION * bending_length(scene) * (square * square)


def length_for(scene: Scene, error: Scalar) -> Scalar:
    """Return the length (m) of elements whose ``bend_error`` is ``error`` (m)."""
    w = bending_length(scene)
    return w * sqrt(sqrt(error / (LOOP_POSITION * w)))


def travelling_length_for(scene: Scene, error: Scalar) -> Scalar:
    """Return the length (m) of elements with a ``bend_error`` of ``error`` (m) after a trip along the whole rope."""
    length = length_for(scene, error)
    for _ in range(4):  # each leaves less than a quarter of the difference
        number = scene.rope.length / (ELEMENTS_OF_TRANSFORMATION * length)
        length = length_for(scene, error / (1.0 + ADDED * number))
    return length


def mesh_error(scene: Scene, l: Scalar, grading_length: Scalar, transformations: Scalar) -> Scalar:
    """Return the loop's position error (m) on elements of length ``l``, with ``grading_length`` in the legs."""
    x = _relative_length(scene, l)
    legs = LEG_MESH_ERROR * grading_length * scene.rope.length
    return bend_error(scene, l) * slip_factor(x) * (1.0 + ADDED * transformations) + legs


def slip_factor(x: Scalar) -> Scalar:
    """Return the growth of the error by the loop's slip on elements of ``x`` w."""
    return (1.0 + (x / SLIPS_FROM) ** 4) / (1.0 + (x / SLIPS_TO) ** 6)


def turned_by_mesh(scene: Scene, l: Scalar) -> Scalar:
    """Return the angle (rad) by which elements of length ``l`` turn the loop about the vertical."""
    x = _relative_length(scene, l)
    power = x**4
    return TURNED * x * power / (TURNS_FROM**4 + power)


def _relative_length(scene: Scene, l: Scalar) -> Scalar:
    return minimum(l / bending_length(scene), LARGEST)
