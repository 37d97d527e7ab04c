"""Balance of energy.

    change of (U + K + V) = W_ends - W_k - D_material - D_swivels + E_mesh + residual

(docs/theory/time.md, eq-balance).  W_k is the work of the coupling's part Qk without an energy,
E_mesh the change by transformations. Numerical damping makes the residual negative.
"""

from dataclasses import dataclass, replace

from rope_model.boundary.end_conditions import YAW_SENSE
from rope_model.method.generalized_alpha import Motion
from rope_model.method.swivel_phases import Phase
from rope_model.physics.energy_balance import Powers
from rope_model.physics.node import END_NODE, POSITION
from rope_model.reference.ends import YAW
from rope_model.reference.equations import Equations
from rope_model.reference.swivel import Ends


@dataclass(frozen=True)
class Energies:
    """Present energies, and work since the start, J."""

    kinetic: float = 0.0
    strain: float = 0.0
    gravity: float = 0.0  #: zero at height zero
    work_ends: float = 0.0  #: of the conveyances on the rope
    dissipated_material: float = 0.0
    dissipated_swivel: float = 0.0
    nonconservative: float = 0.0  #: taken up by the part of the coupling with Qb != Qc
    transformations: float = 0.0
    start: float = 0.0  #: total at the start

    @property
    def total(self) -> float:
        """Kinetic, strain and potential energy."""
        return self.kinetic + self.strain + self.gravity

    @property
    def residual(self) -> float:
        """Energy that the integrator has dissipated (negative) or created."""
        lost = self.dissipated_material + self.dissipated_swivel + self.nonconservative
        return self.total - self.start - self.work_ends - self.transformations + lost


def with_energies(energies: Energies, equations: Equations, motion: Motion) -> Energies:
    """Return the balance with the energies of the ``motion``."""
    parts = equations.balance(motion.q, motion.v)
    return replace(
        energies,
        kinetic=parts["kinetic"] + parts["spin"],
        strain=parts["axial"] + parts["coupling"] + parts["torsion"] + parts["bending"],
        gravity=parts["gravity"],
    )


def after_step(
    energies: Energies, equations: Equations, ends: Ends, old: Motion, new: Motion
) -> Energies:
    """Return the balance after a step: powers at the ends by the trapezoidal rule.

    Material dissipation is that of the change of strains over the step: the rates at its ends
    contain numerical oscillations.
    """
    h = new.t - old.t
    before = powers(ends, old)
    after = powers(ends, new)
    middle = equations.balance(0.5 * (old.q + new.q), (new.q - old.q) / h)
    return replace(
        with_energies(energies, equations, new),
        work_ends=energies.work_ends + 0.5 * h * (before.ends + after.ends),
        dissipated_swivel=energies.dissipated_swivel + 0.5 * h * (before.swivel + after.swivel),
        dissipated_material=energies.dissipated_material + h * middle["damping_power"],
        nonconservative=energies.nonconservative + h * middle["nonconservative_power"],
    )


def powers(ends: Ends, motion: Motion) -> Powers:
    """Return the powers at this instant."""
    at_ends = 0.0
    at_swivels = 0.0
    for side, node in enumerate(END_NODE):
        force = motion.reaction[node, POSITION]
        moment = ends.moment(side, motion)
        yaw_rate = YAW_SENSE[side] * ends.paths[side].at(motion.t)[1, YAW]
        at_ends += float(force @ motion.v[node, POSITION]) + moment * yaw_rate
        if ends.swivels[side].phase is Phase.SLIP:
            at_swivels -= moment * ends.relative(side, motion)[1]
    return Powers(at_ends, at_swivels)
