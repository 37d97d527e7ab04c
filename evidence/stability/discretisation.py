"""Elements and meshes that break: locking, hourglassing, long steps on long elements, a loop that leaves its mesh."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import casadi as ca
import numpy as np

from benchmarks.kinematic import fixed_steps
from benchmarks.robustness import Reversal
from evidence.claims import Measurement
from rope_model.parameters import Mesh, Rope, Scene, Solver

from .counterexamples import modified_element
from .entry import Array, Curve, Entry, Figure, Finding
from .trips import Record, follow, hang, trip, without_transformations

# membrane locking

UNCOUPLED = Rope(length=48.0, Qb=0.0, Qc=0.0)
LENGTHS = (2.0, 1.0, 0.5, 0.25)  # m


def side_force(mesh: Mesh) -> float:
    """N, horizontal force of the hanging loop on its left end."""
    rope = hang(Scene(rope=UNCOUPLED, mesh=mesh, solver=Solver(kernels="portable")))
    return float(rope.state.motion.reaction[0, 0])


def equal(length: float) -> Mesh:
    return Mesh(kind="eem", elements=round(UNCOUPLED.length / length))


def shear_locking() -> Finding:
    """Side force over the element's length, with eight Gauss points and with three."""
    exact = side_force(equal(0.125))
    with modified_element(gauss_points=8):
        full = np.array([100 * abs(side_force(equal(l)) / exact - 1) for l in LENGTHS])
    three = np.array([100 * abs(side_force(equal(l)) / exact - 1) for l in LENGTHS])
    graded = Mesh()
    tmn = 100 * abs(side_force(graded) / exact - 1)
    x = np.array(LENGTHS)
    return Finding(
        counterexample=(
            # the hanging loop is 3.2 m wide: with 2 m elements two of them make the bend
            Measurement("side force, error, 8 Gauss points, elements of 2 m", full[0], "%", ">", 50.0),
            Measurement("side force, error, 8 Gauss points, elements of 1 m", full[1], "%", ">", 4.0),
            Measurement("side force, error, 3 Gauss points, elements of 2 m", three[0], "%", ">", 4.0),
        ),
        ours=(
            # 0.3 % is the theory's number for 0.5 m; the error falls with the length's square or faster
            Measurement("side force, error, TMN-ETM with l = 2 m, l/8 in the loop", tmn, "%", "<", 0.3),
            Measurement("side force, error, 3 Gauss points, equal elements of 0.25 m", three[3], "%", "<", 0.3),
        ),
        figure=Figure(
            "Side force of a hanging loop: elements that are too long make it too stiff",
            "element length / m",
            "error of the side force / %",
            (
                Curve("8 Gauss points (full integration), equal elements", x, full, "s-"),
                Curve("3 Gauss points, equal elements", x, three, "o-"),
                Curve(
                    "ours: TMN-ETM, l = 2 m, drawn at l/8", np.array([graded.coarse_length / 8]), np.array([tmn]), "*"
                ),
            ),
            log_x=True,
            log_y=True,
        ),
    )


# hourglass


def axial_eigenvalues(points: int) -> Array:
    """Of one straight element's axial stiffness in u1, l u1', u2, l u2', in units of Qa/l, ascending."""
    u, energy = ca.SX.sym("u", 4), ca.SX(0)
    for x, weight in zip(*np.polynomial.legendre.leggauss(points), strict=True):
        xi = 0.5 * (1 + x)
        strain = ca.dot(ca.DM([6 * xi**2 - 6 * xi, 1 - 4 * xi + 3 * xi**2, 6 * xi - 6 * xi**2, 3 * xi**2 - 2 * xi]), u)
        energy += 0.5 * weight * strain**2 / 2
    K = ca.Function("K", [u], [ca.hessian(energy, u)[0]])
    return np.asarray(np.linalg.eigvalsh(np.asarray(K(np.zeros(4)))), dtype=float)


def hourglass() -> Finding:
    """Zero-energy modes of an element, and a start of winding."""
    two, three = axial_eigenvalues(2), axial_eigenvalues(3)
    scene = Scene(rope=Rope(length=30.0), mesh=Mesh(kind="eem", elements=120))
    reference = trip(10.0, 4.0, 1.5, 3.0)
    with modified_element(gauss_points=2):
        counterexample = follow(hang(scene, 0.0, 10.0), reference, 10.0)
    ours = follow(hang(scene, 0.0, 10.0), reference, 10.0)
    # in the bend the cubic's |r'| ripples by a few times the strain of the weight; ten times is another thing
    strain = scene.rope.mass_per_length * scene.layout.gravity * scene.rope.length / scene.rope.Qa
    return Finding(
        counterexample=(
            # a stiff mode has an eigenvalue of order 1
            Measurement("stiffness of the hourglass mode, 2 points, of Qa/l", abs(two[1]), "1", "<", 1e-12),
            Measurement(
                "largest stretch of a node over the strain of the weight, 2 points",
                float(counterexample.stretch.max()) / strain,
                "1",
                ">",
                10.0,
            ),
        ),
        ours=(
            # int (6 xi^2 - 6 xi + 1)^2 = 1/5, on a mode whose norm is of order 1
            Measurement("stiffness of the hourglass mode, 3 points, of Qa/l", three[1], "1", ">", 0.01),
            Measurement(
                "largest stretch of a node over the strain of the weight, 3 points",
                float(ours.stretch.max()) / strain,
                "1",
                "<",
                10.0,
            ),
            Measurement("part of the trip completed, 3 points", ours.completion, "1", ">", 0.999),
        ),
        figure=Figure(
            "Stretch of the nodes at the start of a winding: two Gauss points let it grow freely",
            "t / s",
            "largest | |r'| - 1 | of a node",
            tuple(
                Curve(label, run.t[run.t < 1.0], run.stretch[run.t < 1.0], style)
                for label, run, style in (("2 Gauss points", counterexample, "o-"), ("ours: 3 Gauss points", ours, "-"))
            ),
            log_y=True,
        ),
    )


# long steps on long elements


def long_steps() -> Finding:
    """8 m/s on elements of 2 m with communication steps of 20 ms, which are the longest steps too."""
    reference, h = trip(40.0, 8.0, 2.0, 4.0), 0.02
    scene = Scene(rope=Rope(length=60.0), mesh=Mesh(kind="eem", elements=30), solver=fixed_steps(h))
    constant = Solver(step_max=h, step_min=h, tolerance=1e6)
    counterexample, ours = (
        follow(hang(s, 0.0, 40.0), reference, 40.0, h) for s in (scene.with_(solver=constant), scene)
    )
    counts = ours.rope.state.counts
    return Finding(
        counterexample=(
            Measurement(
                "part of the trip completed, constant steps of 20 ms", counterexample.completion, "1", "<", 0.99
            ),
        ),
        ours=(
            Measurement("part of the trip completed, with step control", ours.completion, "1", ">", 0.999),
            # that it was the control that helped
            Measurement("steps rejected, halved and tried again", counts.rejections, "1", ">", 0.5),
        ),
        figure=Figure(
            "Force of the right end at 8 m/s on 2 m elements",
            "t / s",
            "vertical force on the right end / N",
            (
                Curve("ours: steps rejected and halved", ours.t, ours.force[:, 1]),
                Curve("constant steps of 20 ms", counterexample.t, counterexample.force[:, 1], "--"),
            ),
        ),
        message=f"With constant steps: {counterexample.status.message}",
    )


# the loop and its fine mesh


@dataclass(frozen=True)
class Trip:
    """A trip of the rope of ``length`` by ``travel`` (m), and what is followed; ``step`` (s) is the longest."""

    title: str
    length: float
    travel: float
    reference: Any
    step: float
    bound: float  # mm, for the loop's place


TRIPS = {
    # short steps for all meshes: at this speed 10 ms err by more than the mesh does
    "fast": Trip("16 m/s", 100.0, 74.0, trip(74.0, 16.0, 4.0, 8.0), 0.0025, 10.0),
    "reversal": Trip("reversal in mid-shaft", 80.0, 55.0, Reversal(trip(27.5, 16.0, 4.0, 8.0), 27.5), 0.0025, 10.0),
}


FINE = 0.125  # m, of the reference: longer elements do not resolve the clamped ends, which leans the legs


def errors(run: Record, exact: Record) -> tuple[Array, Array]:
    """Distance of the loops' lowest points (m), and difference of the end forces over the largest (1)."""
    n = min(run.t.size, exact.t.size)
    distance = np.linalg.norm(run.bottom[:n] - exact.bottom[:n], axis=1)
    force = np.abs(run.force[:n] - exact.force[:n]).max(axis=1) / np.abs(exact.force).max()
    return distance, force


def travel_errors(kind: str) -> Finding:
    """The loop's place and the end forces on our mesh, on one that stays, and on equal elements."""
    x = TRIPS[kind]
    mesh = Mesh("auto", loop_error=1e-3)
    scene = Scene(rope=Rope(length=x.length), mesh=mesh, solver=fixed_steps(x.step))
    fine = scene.with_(mesh=Mesh(kind="eem", elements=round(x.length / FINE)))
    ours, counterexample, exact = (
        follow(rope, x.reference, x.travel)
        for rope in (
            hang(scene, 0.0, x.travel),
            without_transformations(hang(scene, 0.0, x.travel)),
            hang(fine, 0.0, x.travel),
        )
    )
    usual = follow(hang(Scene(rope=scene.rope), 0.0, x.travel), x.reference, x.travel)
    (distance, force), (counterexample_distance, counterexample_force) = (
        errors(ours, exact),
        errors(counterexample, exact),
    )
    count = ours.rope.state.counts.transformations
    return Finding(
        counterexample=(
            Measurement(
                "loop bottom, largest error, fixed mesh", 1e3 * float(counterexample_distance.max()), "mm", ">", 100.0
            ),
            Measurement("end force, rms error, fixed mesh", 100 * rms(counterexample_force), "%", ">", 5.0),
        ),
        ours=(
            # the acceptance of the method is 1 cm for the loop's place and 0.5 % (rms) for the forces
            Measurement("loop bottom, largest error", 1e3 * float(distance.max()), "mm", "<", x.bound),
            Measurement("part of the trip completed", ours.completion, "1", ">", 0.999),
            # the loop travels half the way along the rope, by l each time
            Measurement("transformations", count, "1", ">", 20.0),
            Measurement("end force, rms error", 100 * rms(force), "%", "<", 0.5),
            # the same limit that the counterexample exceeds
            Measurement(
                "loop bottom, largest error with the default mesh and steps",
                1e3 * float(errors(usual, exact)[0].max()),
                "mm",
                "<",
                100.0,
            ),
        ),
        figure=Figure(
            f"Error of the loop's lowest point against equal elements of {FINE:g} m: {x.title}",
            "t / s",
            "error of the loop's place / m",
            (
                Curve(
                    "mesh that stays where the loop began",
                    counterexample.t[: counterexample_distance.size],
                    counterexample_distance,
                ),
                Curve("ours: TMN-ETM", ours.t[: distance.size], distance),
            ),
            log_y=True,
        ),
    )


def rms(x: Array) -> float:
    return float(np.sqrt(np.mean(x**2)))


def near_end() -> Finding:
    """The loop driven to an end of the rope, where the pattern has no room."""
    scene, travel = Scene(rope=Rope(length=40.0), mesh=Mesh()), -10.0
    reference = trip(12.0, 3.0, 1.5, 3.0)
    rope = hang(scene, 0.0, travel)
    ours = follow(rope, reference, travel)
    cut_off = 1.0 - min(rope.state.partition.counts[::6])
    silent = follow(without_transformations(hang(scene, 0.0, travel)), reference, travel)
    fine = follow(hang(scene.with_(mesh=Mesh(kind="eem", elements=160)), 0.0, travel), reference, travel)
    distance, counterexample_distance = errors(ours, fine)[0], errors(silent, fine)[0]
    return Finding(
        counterexample=(
            # 1 cm, the acceptance of the method, is not kept
            Measurement("loop bottom, largest error", 1e3 * counterexample_distance.max(), "mm", ">", 10.0),
        ),
        ours=(
            Measurement("part of the trip completed", ours.completion, "1", ">", 0.999),
            Measurement("loop bottom, largest error", 1e3 * distance.max(), "mm", "<", 10.0),
            Measurement("of the pattern beyond the rope's end, in l", cut_off, "1", ">", 0.5),
        ),
        figure=Figure(
            "Loop driven towards the rope's end: error of its lowest point against 160 equal elements",
            "t / s",
            "error of the loop's place / m",
            (
                Curve("ours", ours.t, distance),
                Curve("mesh that stays where the loop began", silent.t, counterexample_distance),
            ),
            log_y=True,
        ),
    )


ENTRIES = (
    Entry("locking", "Membrane locking", shear_locking, slow=True),
    Entry("hourglass", "Two Gauss points: hourglass mode", hourglass, slow=True),
    Entry("long-steps", "Long constant steps at speed on a coarse mesh", long_steps, slow=True),
    Entry("fast", "TMN-ETM at 16 m/s", partial(travel_errors, "fast"), slow=True),
    Entry("reversal", "TMN-ETM on a reversal in mid-shaft", partial(travel_errors, "reversal"), slow=True),
    Entry("near-end", "Loop near one end of the rope", near_end, slow=True),
)
