"""Effects that a fidelity leaves out: their outputs are 0 and no results, or exact only without torque.

One table serves the warnings of the rope, the reports and the documents.
"""

from typing import NamedTuple

from rope_model.fidelity.choice import FIDELITIES, Fidelity


class Effect(NamedTuple):
    """Outputs that the fidelities from ``lowest`` on compute, and simpler ones leave out."""

    lowest: Fidelity  #: lowest fidelity that computes them
    words: str  #: text for reports
    outputs: tuple[str, ...]  #: names of outputs, or their common part
    by_torque: bool  #: true if 0 is exact without torque

    def has(self, name: str) -> bool:
        """Return whether the output ``name`` is one of them."""
        return any(f".{output}." in f".{name.partition('[')[0]}." for output in self.outputs)


EFFECTS = (
    Effect(
        "planar",
        "side forces, strain energy, damping and friction in the rope, bodies that it touches, and air",
        (
            "fx",
            "mz",
            "energy.strain",
            "energy.dissipated_material",
            "energy.dissipated_wires",
            "contact",
            "energy.dissipated_contact",
            "energy.given_to_air",
        ),
        by_torque=False,
    ),
    Effect(
        "spatial",
        "yaw and all else out of the plane",
        ("fz", "mx", "loop.z", "loop.yaw", "loop.turns"),
        by_torque=True,
    ),
    Effect(
        "torsional",
        "torque, twist, permanent curvature, turning swivels and torsional stress",
        (
            "my",
            "swivel",
            "twist",
            "stress.torsion_max",
            "shape.torsion",
            "station.torque",
            "energy.dissipated_swivel",
            "energy.nonconservative",
        ),
        by_torque=True,
    ),
)


def neglected_effects(fidelity: Fidelity) -> tuple[Effect, ...]:
    """Return the effects that the fidelity leaves out."""
    return tuple(
        effect for effect in EFFECTS if FIDELITIES.index(effect.lowest) > FIDELITIES.index(fidelity)
    )


def neglected_text(fidelity: Fidelity) -> str:
    """Return the warning of a fidelity with neglected effects; '' for the complete one."""
    if not (effects := neglected_effects(fidelity)):
        return ""
    names = [name for effect in effects for name in effect.outputs]
    if fidelity == "spatial":
        names.append("the yaw by torque")
    bending = "bending and no " if fidelity == "rigid" else ""
    return (
        f"the {fidelity} model computes no {bending}torsion and no permanent curvature: {', '.join(names[:-1])} and "
        f"{names[-1]} are 0 and no results; set model.fidelity = torsional (1) where they matter"
    )
