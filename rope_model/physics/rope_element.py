"""The element of a rope with all that acts along it: physics.element with curvature, wires, air and contact."""

from rope_model.physics.air_element import air_element
from rope_model.physics.contact_element import contact_element
from rope_model.physics.curved_element import curved_element
from rope_model.physics.element import ElementFidelity, ElementFunctions, element_functions
from rope_model.physics.shaft import KINDS
from rope_model.physics.wire_element import wire_element

#: kinds of the bodies that a rope may touch; before them AIR, WIRES for friction between wires, and
#: CURVED for permanent curvature
Features = tuple[int, ...]
AIR, WIRES, CURVED = range(len(KINDS), len(KINDS) + 3)


def rope_element(fidelity: ElementFidelity, features: Features = ()) -> ElementFunctions:
    """Return the element with all features.

    Behind the frame's entries F holds those of the permanent curvature, then those of the wires;
    behind the element's parameters P holds those of the air, then those of the bodies.
    """
    functions = element_functions(fidelity)
    if CURVED in features:
        functions = curved_element(functions)
    if WIRES in features:
        functions = wire_element(fidelity, functions)
    if AIR in features:
        functions = air_element(fidelity, functions)
    touched = kinds_touched(features)
    if touched:
        return contact_element(fidelity, functions, touched)
    return functions


def kinds_touched(features: Features) -> Features:
    """Return the kinds of bodies among the features."""
    return tuple(kind for kind in features if kind < len(KINDS))
