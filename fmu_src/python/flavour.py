"""The Python flavour beside the native one: its outputs, its scenes, and its description.

Both have the same names and value references for what both have.
"""

from collections.abc import Mapping

from fmu_src.interface import Variable
from fmu_src.model_description import DESCRIPTION
from rope_model.parameters import Scene
from rope_model.reference.outputs import COMPUTED_NAMES
from rope_model.reference.scope import unpublished
from rope_model.signals.signal_table import SIGNALS

#: description of the model in modelDescription.xml
PYTHON_DESCRIPTION = (
    f"{DESCRIPTION}; Python flavour: the published system, whose inputs are position, speed and "
    "acceleration of one motion (inputs.given = all)"
)


def of_python(described: Mapping[int, Variable]) -> dict[int, Variable]:
    """Return the variables without the outputs that the reference rope does not compute."""
    return {
        reference: v
        for reference, v in described.items()
        if v.name not in SIGNALS or v.name in COMPUTED_NAMES
    }


def require_for_python(scene: Scene) -> None:
    """Raise ValueError if the scene holds more than the published system."""
    text = unpublished(scene)
    if text is not None:
        raise ValueError(f"{text}: take the native flavour, balance-rope export")
