"""Errors of a run by its time steps: of the end forces and of the loop's position.

The errors of the steps disturb the end forces as in ``step_control``; they add up as long as the
slowest wave of each leg lasts.

The loop's position has the position errors of the nodes in a step: it moves on, and forgets them.
Where the rope flows through it with speed v, each node turns by x = v h / w in a step, w the length
of a bend.  The relative error of the acceleration in the bend grows with x^2.  Like rho v^2 it acts
as a false tension, which shifts the loop by some x^2 v^2 / g against its weight.
"""

from typing import NamedTuple

from rope_model.method.mesh_error import mesh_error
from rope_model.parameters import Rope, Scene
from rope_model.physics.elementary import SMALLEST_DIVISOR, Scalar, cos, maximum, sin, sqrt
from rope_model.physics.estimates import axial_frequency, bending_length

#: total phase error of a wave over that by the strain alone: its rate is not measured
RATE_ERROR_FACTOR = 2.0
# errors of the loop's position
STEP_ERROR_TO_LOOP = 12.0  #: part by time steps, over the largest position error of a node
FLOW_ERROR = 0.13  #: part by the flow, over x^2 v^2 / g
# bounds of a wave's duration with little material damping
MAX_WAVE = 60.0  #: s, a trip
MAX_PHASE = 400.0  #: rad, as of the longest ropes with damping


class ErrorSums(NamedTuple):
    """Errors of the steps since the start.

    ``waves``: strain error at the end by the slowest wave of each leg, now and a quarter of a
    period later, left and right.  ``strain_tt``: mean accelerations of these strains in the latest
    step.
    """

    time: float = 0.0  # s
    position: float = 0.0  # m, largest position error of a step
    flow: float = 0.0  # m, largest error of the loop's position by the flow through it
    force: float = 0.0  # N, largest end force
    waves: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    squares: tuple[float, float] = (0.0, 0.0)  # s, time integrals of the squared strain errors
    strain_tt: tuple[float, float] = (0.0, 0.0)  # 1/s^2


class MeasuredStep(NamedTuple):
    """Accepted step, as the error sums see it.

    ``strain_tt`` are means over the step, from the strain rates at its ends: the accelerations at
    its end contain what stiff waves leave there.
    """

    h: float  # s
    bottom_s: float  # m, arc length of the loop's lowest point
    end_speed: float  # m/s, vertical speed of one end against the other
    strain_tt: tuple[float, float]  # 1/s^2, mean accelerations of the end strains
    position: float  # m, local error of the positions
    force: float  # N, largest end force


def wave_duration(rope: Rope, omega: Scalar) -> Scalar:
    """Return the duration (s) of a wave of frequency ``omega`` (rad/s)."""
    return 2.0 / maximum(
        rope.beta_K * (omega * omega), 2.0 * maximum(omega / MAX_PHASE, 1.0 / MAX_WAVE)
    )


def flow_error(scene: Scene, end_speed: Scalar, h: Scalar) -> Scalar:
    """Return the loop's position error (m) by steps ``h`` as the rope flows at half of ``end_speed`` (m/s)."""
    flow = 0.5 * end_speed
    angle = flow * h / bending_length(scene)
    return FLOW_ERROR * (angle * angle) * (flow * flow) / scene.layout.gravity


def add_errors(
    scene: Scene, sums: ErrorSums, step: MeasuredStep, error_constant: Scalar
) -> ErrorSums:
    """Return ``sums`` after a step.

    The local error is ``error_constant`` h^2 per change of the strains' mean accelerations, but for
    a stiff wave, which follows the forces, at most the change over omega^2.
    """
    rope = scene.rope
    h = step.h
    waves = []
    squares = []
    for side, leg in enumerate((step.bottom_s, rope.length - step.bottom_s)):
        omega = axial_frequency(rope, leg)
        duration = wave_duration(rope, omega)
        decay = duration / (duration + h)
        phase = omega * h
        cosine = decay * cos(phase)
        sine = decay * sin(phase)
        present = sums.waves[2 * side]
        later = sums.waves[2 * side + 1]
        local = (
            error_constant
            * (h * h)
            / (1.0 + error_constant * (phase * phase))
            * (step.strain_tt[side] - sums.strain_tt[side])
        )
        waves += [cosine * present + sine * later + local, cosine * later - sine * present]
        squares.append(sums.squares[side] + h * (waves[-2] * waves[-2]))
    return ErrorSums(
        time=sums.time + h,
        position=maximum(sums.position, step.position),
        flow=maximum(sums.flow, flow_error(scene, step.end_speed, h)),
        force=maximum(sums.force, step.force),
        waves=(waves[0], waves[1], waves[2], waves[3]),
        squares=(squares[0], squares[1]),
        strain_tt=step.strain_tt,
    )


def end_force_error(rope: Rope, sums: ErrorSums) -> Scalar:
    """Return the error of the end forces, root mean square since the start, relative to the largest force."""
    squares = maximum(sums.squares[0], sums.squares[1])
    return (
        RATE_ERROR_FACTOR
        * rope.Qa
        * sqrt(squares / maximum(sums.time, SMALLEST_DIVISOR))
        / maximum(sums.force, SMALLEST_DIVISOR)
    )


def loop_error(
    scene: Scene, sums: ErrorSums, l: Scalar, grading_length: Scalar, transformations: Scalar
) -> Scalar:
    """Return the largest error (m) of the loop's position since the start, by elements, legs and steps."""
    mesh = mesh_error(scene, l, grading_length, transformations)
    steps = STEP_ERROR_TO_LOOP * sums.position
    # the three occur at different instants
    return sqrt(mesh * mesh + steps * steps + sums.flow * sums.flow)
