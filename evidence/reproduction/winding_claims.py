"""Claims about the 120 m winding: displacement and twist, stress, kinetic energy."""

import numpy as np

from evidence.claims import above, below
from evidence.reproduction.claim import Claim, Section
from evidence.reproduction.windings import COUPLINGS, MESHES, SIDES, STRESSES
from evidence.tables import Array, Table, Tables, rows

#: % of the rope's length that still are a few areas; the bound is ours
FEW = 10.0
#: J, stated in the source: change per transformation, and difference to EEM of about 1e4 J
SOURCE_CHANGE = 1e-4
SOURCE_DIFFERENCE = 1.0
WINDINGS = [f"winding-{coupling}" for coupling in COUPLINGS]


def worst_difference(tables: Tables, *quantities: str) -> float:
    """Return the largest difference between the meshes over the largest value, %; what is zero in both is left out."""

    def largest(t: Table, which: str, quantity: str) -> float:
        return float(np.max(np.abs([t[f"{which} {side} {quantity}"] for side in SIDES])))

    pairs = [
        (largest(tables[w], "difference", q), largest(tables[w], "EEM", q))
        for w in WINDINGS
        for q in quantities
    ]
    return 100 * max(difference / value for difference, value in pairs if value > 0)


def margin(t: Table) -> float:
    """Return the smallest displacement out of plane of either leg to its own side, mm; negative on a shared side."""
    legs = [t[f"EEM {side} out of plane [mm]"] for side in SIDES]
    sense = np.sign(legs[0][0])
    return float(min(np.min(sense * legs[0]), np.min(-sense * legs[1])))


def displacement_claims(tables: Tables) -> list[Claim]:
    """Compare what the source says of the observation points."""
    in_both = worst_difference(tables, "out of plane [mm]", "in plane [mm]")
    return [
        Claim(
            "left and right out-of-plane displacement keep opposite signs through the whole travel",
            above(
                "smallest displacement of a leg to its own side",
                margin(tables["winding-coupled"]),
                0.0,
                "mm",
            ),
        ),
        Claim(
            "TMN-ETM agrees with EEM in displacement",
            below("largest difference / largest displacement", in_both, 1.0, "%"),
        ),
        Claim(
            "TMN-ETM agrees with EEM in twist",
            below(
                "largest difference / largest theta",
                worst_difference(tables, "theta [mrad]"),
                1.0,
                "%",
            ),
        ),
    ]


def stress_claims(tables: Tables) -> list[Claim]:
    """Compare what the source says of the stress norms."""
    t = tables["stress-places"]
    words = {"bending": "bending", "torsion": "torsional"}
    share = "largest share of the rope above half of the current maximum"
    above_half = {kind: float(t[f"EEM {kind} above half [%]"].max()) for kind in STRESSES}
    away = float(np.max(np.abs(t["EEM bending largest at s [m]"] - t["EEM loop s [m]"])))
    even = "no torque acts along a leg, so the torque is nearly uniform"
    claims = [
        Claim(
            "only a few areas carry large bending stress",
            below(share, above_half["bending"], FEW, "%"),
        ),
        Claim(
            "only a few areas carry large torsional stress",
            below(share, above_half["torsion"], FEW, "%"),
            even,
        ),
        Claim(
            "the areas follow the conveyances (bending)",
            below("largest distance along the rope from the loop's lowest point", away, 1.0, "m"),
        ),
    ]
    for kind in STRESSES:
        tmn, eem = (t[f"{mesh} {kind} largest [MPa]"] for mesh in MESHES)
        apart = below(
            "largest difference of the maxima", 100 * float(np.max(np.abs(tmn / eem - 1))), 2.0, "%"
        )
        mean = "a stress is that of an element's mean square curvature, over 1 m of the loop here and 0.2 m in EEM"
        claims.append(
            Claim(f"TMN-ETM agrees with EEM in the {words[kind]} stress norm", apart, mean)
        )
    return claims


def changes(tables: Tables, coupling: str) -> tuple[Array, Array]:
    """Return instants of the transformations and what they change the kinetic energy by, J."""
    t = rows(tables["transformations"], coupling=coupling)
    return t["t [s]"], np.abs(t["kinetic [J]"])


def energy_claims(tables: Tables) -> list[Claim]:
    """Compare what the source says of the energy."""
    relative = 0.0
    largest = 0.0
    for coupling, w in zip(COUPLINGS, WINDINGS, strict=True):
        at, change = changes(tables, coupling)
        energy = np.interp(at, tables[w]["t [s]"], tables[w]["TMN-ETM kinetic [J]"])
        relative = max(relative, float(np.max(change / energy)))
        largest = max(largest, float(change.max()))
    difference = max(float(np.abs(tables[w]["difference kinetic [J]"]).max()) for w in WINDINGS)
    return [
        Claim(
            "energy before and after a transformation agrees",
            below("largest relative change of the kinetic energy", relative, 1e-6),
        ),
        Claim(
            "the kinetic energy changes by less than 1e-4 J per transformation",
            below("largest change", largest, SOURCE_CHANGE, "J"),
        ),
        Claim(
            "the kinetic energy differs from EEM by less than 1 J of 1e4 J",
            below("largest difference", difference, SOURCE_DIFFERENCE, "J"),
        ),
    ]


SECTIONS = (
    Section("Displacement and twist", displacement_claims, WINDINGS),
    Section("Stress", stress_claims, ("stress-places",)),
    Section("Kinetic energy", energy_claims, ("transformations",)),
)
