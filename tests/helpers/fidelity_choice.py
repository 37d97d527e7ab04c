"""Choice of the fidelity in plain Python, an oracle for ``csrc/ends/fidelity.c``."""

from typing import NamedTuple

from rope_model.boundary.end_paths import EndMotion
from rope_model.fidelity import fidelity_rules
from rope_model.fidelity.choice import FIDELITIES, Fidelity
from rope_model.messages import fidelity_messages, messages
from rope_model.messages.rules import first_text
from rope_model.parameters import Scene
from rope_model.physics.node import SIDES

Ends = tuple[EndMotion, EndMotion]


class Choice(NamedTuple):
    """A fidelity and the reason for it."""

    fidelity: Fidelity
    reason: str


def choose_fidelity(scene: Scene, ends: Ends, forces: int = 0) -> Choice:
    """Return the fidelity that the scene prescribes, or the lowest that serves.

    ``forces`` is the number of points at which the host applies forces.
    """
    if scene.model.fidelity != "auto":
        return Choice(scene.model.fidelity, fidelity_messages.as_set())
    return _lowest(scene, ends, forces)


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
