"""The interface table as modelDescription.xml of FMI 2.0, for the Python and the native flavour."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

from fmu_src.interface import RATES, Variable
from fmu_src.units import QUANTITIES, add_units, quantity_attributes, units_of

MODEL = "BalanceRope"
DESCRIPTION = (
    "Balance rope of a friction hoist: coupled tension, torsion and lateral motion of a round wire rope hanging in a "
    "U below two conveyances, with swivels; time-varying mesh TMN-ETM"
)
STEP = 0.01  # s, communication step of the default experiment
LOG_CATEGORIES = {
    "logStatusError": "cause and cure of a failed call",
    "logStatusWarning": "warnings about valid results, once each",
    "logAll": "all messages",
}
#: dependencies of outputs that follow all inputs and parameters during initialisation
ALL_FOLLOWED: Mapping[str, Sequence[str]] = MappingProxyType({})


class Build(NamedTuple):
    """Facts of the FMU itself for the model description.

    ``token`` is the GUID; ``date`` is UTC as in 2026-01-31T12:00:00Z, or empty; ``sources`` are the C files that make a
    native FMU, none for the Python flavour; ``stop`` is the default experiment's, ``tolerance`` that of the model's own
    error control, where it has one. A model other than the rope gives its ``name`` and ``description``, and one without
    directional derivatives says so; ``initial`` names the variables that some outputs follow during initialisation; the
    others follow all.
    """

    token: str
    version: str
    tool: str
    date: str = ""
    stop: float = 30.0
    tolerance: float | None = None
    sources: tuple[str, ...] = ()
    name: str = MODEL
    description: str = DESCRIPTION
    derivatives: bool = True
    initial: Mapping[str, Sequence[str]] = ALL_FOLLOWED


def model_description(described: Mapping[int, Variable], build: Build) -> Element:
    """The root element, of the variables by value reference.

    Outputs depend on no input of their instant: a step alone changes them. During initialisation they follow the list
    in ``build.initial``; no list of dependencies means all inputs and parameters.
    """
    root = Element("fmiModelDescription", {"fmiVersion": "2.0", "guid": build.token, **facts(build)})
    _add_interface(root, build, any(v.causality == "input" and v.name in RATES for v in described.values()))
    add_units(root, described.values())
    types = SubElement(root, "TypeDefinitions")
    for unit in units_of(described.values()):
        SubElement(SubElement(types, "SimpleType", name=QUANTITIES[unit].name), "Real", quantity_attributes(unit))
    add_log_categories(root)
    SubElement(root, "DefaultExperiment", experiment(build))
    model_variables = SubElement(root, "ModelVariables")
    for reference, variable in described.items():
        _add_variable(model_variables, reference, variable)
    structure = SubElement(root, "ModelStructure")
    outputs, at_start = SubElement(structure, "Outputs"), SubElement(structure, "InitialUnknowns")
    indices = {variable.name: index for index, variable in enumerate(described.values(), start=1)}
    for variable in described.values():
        if variable.causality == "output":
            index = str(indices[variable.name])
            SubElement(outputs, "Unknown", index=index, dependencies="")
            SubElement(at_start, "Unknown", initial_dependencies(build, variable.name, indices), index=index)
    return root


def initial_dependencies(build: Build, name: str, numbers: Mapping[str, int]) -> dict[str, str]:
    """The attribute of an output's ``InitialUnknown``; ``numbers`` identify variables in the standard."""
    if (follows := build.initial.get(name)) is None:
        return {}
    return {"dependencies": " ".join(str(numbers[other]) for other in follows)}


def experiment(build: Build) -> dict[str, str]:
    """Attributes of ``DefaultExperiment``."""
    out = {"startTime": "0", "stopTime": f"{build.stop:g}", "stepSize": f"{STEP:g}"}
    return out if build.tolerance is None else out | {"tolerance": f"{build.tolerance:g}"}


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


def add_log_categories(root: Element) -> None:
    """``LogCategories``, alike in FMI 2.0 and 3.0."""
    categories = SubElement(root, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=description)


def common_attributes(variable: Variable) -> dict[str, str]:
    """Attributes of a variable that FMI 2.0 and 3.0 share."""
    out = {"description": variable.description, "causality": variable.causality, "variability": variable.variability}
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


def _add_interface(root: Element, build: Build, interpolates: bool) -> None:
    interface = SubElement(
        root,
        "CoSimulation",
        modelIdentifier=build.name,
        needsExecutionTool="false",
        canHandleVariableCommunicationStepSize="true",
        canInterpolateInputs=_xml(interpolates),
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
