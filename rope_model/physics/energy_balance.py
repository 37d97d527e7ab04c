"""Energy balance of the rope: energies, work and dissipation (J)."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from rope_model.physics.element import ENERGIES
from rope_model.physics.elementary import Scalar, Vector


class EnergyBalance(NamedTuple):
    """Present energies, and work done since the start, J."""

    kinetic: float = 0.0
    strain: float = 0.0
    gravity: float = 0.0
    contact: float = 0.0  # stored in contact with bodies or of the rope with itself
    work_ends: float = 0.0  # work of the conveyances
    dissipated_material: float = 0.0
    dissipated_swivel: float = 0.0
    dissipated_contact: float = 0.0
    dissipated_wires: float = 0.0
    given_to_air: float = 0.0
    nonconservative: float = 0.0  # taken up by the part of the coupling with Qb != Qc
    transformations: float = 0.0  # sum of the energy changes by mesh changes
    start: float = 0.0  # total energy at the start

    @property
    def total(self) -> float:
        """Kinetic, strain, potential and contact energy."""
        return float(total(self))

    @property
    def residual(self) -> float:
        """Residual of the balance: energy that the integrator has dissipated (negative) or created."""
        return float(residual(self))


class Powers(NamedTuple):
    """Powers at one instant (W), integrated by the trapezoidal rule."""

    ends: float  # of the ends on the rope
    swivel: float  # dissipated in the swivels


class StepLosses(NamedTuple):
    """Losses in a step: mean powers (W), and the energy (J) dissipated between wires."""

    damping: float  # of the material
    nonconservative: float  # of the part of the coupling that has no energy
    contact: float
    moving_bodies: float  # power of moving bodies on the rope
    air: float  # power given to the air
    wires: float  # J


def energies(balance: Vector) -> tuple[Scalar, Scalar, Scalar]:
    """Return kinetic energy, strain energy and gravity's from the entries of an element's balance (element.BALANCE)."""
    axial, coupling, torsion, bending, kinetic, spin, gravity = (balance[k] for k in range(7))
    return kinetic + spin, axial + coupling + torsion + bending, gravity


def with_energies(
    energy_balance: EnergyBalance, balance: Annotated[Vector, len(ENERGIES)], contact: Scalar
) -> EnergyBalance:
    """Return the balance with the energies of a state, from its element balance and the energy of ``contact``."""
    kinetic, strain, gravity = energies(balance)
    present: EnergyBalance = energy_balance._replace(
        kinetic=kinetic, strain=strain, gravity=gravity, contact=contact
    )
    return present


def after_step(
    energy_balance: EnergyBalance, h: Scalar, before: Powers, after: Powers, losses: StepLosses
) -> EnergyBalance:
    """Return the balance after a step ``h`` with the powers ``before`` and ``after`` it."""
    half = 0.5 * h
    account = energy_balance
    changed: EnergyBalance = account._replace(
        work_ends=account.work_ends
        + (half * (before.ends + after.ends) + h * losses.moving_bodies),
        dissipated_swivel=account.dissipated_swivel + half * (before.swivel + after.swivel),
        dissipated_material=account.dissipated_material + h * losses.damping,
        dissipated_contact=account.dissipated_contact + h * losses.contact,
        dissipated_wires=account.dissipated_wires + losses.wires,
        given_to_air=account.given_to_air + h * losses.air,
        nonconservative=account.nonconservative + h * losses.nonconservative,
    )
    return changed


def total(energy_balance: EnergyBalance) -> Scalar:
    """Return kinetic, strain, potential and contact energy."""
    return (
        energy_balance.kinetic
        + energy_balance.strain
        + energy_balance.gravity
        + energy_balance.contact
    )


def residual(energy_balance: EnergyBalance) -> Scalar:
    """Return the energy that the integrator has dissipated (negative) or created."""
    x = energy_balance
    explained = (
        x.work_ends
        + x.transformations
        - x.dissipated_material
        - x.dissipated_swivel
        - x.dissipated_contact
    )
    explained = explained - x.dissipated_wires - x.given_to_air
    return total(x) - x.start - explained + x.nonconservative
