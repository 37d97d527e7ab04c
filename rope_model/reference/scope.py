"""Scope of the reference rope: the published system, and nothing else of a scene."""

from rope_model.messages import messages
from rope_model.parameters import Scene
from rope_model.physics.air import air_acts
from rope_model.physics.initial_curvature import CURVATURES
from rope_model.scene_names import choices_of, named_parameters

#: values of parameters with which a rope is the published one; other values need the engine
PUBLISHED: dict[str, tuple[float, ...]] = {
    "rope.EI_stick": (0,),
    **{f"rope.{name}": (0,) for name in CURVATURES},
    "left.swivel.attachment": (0,),
    "right.swivel.attachment": (0,),
    "mesh.lateral_frequency": (0,),
    "model.fidelity": (0, 1),
    "inputs.given": (0,),
    "solver.work_max": (0,),
    "contact.rope_stiffness": (0,),
    "guard.rise": (0,),
    "guard.window": (0,),
    "guard.clearance": (0,),
    "guard.turns": (0,),
    "guard.torque": (0,),
}
#: values with which there are no bodies to be touched; they matter if the stiffness of contact is
#: above 0
NO_BODIES: dict[str, tuple[float, ...]] = {
    "lining.width": (0,),
    "lining.depth": (0,),
    "conveyance.width": (0,),
    "head_ropes.diameter": (0,),
    "divider_1.size": (0,),
    "divider_2.size": (0,),
    "divider_3.size": (0,),
    "divider_4.size": (0,),
    "sump.level": (-1e6,),
}

#: values of a scene without air; they matter if the air acts
NO_AIR: dict[str, tuple[float, ...]] = {
    parameter.name: (parameter.value,)
    for parameter in named_parameters(Scene())
    if parameter.name.startswith("air.")
}


def require_published(scene: Scene) -> None:
    """Raise ValueError if the scene holds more than the published system."""
    text = unpublished(scene)
    if text is not None:
        raise ValueError(messages.engine_alone(text))


def unpublished(scene: Scene) -> str | None:
    """Return None for a scene of the published system; else the first value that is none of it."""
    allowed = dict(PUBLISHED)
    if scene.shaft.contact.stiffness > 0:
        allowed |= NO_BODIES
    if air_acts(scene.shaft.air, scene.rope.diameter):
        allowed |= NO_AIR
    for parameter in named_parameters(scene):
        values = allowed.get(parameter.name, (parameter.value,))
        if parameter.value not in values:
            words = choices_of(parameter.name)
            if words:
                value = words[int(parameter.value)]
            else:
                value = f"{parameter.value:g}"
            bound = " or ".join(words[int(x)] if words else f"{x:g}" for x in values)
            return (
                f"{parameter.name} = {value} must be {bound} for the reference rope, which knows "
                "the published system only"
            )
    return None
