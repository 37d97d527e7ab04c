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
estimates, fidelity.fidelity_rules the formulas of the decision.
"""

import logging
from typing import Literal, NamedTuple

from rope_model.boundary.end_paths import EndMotion
from rope_model.fidelity import fidelity_rules
from rope_model.messages import fidelity_messages, messages
from rope_model.messages.rules import first_text
from rope_model.parameters import Scene
from rope_model.physics.element import ElementFidelity
from rope_model.physics.node import SIDES

log = logging.getLogger(__name__)

Ends = tuple[EndMotion, EndMotion]
Fidelity = Literal["torsional", "spatial", "planar", "rigid"]

#: fidelities from the simplest to the complete one
FIDELITIES: tuple[Fidelity, ...] = ("rigid", "planar", "spatial", "torsional")


class Choice(NamedTuple):
    """A fidelity and the reason for it."""

    fidelity: Fidelity
    reason: str


def flexible(fidelity: Fidelity) -> ElementFidelity:
    """Return the element's fidelity that serves a rope of ``fidelity``."""
    return "planar" if fidelity == "rigid" else fidelity


def choose_fidelity(scene: Scene, ends: Ends, forces: int = 0) -> Choice:
    """Return the fidelity that the scene prescribes, or the lowest that serves.

    ``forces`` is the number of points at which the host applies forces.
    """
    if scene.model.fidelity != "auto":
        return Choice(scene.model.fidelity, fidelity_messages.as_set())
    choice = _lowest(scene, ends, forces)
    log.info("model: %s, because %s", *choice)
    return choice


def lowest_sufficient(scene: Scene, ends: Ends, forces: int = 0) -> Fidelity:
    """Return the lowest fidelity that can follow the ends and forces."""
    return next(
        fidelity for fidelity in FIDELITIES if not unsupported_motion(scene, fidelity, ends, forces)
    )


def unsupported_motion(scene: Scene, fidelity: Fidelity, ends: Ends, forces: int = 0) -> str:
    """Return '' while ``fidelity`` can follow ends and forces, with 'auto' within the tolerance; else the reason."""
    if fidelity == "torsional":
        return ""
    if number := int(fidelity_rules.unsupported_input(scene, fidelity, *ends)):
        reason = _input_text(ends, number)
        held = fidelity == "spatial" and fidelity_rules.out_of_plane(number)
        if held:
            return fidelity_messages.while_swivels_hold(reason)
        return reason
    if scene.model.fidelity == "auto":
        return first_text(fidelity_rules.UNSUPPORTED, scene, fidelity, *ends, forces)
    if fidelity == "rigid" and forces:
        return fidelity_messages.applied_forces()
    return ""


def _lowest(scene: Scene, ends: Ends, forces: int) -> Choice:
    if why := first_text(fidelity_rules.COMPLETE, scene, forces):
        return Choice("torsional", why)
    if number := int(fidelity_rules.held_input(*ends)):
        return Choice(
            "torsional", fidelity_messages.held_where_initialised(_input_text(ends, number))
        )
    estimated = scene.model.force_tolerance > 0
    if estimated:
        fidelity = lowest_sufficient(scene, ends, forces)
    else:
        fidelity = "torsional"
    if why := first_text(fidelity_rules.SUFFICIENT, scene, fidelity, *ends):
        return Choice(
            fidelity if fidelity_rules.carries_torque(scene) or fidelity == "rigid" else "planar",
            why,
        )
    if estimated:
        below = unsupported_motion(scene, "spatial", ends, forces)
    else:
        below = ""
    torque = first_text(fidelity_rules.TORQUE, scene)
    return Choice(
        "torsional", fidelity_messages.torque_and_unsupported(torque, below) if below else torque
    )


def _input_text(ends: Ends, number: int) -> str:
    """Return the text of an input, by its number, with its value."""
    side, index = divmod(number - 1, len(fidelity_rules.INPUTS))
    name = fidelity_rules.INPUTS[index]
    return messages.nonzero_input(SIDES[side], name, getattr(ends[side], name))
