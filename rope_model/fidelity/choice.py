"""Choice of the model's fidelity: the lowest that the scene needs, with the reason.

    torsional   complete rope
    spatial     no torsion: equal for a rope without torque, except for spin inertia and theta's interpolation
    planar      equal for a rope that carries no torque and stays in the plane
    rigid       no waves, no bending: closed-form end forces of an inextensible rope, see csrc/physics/rigid.c

A torque-free rope has no coupling, no installed twist and no permanent curvature.  Out of plane its
swivels must turn freely as well, or its writhe twists it; they may hold at the start, which must be
in the plane.  The omitted quantities are then zero in the complete model too.  Otherwise 'auto'
takes a lower fidelity only if the estimated error of the vertical end forces (root mean square over
a winding, relative to the largest) is within the scene's tolerance.  physics.estimates has the
estimates, fidelity.fidelity_rules the formulas of the decision, which csrc/ends/fidelity.c takes.
"""

from typing import Literal

Fidelity = Literal["torsional", "spatial", "planar", "rigid"]

#: fidelities from the simplest to the complete one
FIDELITIES: tuple[Fidelity, ...] = ("rigid", "planar", "spatial", "torsional")
