"""A twisted rod under tension throws a loop: what plain Newton and a model without geometric torsion miss."""

from __future__ import annotations

import math
from dataclasses import replace
from unittest.mock import patch

import numpy as np

from evidence.claims import above, below
from rope_model.physics.element import PARAMETERS, element_functions
from rope_model.simulation.outputs import modal
from rope_model.simulation.rope_kernels import RopeKernels
from rope_model.simulation.rope_system import ANGLE, RopeSystem, arc_lengths

from .chain import Solve, StaticBoundary, by_continuation, by_newton, is_stable
from .counterexamples import no_rate
from .entry import Array, Entry, Finding

BEND, TWIST_STIFFNESS, AXIAL, TENSION, ROD = 1.0, 0.7, 1e3, 1.0, 60.0  # N m^2, N m^2, N, N, m


def straight_rod(elements: int = 80, length: float = ROD) -> tuple[RopeSystem, Array]:
    """Clamped at both ends, under TENSION, without weight; ``length`` in m."""
    values = {"rho": 1.0, "Qa": AXIAL, "Qd": TWIST_STIFFNESS, "EI": BEND, "rhoJ": 0.1}
    P = np.array([values.get(name, 0.0) for name in PARAMETERS])
    s = np.linspace(0.0, length, elements + 1)
    q = np.zeros((s.size, 7))
    q[:, 0], q[:, 3] = s * (1 + TENSION / AXIAL), 1 + TENSION / AXIAL
    boundary = StaticBoundary.without_supports(q)
    boundary.held[[0, -1]] = True
    boundary.held[[0, -1], 3] = False
    return RopeSystem(RopeKernels(elements), np.diff(s), P, boundary, q), q


def with_torque(system: RopeSystem, q: Array, torque: float) -> tuple[RopeSystem, Array]:
    """The straight rod with its far end turned until it carries ``torque`` (N m)."""
    q = q.copy()
    q[:, ANGLE] = torque / TWIST_STIFFNESS * arc_lengths(system.lengths)
    boundary = replace(system.boundary, values=q) if isinstance(system.boundary, StaticBoundary) else system.boundary
    return RopeSystem(system.kernels, system.lengths, system.P, boundary, q), q


def onset(system: RopeSystem, q: Array, low: float, high: float, tolerance: float = 1e-3) -> float:
    """Torque (N m) from which the straight rod is unstable, to ``tolerance``; ``high`` when it never is."""
    if is_stable(*with_torque(system, q, high)):
        return high
    while high - low > tolerance:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_stable(*with_torque(system, q, middle)) else (low, middle)
    return 0.5 * (low + high)


def deflection(solve: Solve, torque: float, disturbance: float) -> float:
    """Largest distance (m) from the axis of the rod that ``solve`` finds from a slightly helical one."""
    system, q = with_torque(*straight_rod(), torque)
    x = q[:, 0] / q[-1, 0]
    q[:, 1] = disturbance * np.sin(np.pi * x) * np.cos(2 * np.pi * 10 * x)
    q[:, 2] = disturbance * np.sin(np.pi * x) * np.sin(2 * np.pi * 10 * x)
    found = solve(system, q)
    return math.inf if found is None else float(np.max(np.hypot(found[:, 1], found[:, 2])))


def measure_hockling() -> Finding:
    theory = 2 * math.sqrt(BEND * TENSION)
    ours = onset(*straight_rod(), 0.5 * theory, 2.5 * theory)
    with patch.object(modal, "element_functions", lambda *_: element_functions(frame_rate=no_rate)):
        without = onset(*straight_rod(), 0.5 * theory, 10 * theory)
    torques = theory * np.array([0.8, 0.9, 0.95, 1.05, 1.1, 1.2])
    newton = np.array([deflection(by_newton, M, 1e-3) for M in torques])
    found = np.array([deflection(by_continuation, M, 1e-3) for M in torques])
    return Finding(
        counterexample=(
            above(
                "tau = theta' alone: torque up to which nothing happens, part of 2 sqrt(EI T)", without / theory, 5.0
            ),
            below("plain Newton, 1.2 times the critical torque: largest deflection", newton[-1], 1e-6, "m"),
        ),
        ours=(
            # a finite length adds about (2 pi/L)^2/2: 0.5 %
            below("onset against 2 sqrt(EI T)", abs(ours / theory - 1), 0.01),
            below("deflection at 0.95 times the critical torque", found[2], 1e-6, "m"),
            # the clamps hold the ends apart, so that only the stretch T/Qa feeds the helix: ten times the disturbance
            above("deflection at 1.1 times the critical torque", found[4], 0.01, "m"),
        ),
    )


ENTRIES = (Entry("hockling", "A twisted rod under tension hockles at M = 2 sqrt(EI T)", measure_hockling),)
