"""Energy balance of the rope: energies, work and dissipation (J).

``energy_balance`` has the present energies, and by name the work and the losses since the start.
"""

from typing import Any


def energies(balance: Any) -> tuple[Any, Any, Any]:
    """Return kinetic energy, strain energy and gravity's from the entries of an element's balance (element.BALANCE)."""
    axial, coupling, torsion, bending, kinetic, spin, gravity = (balance[k] for k in range(7))
    return kinetic + spin, axial + coupling + torsion + bending, gravity


def with_energies(energy_balance: Any, balance: Any, contact: Any) -> Any:
    """Return the balance with the energies of a state, from its element balance and the energy of ``contact``."""
    kinetic, strain, gravity = energies(balance)
    return energy_balance._replace(kinetic=kinetic, strain=strain, gravity=gravity, contact=contact)


def after_step(
    energy_balance: Any, h: Any, before: Any, after: Any, losses: Any, wires: Any, air: Any
) -> Any:
    """Return the balance after a step ``h``.

    ``before`` and ``after`` are Powers at its ends, ``losses`` are rope_system.Losses (W); ``wires`` is the energy
    dissipated between them (J), ``air`` the power given to the air (W).
    """
    damping, nonconservative, contact, moved = losses
    half = 0.5 * h
    account = energy_balance
    return account._replace(
        work_ends=account.work_ends + (half * (before[0] + after[0]) + h * moved),
        dissipated_swivel=account.dissipated_swivel + half * (before[1] + after[1]),
        dissipated_material=account.dissipated_material + h * damping,
        dissipated_contact=account.dissipated_contact + h * contact,
        dissipated_wires=account.dissipated_wires + wires,
        given_to_air=account.given_to_air + h * air,
        nonconservative=account.nonconservative + h * nonconservative,
    )


def total(energy_balance: Any) -> Any:
    """Return kinetic, strain, potential and contact energy."""
    return (
        energy_balance.kinetic
        + energy_balance.strain
        + energy_balance.gravity
        + energy_balance.contact
    )


def residual(energy_balance: Any) -> Any:
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
