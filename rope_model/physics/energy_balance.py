"""Energies of the rope, and how they account for the work done on it, J.

``ledger`` has the energies now, and by name what went in and out since the start.
"""

from __future__ import annotations

from typing import Any


def energies(balance: Any) -> tuple[Any, Any, Any]:
    """Kinetic, strain and gravity's energy from the entries of an element's balance (element.BALANCE)."""
    axial, coupling, torsion, bending, kinetic, spin, gravity = (balance[k] for k in range(7))
    return kinetic + spin, axial + coupling + torsion + bending, gravity


def total(ledger: Any) -> Any:
    """Kinetic, strain and potential energy."""
    return ledger.kinetic + ledger.strain + ledger.gravity


def residual(ledger: Any) -> Any:
    """What the rest does not account for: what the integrator dissipated (negative) or put in."""
    explained = ledger.work_ends + ledger.transformations - ledger.dissipated_material - ledger.dissipated_swivel
    return total(ledger) - ledger.start - explained + ledger.nonconservative
