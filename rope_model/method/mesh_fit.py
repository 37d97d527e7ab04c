"""Mesh that suits a rope, for mesh.kind = auto.

With w = (EI / rho g)^(1/3), the error of the loop's position at rest limits the length of its
elements: it grows with the fourth power of the length (method.mesh_error); docs/promise.md shows
the errors.  Segment IV covers the bend, its decay above, and the distance to the next
transformation.  The elements next to the clamped ends resolve the bending layer sqrt(EI / T).  A
rope too short or too stiff for this pattern gets equal elements.  Where a divider
may press a leg all elements are short enough for the waves of its blow, and shorter still where
they face it.

``python -m evidence.mesh_rule`` fits the basis of the constants.
"""

import math
from typing import Annotated, NamedTuple

from rope_model.method.mesh_error import travelling_length_for
from rope_model.method.step_control import BRAKED
from rope_model.method.step_errors import wave_duration
from rope_model.parameters import Scene
from rope_model.physics import contact_error
from rope_model.physics.elementary import (
    SMALLEST_DIVISOR,
    Scalar,
    ceil,
    cos,
    less,
    logical_and,
    logical_or,
    maximum,
    minimum,
    sqrt,
    where,
)
from rope_model.physics.estimates import axial_frequency, bending_length
from rope_model.shaft_parameters import Divider

#: distance (l) of the loop from the middle of segment IV at which a transformation is due: the
#: neighbouring mesh fits as well from 0.5 on; the margin keeps a loop that trembles by up to l/5
#: from transforming to and fro
DUE = 0.6
RATIO = 4.0  #: l over the length of the elements of IV: five segments
MAX_LEVELS = 8  #: largest end_levels
MESH_SHARE = 0.5  #: fraction of the loop's allowed error that the mesh may take
# upper bounds of grading_length
LEG_GRADING = 7.5e5  #: m, times loop_error / length: lag allowed to short waves on a long trip
#: m^2, over the length: short waves of an emergency stop (evidence.mesh_rule.trips)
LEG_WAVES = 1000.0
#: times w: at a height y above the loop elements are sqrt(grading_length y) long, and waves of the
#: loop's own frequency sqrt(g / w) are 2 pi sqrt(w y) long; four elements of such a wave, more of
#: them for errors of the loop below LEG_ERROR, by its fourth root
LEG_SWAY = 2.0
LEG_ERROR = 5e-3  #: m
# after an emergency stop longitudinal waves excite waves of half their frequency in the legs
# (pumped_grading); tuned on seeded ropes of 60 to 1200 m
PUMPED_ELEMENTS = 5.0  #: elements of such a wave
PUMPED_LEG = 0.75  #: length of the leg over that of the rope
PUMPED_GROWTH = 8.0  #: exponent of a wave's growth below which it needs fewer elements
PUMPED_ERROR = 5e-3  #: m, error of the loop below which elements are shorter, by its fourth root
#: elements of a wave of mesh.lateral_frequency: of 4, 5, 6 the end forces of rope-120 err by .15, .065,
#: .032 % at 3.5 Hz and 10 mm (evidence.shaking)
SHAKEN_ELEMENTS = 5.0
NATURAL_RADIUS = 0.912  #: smallest radius of curvature of the free loop over w: 1 / 1.09661
BEND_SHARE = 0.6  #: fraction of loop_error that the loop's elements may take at rest
#: longest element of the loop over w: on longer ones it slips aside, and transformations shake it
MAX_LENGTH = 0.65
# least arc length (w) of rope with the loop's elements on either side of its lowest point: where
# longer ones are bent a transformation lets the end forces jump
COVER = 1.9  #: for an error of the loop of COVER_ERROR
COVER_ERROR = 0.05  #: m
COVER_DECADE = 0.45  #: increase for a tenth of the error
#: distance (rope lengths) of the loop from an end down to which no part of the pattern is cut off:
#: ends 3/4 L apart
MIN_END_DISTANCE = 0.12
END_LENGTH = 2.9  #: length of the end elements over the bending layer there, shorter by the fifth root of the error
END_ERROR = 0.033  #: error of the loop over R to which END_LENGTH belongs
#: longest of equal elements over that of the end elements
EQUAL_ENDS = 2.0
BLOW = 0.01  #: s, delay of the elements of legs that a divider may press: physics.contact_error
REACH = 0.5  #: distance of such a leg from the divider over the spacing


class FittedLengths(NamedTuple):
    """Lengths (m) for the mesh: the loop's elements, what they cover on either side of it, end elements.

    ``grading``: square of the legs' elements over their distance from the loop.
    """

    fine_length: float
    cover: float
    end: float
    grading: float


def fit_lengths(scene: Scene, loop_error: Scalar, decades: Scalar) -> FittedLengths:
    """Return the lengths for a ``loop_error`` (m) that is ``decades`` powers of ten below COVER_ERROR."""
    rope = scene.rope
    w = bending_length(scene)
    radius = minimum(0.5 * scene.layout.spacing, NATURAL_RADIUS * w)
    shorter = (loop_error / (END_ERROR * radius)) ** 0.2
    fine_length = minimum(travelling_length_for(scene, BEND_SHARE * loop_error), MAX_LENGTH * w)
    cover = w * maximum(COVER + COVER_DECADE * decades, COVER)
    layer = sqrt(rope.EI / (0.5 * (rope.mass_per_length * scene.layout.gravity) * rope.length))
    sway = LEG_SWAY * w * sqrt(sqrt(minimum(loop_error / LEG_ERROR, 1.0)))
    grading = minimum(minimum(LEG_GRADING * loop_error, LEG_WAVES) / rope.length, sway)
    grading = minimum(
        grading, pumped_grading(scene) * sqrt(minimum(loop_error / PUMPED_ERROR, 1.0))
    )
    grading = minimum(grading, shaken_grading(scene))
    return FittedLengths(fine_length, cover, END_LENGTH * layer * shorter, grading)


def shaken_grading(scene: Scene) -> Scalar:
    """Return the grading that resolves waves of mesh.lateral_frequency, sqrt(g y) / frequency long; infinite for 0."""
    frequency = scene.mesh.lateral_frequency
    per_second = SHAKEN_ELEMENTS * maximum(frequency, SMALLEST_DIVISOR)
    # without a square of the smallest divisor
    return where(frequency > 0, scene.layout.gravity / per_second / per_second, math.inf)


def shaken_length(scene: Scene, height: Scalar) -> Scalar:
    """Return the longest element (m) at a ``height`` (m) above the loop for waves of mesh.lateral_frequency.

    EI k^4 + T k^2 = rho omega^2: near the loop EI makes them longer than on a string.
    """
    rope = scene.rope
    omega = 2.0 * math.pi * scene.mesh.lateral_frequency
    tension = rope.mass_per_length * scene.layout.gravity * height
    inertia = rope.mass_per_length * (omega * omega)
    # the root, and its conjugate as a divisor: no difference of nearly equal numbers
    square = 2.0 * inertia / (tension + sqrt(tension * tension + 4.0 * rope.EI * inertia))
    number = SHAKEN_ELEMENTS * sqrt(maximum(square, SMALLEST_DIVISOR))
    return where(omega > 0, 2.0 * math.pi / number, math.inf)


def pumped_grading(scene: Scene) -> Scalar:
    """Return the grading that resolves the transverse waves of the legs that grow after an emergency stop.

    A tension rho g y (1 + a cos omega t) excites waves of omega / 2 (Mathieu's equation): they grow
    by exp(a omega t / 8) and are 4 pi sqrt(g y) / omega long.  a is BRAKED, and lasts as long as
    the longitudinal wave.
    """
    rope = scene.rope
    g = scene.layout.gravity
    omega = axial_frequency(rope, PUMPED_LEG * rope.length)
    growth = 0.125 * BRAKED * omega * wave_duration(rope, omega)
    wavelength = 4.0 * math.pi / (PUMPED_ELEMENTS * omega)
    return g * (wavelength * wavelength) * (1.0 + (PUMPED_GROWTH / growth) ** 4)


#: positions of dividers on a rope that none may press: of each, on the left and the right leg
NO_DIVIDERS = (math.inf,) * 8


def divider_positions(
    scene: Scene, left: Scalar, right: Scalar
) -> Annotated[tuple[Scalar, ...], len(NO_DIVIDERS)]:
    """Return the arc lengths (m) from the ends, at these heights, at which each divider may press a leg (8,).

    Left and right leg alternate; infinite where the divider does not hold the leg, or is far from
    it.
    """
    shaft = scene.shaft
    half = 0.5 * scene.layout.spacing
    return tuple(
        where(_may_press(scene, divider, leg), height - divider.y, math.inf)
        for divider in (shaft.divider_1, shaft.divider_2, shaft.divider_3, shaft.divider_4)
        for leg, height in ((-half, left), (half, right))
    )


def _may_press(scene: Scene, divider: Divider, leg: Scalar) -> Scalar:
    gap = abs(leg * cos(divider.direction) - divider.offset) - 0.5 * divider.size
    near = logical_and(divider.size > 0, gap < REACH * scene.layout.spacing)
    return logical_and(scene.shaft.contact.stiffness > 0, near)


def pressed_length(scene: Scene) -> Scalar:
    """Return the longest element (m) of a rope with a leg that a divider may press; infinite without one."""
    pressed = logical_or(*(s < math.inf for s in divider_positions(scene, 0.0, 0.0)))
    return where(pressed, contact_error.length_for(scene, BLOW), math.inf)


class FittedMesh(NamedTuple):
    """Mesh parameters: equal elements, 0 for none, or else l (m), elements of IV, end_levels, grading_length."""

    equal: float
    coarse: float
    fine: float
    end_levels: float
    grading: float


def fit_elements(scene: Scene, loop_error: Scalar, decades: Scalar) -> FittedMesh:
    """Return the mesh for a ``loop_error`` (m) that is ``decades`` powers of ten below COVER_ERROR."""
    length = scene.rope.length
    lengths = fit_lengths(scene, loop_error, decades)
    longest = minimum(pressed_length(scene), shaken_length(scene, lengths.cover))
    # no part of the pattern may be cut off while the loop is MIN_END_DISTANCE or farther from an
    # end
    coarse = minimum(RATIO * lengths.fine_length, longest)
    coarse = minimum(
        coarse, 2 * MIN_END_DISTANCE * length / _inner_length(_fine_count(lengths, coarse))
    )
    fine = _fine_count(lengths, coarse)
    short = coarse * (0.5 * _inner_length(fine) - DUE) > MIN_END_DISTANCE * length
    equal_length = minimum(minimum(lengths.fine_length, EQUAL_ENDS * lengths.end), 0.5 * longest)
    equal = where(short, maximum(ceil(length / equal_length), 8.0), 0.0)
    end_levels = sum(
        (less(lengths.end * 2**k, coarse) for k in range(1, MAX_LEVELS)), less(lengths.end, coarse)
    )
    # no joined elements in I and VII beside a divider
    grading = where(pressed_length(scene) < math.inf, 0.0, lengths.grading)
    return FittedMesh(equal, coarse, fine, end_levels, grading)


def _fine_count(lengths: FittedLengths, coarse: Scalar) -> Scalar:
    """Return the elements of IV: for what they cover, and the distance to the next transformation."""
    return RATIO * ceil((2 * lengths.cover + 2 * DUE * coarse) / coarse)


def _inner_length(fine: Scalar) -> Scalar:
    """Return the length of segments II to VI in units of l; II and VI have two elements each, III and V none."""
    return fine / RATIO + 2.0
