"""Violent motion: a leg that goes slack, and its snatch."""

from typing import NamedTuple

import numpy as np

from evidence.claims import above, below
from evidence.ropes import AT_ZERO, at_rest, moving
from evidence.stability.entry import Entry, Finding
from evidence.tables import Array
from rope_model.parameters import Rope, Scene
from rope_model.solver_parameters import Mesh, Solver

# an end that is lowered faster than the rope can fall, and stopped

LENGTH = 30.0  # m
DROP = 1.5  # m
FALL = 0.35  # s
END = 1.0  # s
H = 0.005  # s


class Drop(NamedTuple):
    """Times (s), pull of the rope on the left conveyance (N), and what the energy balance does not explain (J)."""

    t: Array
    pull: Array
    unexplained: Array
    kinetic: Array  # J


def drop(solver: Solver) -> Drop:
    """The left conveyance goes down by DROP within FALL, with up to 7 g, and stands."""
    rope = at_rest(
        Scene(rope=Rope(length=LENGTH), mesh=Mesh(kind="eem", elements=60), solver=solver)
    )
    rows = []
    for k in range(1, round(END / H) + 1):
        if not rope.advance_to(k * H, moving(-DROP, k * H, FALL, y=1.0), AT_ZERO).valid:
            break
        balance = rope.state.energy_balance
        rows.append((k * H, rope.state.motion.reaction[0, 1], balance.residual, balance.kinetic))
    return Drop(*np.array(rows).T)


def measure_snatch() -> Finding:
    fixed = Solver(tolerance=1e6, rho_inf=1.0, step_max=0.005, step_min=0.005)
    counterexample = drop(fixed)
    ours, fine, uncontrolled = (drop(Solver(tolerance=tolerance)) for tolerance in (1.0, 0.1, 1e6))
    largest = ours.kinetic.max()
    return Finding(
        counterexample=(
            above(
                "rho_inf = 1, fixed step: unexplained energy over the largest kinetic energy",
                np.abs(counterexample.unexplained).max() / counterexample.kinetic.max(),
                0.02,
            ),
        ),
        ours=(
            below(
                "unexplained energy over the largest kinetic energy",
                np.abs(ours.unexplained).max() / largest,
                0.002,
            ),
            below("time not reached", END - float(ours.t[-1]), 1e-9, "s"),
            below(
                f"snatch of {1e-3 * fine.pull.max():.3g} kN against ten times the tolerance",
                abs(float(ours.pull.max() / fine.pull.max()) - 1),
                0.05,
            ),
            below(
                "unexplained energy with a tenth of the tolerance",
                np.abs(fine.unexplained).max() / largest,
                0.002,
            ),
            # of second order in the step, and control takes several times as many steps
            below(
                "the energy that the balance does not explain over that of steps of 5 ms",
                np.abs(ours.unexplained).max() / np.abs(uncontrolled.unexplained).max(),
                0.1,
            ),
        ),
    )


ENTRIES = (Entry("snatch-load", "A snatch load on fixed steps", measure_snatch),)
