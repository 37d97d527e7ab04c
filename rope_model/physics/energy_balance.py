"""Energies of the rope, and how they account for the work done on it, J.

``energy_balance`` has the energies now, and by name what went in and out since the start.
"""

from __future__ import annotations

from typing import Any


def energies(balance: Any) -> tuple[Any, Any, Any]:
    """Kinetic, strain and gravity's energy from the entries of an element's balance (element.BALANCE)."""
    axial, coupling, torsion, bending, kinetic, spin, gravity = (balance[k] for k in range(7))
    return kinetic + spin, axial + coupling + torsion + bending, gravity


def total(energy_balance: Any) -> Any:
    """Kinetic, strain and potential energy, and what contact stores."""
    return energy_balance.kinetic + energy_balance.strain + energy_balance.gravity + energy_balance.contact


def residual(energy_balance: Any) -> Any:
    """What the rest does not account for: what the integrator dissipated (negative) or put in."""
    explained = (
        energy_balance.work_ends
        + energy_balance.transformations
        - energy_balance.dissipated_material
        - energy_balance.dissipated_swivel
        - energy_balance.dissipated_contact
        - energy_balance.dissipated_wires
        - energy_balance.given_to_air
    )
    return total(energy_balance) - energy_balance.start - explained + energy_balance.nonconservative
