"""A loop whose natural width is far beyond the distance of its ends: plain Newton against ours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from evidence.claims import above, below
from rope_model.parameters import Layout, Mesh, Rope
from rope_model.simulation.ends.ends import nominal_points
from rope_model.simulation.mesh.partition import partition
from rope_model.simulation.rope_kernels import RopeKernels
from rope_model.simulation.rope_system import POSITION, RopeSystem, arc_lengths, parameter_vector
from rope_model.simulation.stepping.statics import find_equilibrium, hanging_guess

from .chain import StaticBoundary, is_stable, plain_newton
from .entry import Array, Entry, Finding

GRAVITY = Layout().gravity
BENDING = (50.0, 100.0, 300.0, 1000.0, 3000.0)  # N m^2
SPACINGS = (0.1, 0.2, 0.3, 0.5, 0.7, 1.0)  # m


def hanging_loops() -> dict[tuple[float, float], tuple[RopeSystem, Array]]:
    """Rope and first guess by EI and spacing: 120 m on the default mesh, both ends at the same height."""
    rope, loops = Rope(), {}
    lengths = partition(Mesh(), rope.length, 0.5 * rope.length).lengths
    kernels = RopeKernels(lengths.size)
    for EI in BENDING:
        for spacing in SPACINGS:
            ends = nominal_points(spacing)
            values = np.zeros((lengths.size + 1, 7))
            values[[0, -1], POSITION] = ends
            boundary = StaticBoundary.without_supports(values)
            boundary.held[[0, -1]] = True
            boundary.held[[0, -1], 4] = False
            P = parameter_vector(replace(rope, EI=EI), GRAVITY)
            guess = hanging_guess(arc_lengths(lengths), *ends)
            loops[EI, spacing] = RopeSystem(kernels, lengths, P, boundary, guess), guess
    return loops


def measure_bulging() -> Finding:
    failed, unstable, unbalanced, widest = 0, 0, 0.0, 0.0
    loops = hanging_loops()
    for (EI, spacing), (system, guess) in loops.items():
        natural = 2.54307 * (EI / (system.P[0] * GRAVITY)) ** (1 / 3)
        newton, ours = plain_newton(system, guess), find_equilibrium(system, guess)
        widest = max(widest, spacing / natural)
        failed += not (newton.converged and np.max(np.abs(newton.q - ours.q)[:, POSITION]) < 1e-3)
        unstable += not is_stable(system, ours.q)
        unbalanced = max(unbalanced, float(np.max(np.abs(np.where(system.free, ours.reaction, 0.0)))))
    return Finding(
        # a method is of no use to a user who meets a failure in every tenth data set
        counterexample=(above(f"share of {len(loops)} data sets without the shape", failed / len(loops), 0.1),),
        ours=(
            below("shapes that are not stable", unstable, 1),
            # 60 m of rounding in the strain of elements of 0.25 m: Qa 60 eps / l = 6e-6 N, ten times that at most
            below("largest force left unbalanced", unbalanced, 1e-4, "N"),
            below("largest spacing, part of the natural width", widest, 0.5),
        ),
    )


ENTRIES = (Entry("bulging-loop", "A loop wider than its ends are apart", measure_bulging, slow=True),)
