"""The interface table as modelDescription.xml of FMI 2.0, for the Python and the native flavour."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

from .interface import Variable
from .units import QUANTITIES, add_units, quantity_attributes, units_of

MODEL = "BalanceRope"
DESCRIPTION = (
    "Balance rope of a friction hoist: coupled tension, torsion and lateral motion of a round wire rope hanging in a "
    "U below two conveyances, with swivels; time-varying mesh TMN-ETM"
)
EXPERIMENT = {"startTime": "0", "stopTime": "30", "stepSize": "0.01"}
LOG_CATEGORIES = {
    "logStatusError": "why a call failed, and what to do",
    "logStatusWarning": "what to mind in valid results, once",
    "logAll": "all messages",
}
#: outputs with directional derivatives: end forces and moments
_FORCES = tuple(f"{side}.{kind}{axis}" for side in ("left", "right") for kind in "fm" for axis in "xyz")


class Build(NamedTuple):
    """What the model description says of the FMU itself.

    ``token`` is the GUID; ``date`` is UTC as in 2026-01-31T12:00:00Z, or empty; ``sources`` are the C files that make
    a native FMU, none for the Python flavour. A model other than the rope gives its ``name`` and ``description``, and
    one without directional derivatives says so.
    """

    token: str
    version: str
    tool: str
    date: str
    sources: tuple[str, ...] = ()
    name: str = MODEL
    description: str = DESCRIPTION
    derivatives: bool = True


def model_description(table: Sequence[Variable], build: Build) -> Element:
    """The root element."""
    root = Element("fmiModelDescription", {"fmiVersion": "2.0", "guid": build.token, **facts(build)})
    _add_interface(root, build)
    add_units(root, table)
    types = SubElement(root, "TypeDefinitions")
    for unit in units_of(table):
        SubElement(SubElement(types, "SimpleType", name=QUANTITIES[unit].name), "Real", quantity_attributes(unit))
    add_log_categories(root)
    SubElement(root, "DefaultExperiment", EXPERIMENT)
    model_variables = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(table):
        _add_variable(model_variables, reference, variable)
    structure = SubElement(root, "ModelStructure")
    inputs = " ".join(str(index) for index, v in enumerate(table, start=1) if v.causality == "input")
    for section in ("Outputs", "InitialUnknowns"):
        node = SubElement(structure, section)
        for index, variable in enumerate(table, start=1):
            if variable.causality == "output":
                unknown = SubElement(node, "Unknown", index=str(index))
                if section == "Outputs":
                    unknown.attrib |= dependencies(variable, inputs)
    return root


def facts(build: Build) -> dict[str, str]:
    """Attributes of the root element that FMI 2.0 and 3.0 share."""
    out = {
        "modelName": build.name,
        "description": build.description,
        "author": "the balance-rope authors",
        "version": build.version,
        "copyright": "the balance-rope authors",
        "license": "BSD-3-Clause",
        "generationTool": build.tool,
        "variableNamingConvention": "structured",
    }
    return out | ({"generationDateAndTime": build.date} if build.date else {})


def dependencies(variable: Variable, inputs: str) -> dict[str, str]:
    """End forces and moments depend on all motions of the step that ended; without attributes an output may on all."""
    if variable.name not in _FORCES:
        return {}
    return {"dependencies": inputs, "dependenciesKind": " ".join("dependent" for _ in inputs.split())}


def add_log_categories(root: Element) -> None:
    """``LogCategories``, alike in FMI 2.0 and 3.0."""
    categories = SubElement(root, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=description)


def common_attributes(variable: Variable) -> dict[str, str]:
    """Attributes of a variable that FMI 2.0 and 3.0 share."""
    out = {
        "description": variable.description,
        "causality": variable.causality,
        "variability": variable.variability,
    }
    if variable.causality != "input":
        out["initial"] = "calculated" if variable.causality == "output" else "exact"
    return out


def type_attributes(variable: Variable) -> dict[str, str]:
    """Declared type, unit and bounds."""
    out = {"declaredType": QUANTITIES[variable.unit].name, "unit": variable.unit} if variable.unit else {}
    for key, bound in (("min", variable.minimum), ("max", variable.maximum)):
        if bound is not None:
            out[key] = f"{bound:g}"
    return out


def _add_interface(root: Element, build: Build) -> None:
    interface = SubElement(
        root,
        "CoSimulation",
        modelIdentifier=build.name,
        needsExecutionTool="false",
        canHandleVariableCommunicationStepSize="true",
        canInterpolateInputs="false",
        maxOutputDerivativeOrder="0",
        canRunAsynchronuously="false",
        canBeInstantiatedOnlyOncePerProcess="false",
        canNotUseMemoryManagementFunctions="false",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        providesDirectionalDerivative=_xml(build.derivatives),
    )
    if build.sources:
        files = SubElement(interface, "SourceFiles")
        for name in build.sources:
            SubElement(files, "File", name=name)


def _add_variable(parent: Element, reference: int, variable: Variable) -> None:
    attributes = {"name": variable.name, "valueReference": str(reference), **common_attributes(variable)}
    node = SubElement(parent, "ScalarVariable", attributes)
    start = {} if variable.start is None else {"start": _xml(variable.start)}
    SubElement(node, variable.kind, type_attributes(variable) | start)


def _xml(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
