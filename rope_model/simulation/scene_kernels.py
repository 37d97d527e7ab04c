"""Kernels that the rope of a scene needs, from its features and its possible fidelities."""

from rope_model.parameters import Scene
from rope_model.physics.element import ELEMENT_DOF, ElementFidelity
from rope_model.physics.rope_element import AIR, CURVED, WIRES, Features
from rope_model.physics.wire_friction import wire_stiffness
from rope_model.rules.fidelity import FIDELITIES, Ends, choose_fidelity, flexible
from rope_model.simulation.contact.obstacles import find_obstacles
from rope_model.simulation.curvature import is_curved, partly_curved
from rope_model.simulation.rope_system import air_parameters


def acting_along(scene: Scene, fidelity: ElementFidelity, rubs: bool) -> Features:
    """Return the features all along the rope; ``rubs``: true if its wires rub."""
    present = {
        CURVED: is_curved(scene.rope, fidelity),
        WIRES: rubs,
        AIR: air_parameters(scene).size > 0,
    }
    return tuple(kind for kind, there in present.items() if there)


def kernels_needed(scene: Scene, ends: Ends) -> tuple[tuple[ElementFidelity, Features], ...]:
    """Return fidelity and features of the kernels that a rope of ``scene`` between these ``ends`` may need.

    Plain kernels of every fidelity are among them, since an importer of the FMU may set other data.
    """
    chosen = choose_fidelity(scene, ends).fidelity
    higher = FIDELITIES[FIDELITIES.index(chosen) :] if scene.model.fidelity == "auto" else [chosen]
    obstacles = find_obstacles(scene)
    needed: list[tuple[ElementFidelity, Features]] = [(fidelity, ()) for fidelity in ELEMENT_DOF]
    straight = scene.with_(
        rope=partly_curved(scene.rope, 0.0)
    )  # every rope is first hung up straight
    needed += [
        (fidelity, (*acting_along(hung, fidelity, rubs), *near))
        for fidelity in map(flexible, higher)
        for hung, rubs in (
            (straight, False),
            (scene, False),
            (scene, wire_stiffness(scene.rope) > 0),
        )
        for near in ((), obstacles.kinds if obstacles else ())
    ]
    return tuple(dict.fromkeys(needed))
