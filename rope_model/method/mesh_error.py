"""Errors of the loop at rest by the mesh, and the elements that keep them small.

With elements of x w, w the length of a bend, the loop hangs too high by

    LOOP_HEIGHT w x^2 N / (1 + N),     N = LOCKING x^4 EA w^2 / EI

(evidence.mesh_rule.laws).  A loop of long elements slips aside and turns until another node is
lowest (evidence.mesh_rule.coarse).
"""

from rope_model.parameters import Scene
from rope_model.physics.elementary import Scalar, maximum, minimum, sqrt
from rope_model.physics.estimates import bending_length

LOOP_HEIGHT = 0.0214
LOCKING = 0.0028
SLIPPED = 1.8  #: growth of the loop's position error on long elements
SLIPS_FROM = 0.87  #: x at which half of that growth is reached
TURNED = 0.033  #: rad, yaw of the loop over x
TURNS_FROM = 1.2  #: x at which half of that yaw is reached
SLIP_EXPONENT = 12  #: power of x with which both set in
LEG_MESH_ERROR = 4e-7  #: part by joined elements of the legs, over grading_length times length


def locking_error(scene: Scene, l: Scalar) -> Scalar:
    """Return the height (m) by which the loop hangs too high on elements of length ``l``."""
    w = bending_length(scene)
    rope = scene.rope
    x = l / w
    locking = LOCKING * (rope.Qa * (w * w) / rope.EI) * (x * x * x * x)
    return LOOP_HEIGHT * w * (x * x) * (locking / (1.0 + locking))


def length_for(scene: Scene, error: Scalar) -> Scalar:
    """Return the length (m) of elements whose ``locking_error`` is between half of ``error`` (m) and ``error``."""
    w = bending_length(scene)
    rope = scene.rope
    ratio = error / (LOOP_HEIGHT * w)
    return w * maximum(sqrt(ratio), (ratio / (LOCKING * (rope.Qa * (w * w) / rope.EI))) ** (1 / 6))


def mesh_error(scene: Scene, l: Scalar, grading_length: Scalar) -> Scalar:
    """Return the loop's position error (m) on elements of length ``l``, with ``grading_length`` in the legs."""
    slip_factor = 1.0 + SLIPPED * _slip_fraction(scene, l, SLIPS_FROM)
    return (
        locking_error(scene, l) * slip_factor + LEG_MESH_ERROR * grading_length * scene.rope.length
    )


def turned_by_mesh(scene: Scene, l: Scalar) -> Scalar:
    """Return the angle (rad) by which elements of length ``l`` turn the loop about the vertical."""
    return TURNED * l / bending_length(scene) * _slip_fraction(scene, l, TURNS_FROM)


def _slip_fraction(scene: Scene, l: Scalar, threshold: float) -> Scalar:
    """Return the fraction, 0 to 1, of a change that sets in where elements are ``threshold`` w long."""
    power = minimum(l / (threshold * bending_length(scene)), 10.0) ** SLIP_EXPONENT
    return power / (1.0 + power)
