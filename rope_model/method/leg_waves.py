"""Errors by transverse waves that the legs' elements, or time steps, do not resolve.

The slope of a leg against the vertical is, across an element of length l,

    x' = m + c1 P1 + c2 P2      with Legendre polynomials, in X and in Z

A wave of the wave number k has |c2| = (k l)^2 / 12 |m| while it is resolved.  A slope takes length
off a leg, l (m^2 + c1^2 / 3 + c2^2 / 5) / 2 per element.  In a wave that travels, these lengths
change by turns and their sum hardly does.  A mesh that does not let the wave pass keeps it near its
end, where all change at once: at twice the wave's frequency they stretch the leg, which answers with
longitudinal waves.  That is the largest error of the end forces by far.  It is a response of the
leg to the rate of

    SHORT_WAVES times the lengths by c2            while elements resolve most of the wave
    all lengths                                    at most: an element that resolves nothing

The force across the leg errs by some T c2, and the loop's position by the amplitude with which the
wave reaches it where it is not resolved, (height / w)^(1/4) times that in the leg.  A frequency is
the ratio of c2's second rate to its rate.

Time steps let a wave that is resolved lag on its way.

``python -m evidence --measure shaking`` measures errors and estimates.
"""

import math
from typing import Annotated, NamedTuple

from rope_model.method.step_errors import ErrorSums, wave_duration
from rope_model.parameters import Rope, Scene
from rope_model.physics.elementary import (
    SMALLEST_DIVISOR,
    Scalar,
    Vector,
    cos,
    hypot,
    maximum,
    minimum,
    sin,
    sqrt,
    where,
)
from rope_model.physics.estimates import axial_frequency, bending_length

#: height (w) above the loop from which a leg is nearly straight: below, the loop's bend passes
#: through the elements as the rope flows
LEG_FROM = 4.0
# factors tuned on rope-120 and tried on seeded ropes of 60 to 1000 m
SHORT_WAVES = 3.0  #: error by the lengths of c2 over the response to them
#: squares of c2's rates over those of the slope from which on c2 is an error: less of it is resolved
RESOLVED = 0.11
ACROSS = 0.25  #: error of the force across a leg over T c2
#: squares of c2's rates over those of the slope at which nothing of a wave reaches the loop, (l k)^4 / 720
LOST = 1.0 / 6.0
OFF = 1.2  #: largest error of the loop's position over the amplitude with which a lost wave would reach it
LAGGING = 0.5  #: error of the end forces by waves that lag by phi, over phi^1.5 times the response to all lengths
UNIFORM = 4.0 / math.pi  #: share of a uniform strain in the slowest longitudinal wave of a leg

#: coordinates, or rates of them, at both ends of an element: r, r', theta twice
ElementRow = Annotated[Vector, 14]


class LegResponse(NamedTuple):
    """Answer of a leg to a rate of shortening.

    ``present``, ``later``: strain at the end by the slowest longitudinal wave, now and a quarter of
    its period later.  ``slow``, ``slower`` (m/s): parts of the rate that are slower than it.
    ``square`` (N^2 s): time integral of the squared end force.
    """

    present: float = 0.0
    later: float = 0.0
    slow: float = 0.0
    slower: float = 0.0
    square: float = 0.0


class LegWaves(NamedTuple):
    """Transverse waves of the legs since the start; integrals over the time.

    ``force_rate``, ``force_acceleration``: largest squared rates of T c2 among the elements.
    ``worst``, ``length``, ``height``: the largest ``force_rate`` so far, and the element that had
    it, its height above the loop.
    """

    left_all: LegResponse = LegResponse()
    right_all: LegResponse = LegResponse()
    left_short: LegResponse = LegResponse()
    right_short: LegResponse = LegResponse()
    slopes: float = 0.0  # m/s, of the slopes' squared rates along the legs
    bent: float = 0.0  # m/s, the part by c2
    force_rate: float = 0.0  # N^2/s
    force_acceleration: float = 0.0  # N^2/s^3
    speed: float = 0.0  # m^2/s, of the largest squared speed across, as at the loop
    acceleration: float = 0.0  # m^2/s^3, of the largest squared acceleration, likewise
    arrived: float = 0.0  # m^2/s, of the speed where a wave can have reached the loop
    lag: float = 0.0  # s^3, of the steps' error constant times h^2
    worst: float = 0.0  # N^2/s^2
    length: float = 0.0  # m
    height: float = 0.0  # m


class ElementWave(NamedTuple):
    """Transverse motion of an element of a leg."""

    shortening: float  # m/s, of all slopes
    of_c2: float  # m/s, of c2 alone
    slopes: float  # m/s^2, squared rates of the slopes along the element
    bent: float  # m/s^2, the part by c2
    force_rate: float  # N^2/s^2, squared rate of T c2
    force_acceleration: float  # N^2/s^4
    speed: float  # m^2/s^2, squared speed of its middle across, as it would be at the loop
    acceleration: float  # m^2/s^4, squared acceleration, likewise
    travel: float  # s, of a wave from here to the leg's lowest part


class LegsMotion(NamedTuple):
    """Sums over the elements of the legs, left and right, and largest values among them."""

    bottom_s: float  # m, arc length of the loop's lowest point
    shortening: tuple[float, float]
    of_c2: tuple[float, float]
    slopes: float
    bent: float
    force_rate: float
    force_acceleration: float
    speed: float
    acceleration: float
    arrived: float  # m^2/s^2, largest speed where a wave can have reached the loop
    length: float  # m, of the element with the largest force_rate
    height: float  # m, its height above the loop


def leg_begins(scene: Scene) -> Scalar:
    """Return the height (m) above the loop from which a leg is nearly straight."""
    return LEG_FROM * bending_length(scene)


def element_wave(
    scene: Scene,
    q: ElementRow,
    v: ElementRow,
    a: ElementRow,
    l: Scalar,
    height: Scalar,
    begins: Scalar,
) -> ElementWave:
    """Return the transverse motion of an element of length ``l`` (m) at a ``height`` (m) above the loop.

    ``begins`` (m) is leg_begins, which takes a cube root: once for all elements.
    """
    w = begins / LEG_FROM
    tension = scene.rope.mass_per_length * scene.layout.gravity * height
    shortening: Scalar = 0.0
    of_c2: Scalar = 0.0
    slopes: Scalar = 0.0
    bent: Scalar = 0.0
    bent_rates: Scalar = 0.0
    speed: Scalar = 0.0
    acceleration: Scalar = 0.0
    for axis in (0, 2):
        m, c1, c2 = _slopes(q, l, axis)
        m_t, c1_t, c2_t = _slopes(v, l, axis)
        c2_tt = _slopes(a, l, axis)[2]
        shortening = shortening + l * (m * m_t + c1 * c1_t / 3.0 + c2 * c2_t / 5.0)
        of_c2 = of_c2 + l * (c2 * c2_t / 5.0)
        slopes = slopes + l * (m_t * m_t + c1_t * c1_t / 3.0 + c2_t * c2_t / 5.0)
        bent = bent + c2_t * c2_t
        bent_rates = bent_rates + c2_tt * c2_tt
        across = 0.5 * (v[axis] + v[7 + axis])
        across_t = 0.5 * (a[axis] + a[7 + axis])
        speed = speed + across * across
        acceleration = acceleration + across_t * across_t
    return ElementWave(
        shortening=shortening,
        of_c2=of_c2,
        slopes=slopes,
        bent=l * bent / 5.0,
        force_rate=tension * tension * bent,
        force_acceleration=tension * tension * bent_rates,
        speed=sqrt(height / w) * speed,
        acceleration=sqrt(height / w) * acceleration,
        travel=2.0 * (sqrt(height) - sqrt(begins)) / sqrt(scene.layout.gravity),
    )


def _slopes(row: ElementRow, l: Scalar, axis: int) -> tuple[Scalar, Scalar, Scalar]:
    """Return m, c1 and c2 along an axis."""
    first = row[3 + axis]
    last = row[10 + axis]
    m = (row[7 + axis] - row[axis]) / l
    return m, 0.5 * (last - first), 0.5 * (first + last) - m


def add_leg_waves(
    scene: Scene, waves: LegWaves, legs: LegsMotion, h: Scalar, error_constant: Scalar
) -> LegWaves:
    """Return ``waves`` after a step ``h`` (s) at whose end the legs move so.

    ``error_constant`` h^2 is the local error per change of the acceleration.
    """
    rope = scene.rope
    left = legs.bottom_s
    right = rope.length - legs.bottom_s
    # a larger one than all before moves the place
    grows = legs.force_rate > waves.worst
    return LegWaves(
        left_all=_respond(rope, waves.left_all, left, legs.shortening[0], h),
        right_all=_respond(rope, waves.right_all, right, legs.shortening[1], h),
        left_short=_respond(rope, waves.left_short, left, legs.of_c2[0], h),
        right_short=_respond(rope, waves.right_short, right, legs.of_c2[1], h),
        slopes=waves.slopes + h * legs.slopes,
        bent=waves.bent + h * legs.bent,
        force_rate=waves.force_rate + h * legs.force_rate,
        force_acceleration=waves.force_acceleration + h * legs.force_acceleration,
        speed=waves.speed + h * legs.speed,
        acceleration=waves.acceleration + h * legs.acceleration,
        arrived=waves.arrived + h * legs.arrived,
        lag=waves.lag + error_constant * (h * h * h),
        worst=maximum(waves.worst, legs.force_rate),
        length=where(grows, legs.length, waves.length),
        height=where(grows, legs.height, waves.height),
    )


def _respond(
    rope: Rope, response: LegResponse, leg: Scalar, rate: Scalar, h: Scalar
) -> LegResponse:
    """Return the ``response`` of a ``leg`` (m) after a step with this ``rate`` of shortening (m/s).

    The slowest wave oscillates as in step_errors.  What is faster than it does not see the leg's
    other end, and meets sqrt(Qa rho).
    """
    omega = axial_frequency(rope, leg)
    duration = wave_duration(rope, omega)
    decay = duration / (duration + h)
    cosine = decay * cos(omega * h)
    sine = decay * sin(omega * h)
    present = cosine * response.present + sine * response.later + UNIFORM * h * rate / leg
    later = cosine * response.later - sine * response.present
    share = omega * h / (1.0 + omega * h)
    slow = response.slow + share * (rate - response.slow)
    fast = rate - slow
    slower = response.slower + share * (fast - response.slower)
    fastest = sqrt(rope.Qa * rope.mass_per_length) * (fast - slower)
    force = rope.Qa * present
    square = response.square + h * (force * force + fastest * fastest)
    return LegResponse(present, later, slow, slower, square)


def frequency(scene: Scene, waves: LegWaves) -> Scalar:
    """Return the frequency (Hz) of the waves, at least about that in which the whole rope sways."""
    ratio = waves.force_acceleration / maximum(waves.force_rate, SMALLEST_DIVISOR)
    return sqrt(maximum(ratio, scene.layout.gravity / scene.rope.length)) / (2.0 * math.pi)


def leg_force_error(scene: Scene, waves: LegWaves, sums: ErrorSums) -> Scalar:
    """Return the error of the end forces by unresolved waves, root mean square over the largest force."""
    time = maximum(sums.time, SMALLEST_DIVISOR)
    share = minimum(short_share(waves) / RESOLVED, 1.0)
    weight = SHORT_WAVES * (share * sqrt(share))
    along = maximum(
        _along(waves.left_all, waves.left_short, weight),
        _along(waves.right_all, waves.right_short, weight),
    )
    across = ACROSS * sqrt(waves.force_rate) / (2.0 * math.pi * frequency(scene, waves))
    return hypot(along, across) / sqrt(time) / maximum(sums.force, SMALLEST_DIVISOR)


def short_share(waves: LegWaves) -> Scalar:
    """Return the squares of c2's rates over those of the slope."""
    return waves.bent / maximum(waves.slopes, SMALLEST_DIVISOR)


def _along(whole: LegResponse, short: LegResponse, weight: Scalar) -> Scalar:
    return minimum(weight * sqrt(short.square), sqrt(whole.square))


def add_leg_force_error(scene: Scene, error: Scalar, waves: LegWaves, sums: ErrorSums) -> Scalar:
    """Add the error by transverse waves to the ``error`` of the end forces over the largest."""
    unresolved = leg_force_error(scene, waves, sums)
    lagging = lag_force_error(scene, waves, sums)
    return sqrt(error * error + unresolved * unresolved + lagging * lagging)


def leg_loop_error(scene: Scene, waves: LegWaves, time: Scalar) -> Scalar:
    """Return the largest error (m) of the loop's position by waves that elements do not resolve."""
    lost = minimum(short_share(waves) / LOST, 1.0)
    omega = 2.0 * math.pi * frequency(scene, waves)
    return OFF * (lost * lost) * _amplitude(waves, time, omega)


def _amplitude(waves: LegWaves, time: Scalar, omega: Scalar) -> Scalar:
    """Return the amplitude (m) of waves of the frequency ``omega`` (rad/s) at the loop."""
    return sqrt(2.0 * waves.arrived / maximum(time, SMALLEST_DIVISOR)) / omega


def lag_phase(scene: Scene, waves: LegWaves, time: Scalar) -> Scalar:
    """Return the angle (rad) by which time steps let the legs' waves lag on their way down, at most 1.

    Each step lets a wave lag by error_constant (omega h)^3.
    """
    mean = waves.lag / maximum(time, SMALLEST_DIVISOR)
    return minimum(mean * lag_rate(scene, _swaying(scene, waves)), 1.0)


def lag_rate(scene: Scene, omega: Scalar) -> Scalar:
    """Return the lag (rad) down half of the rope of waves of ``omega`` (rad/s), over error_constant h^2 (s^2)."""
    travel = 2.0 * sqrt(0.5 * scene.rope.length / scene.layout.gravity)
    return (omega * omega * omega) * travel


def lag_force_error(scene: Scene, waves: LegWaves, sums: ErrorSums) -> Scalar:
    """Return the error of the end forces by waves that lag, root mean square over the largest force."""
    phase = lag_phase(scene, waves, sums.time)
    response = sqrt(
        maximum(waves.left_all.square, waves.right_all.square)
        / maximum(sums.time, SMALLEST_DIVISOR)
    )
    return LAGGING * (phase * sqrt(phase)) * response / maximum(sums.force, SMALLEST_DIVISOR)


def lag_loop_error(scene: Scene, waves: LegWaves, time: Scalar) -> Scalar:
    """Return the largest error (m) of the loop's position by waves that lag."""
    amplitude = _amplitude(waves, time, _swaying(scene, waves))
    return OFF * lag_phase(scene, waves, time) * amplitude


def _swaying(scene: Scene, waves: LegWaves) -> Scalar:
    """Return the frequency (rad/s) of all transverse motion: lower than ``frequency`` where legs sway."""
    ratio = waves.acceleration / maximum(waves.speed, SMALLEST_DIVISOR)
    return sqrt(maximum(ratio, scene.layout.gravity / scene.rope.length))


def add_leg_loop_error(scene: Scene, error: Scalar, waves: LegWaves, time: Scalar) -> Scalar:
    """Add the error by transverse waves to the ``error`` (m) of the loop's position."""
    unresolved = leg_loop_error(scene, waves, time)
    lagging = lag_loop_error(scene, waves, time)
    return sqrt(error * error + unresolved * unresolved + lagging * lagging)
