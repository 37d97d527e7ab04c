"""The interface table as modelDescription.xml of FMI 2.0."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from .interface import Variable

DESCRIPTION = (
    "Balance rope of a friction hoist: coupled tension, torsion and lateral motion of a round wire rope hanging in a "
    "U below two conveyances, with swivels; time-varying mesh TMN-ETM"
)
#: unit -> exponents of the SI base units, and display units (name, factor)
_UNITS: dict[str, tuple[dict[str, int], dict[str, float]]] = {
    "m": ({"m": 1}, {"mm": 1e3}),
    "s": ({"s": 1}, {"ms": 1e3}),
    "kg": ({"kg": 1}, {}),
    "1": ({}, {}),
    "rad": ({"rad": 1}, {"deg": 57.29577951308232}),
    "rad/m": ({"rad": 1, "m": -1}, {}),
    "rad/s": ({"rad": 1, "s": -1}, {}),
    "m/s": ({"m": 1, "s": -1}, {}),
    "m/s2": ({"m": 1, "s": -2}, {}),
    "kg/m": ({"kg": 1, "m": -1}, {}),
    "kg.m": ({"kg": 1, "m": 1}, {}),
    "kg.m2": ({"kg": 1, "m": 2}, {}),
    "N": ({"kg": 1, "m": 1, "s": -2}, {"kN": 1e-3}),
    "N.m": ({"kg": 1, "m": 2, "s": -2}, {}),
    "N.m2": ({"kg": 1, "m": 3, "s": -2}, {}),
    "Pa": ({"kg": 1, "m": -1, "s": -2}, {"MPa": 1e-6}),
    "J": ({"kg": 1, "m": 2, "s": -2}, {"kJ": 1e-3}),
}


def model_description(
    table: Sequence[Variable], identifier: str, guid: str, version: str, tool: str, date: str
) -> Element:
    """The root element; ``date`` is UTC as in 2026-01-31T12:00:00Z."""
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName="BalanceRope",
        guid=guid,
        description=DESCRIPTION,
        author="the balance-rope authors",
        version=version,
        license="BSD-3-Clause",
        generationTool=tool,
        generationDateAndTime=date,
        variableNamingConvention="structured",
    )
    SubElement(
        root,
        "CoSimulation",
        modelIdentifier=identifier,
        needsExecutionTool="true",
        canHandleVariableCommunicationStepSize="true",
        canInterpolateInputs="false",
        canBeInstantiatedOnlyOncePerProcess="false",
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
    )
    definitions = SubElement(root, "UnitDefinitions")
    for name in sorted({v.unit for v in table} - {""}):
        base, displays = _UNITS[name]
        unit = SubElement(definitions, "Unit", name=name)
        SubElement(unit, "BaseUnit", {key: str(exponent) for key, exponent in base.items()})
        for display, factor in displays.items():
            SubElement(unit, "DisplayUnit", name=display, factor=repr(factor))
    categories = SubElement(root, "LogCategories")
    SubElement(categories, "Category", name="logStatusError", description="why a call failed, and what to do")
    SubElement(categories, "Category", name="logAll", description="all messages")
    SubElement(root, "DefaultExperiment", startTime="0", stopTime="30", stepSize="0.01")
    model_variables = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(table):
        _add_variable(model_variables, reference, variable)
    structure = SubElement(root, "ModelStructure")
    for section in ("Outputs", "InitialUnknowns"):
        node = SubElement(structure, section)
        for index, variable in enumerate(table, start=1):
            if variable.causality == "output":
                SubElement(node, "Unknown", index=str(index))
    return root


def _add_variable(parent: Element, reference: int, variable: Variable) -> None:
    node = SubElement(
        parent,
        "ScalarVariable",
        name=variable.name,
        valueReference=str(reference),
        description=variable.description,
        causality=variable.causality,
        variability=variable.variability,
    )
    if variable.causality != "input":
        node.set("initial", "calculated" if variable.causality == "output" else "exact")
    attributes = {} if not variable.unit else {"unit": variable.unit}
    for key, bound in (("min", variable.minimum), ("max", variable.maximum)):
        if bound is not None:
            attributes[key] = str(bound)
    if variable.start is not None:
        start = variable.start
        attributes["start"] = str(start).lower() if isinstance(start, bool) else str(start)
    SubElement(node, variable.kind, attributes)
