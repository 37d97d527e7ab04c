"""Model descriptions, modelDescription.xml of FMI 2.0 and 3.0, from the interface table.

Outputs depend on no input of their instant: a step alone changes them.  FMI Library takes empty
lists only for no lists at all, and PyFMI then assumes loops; so ``status.message``, which nobody
connects, has no list.  During initialisation outputs depend on the list in ``Build.initial``; no
list means all inputs and parameters.
"""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element

from fmu_src.interface import RATES, Variable
from fmu_src.profile import VariableArray
from fmu_src.units import DECLARED_TYPES, quantity_attributes, unit_definition, units_of
from fmu_src.xml import attribute_text, node
from rope_model.parameters import CHOICES
from rope_model.scene_names import choices_of

MODEL = "BalanceRope"
DESCRIPTION = (
    "Balance rope of a friction hoist: coupled tension, torsion and lateral motion of a round wire "
    "rope hanging in a U below two conveyances, with swivels; time-varying mesh TMN-ETM"
)
STEP = 0.01  # s, communication step of the default experiment
LOG_CATEGORIES = {
    "logStatusError": "cause and cure of a failed call",
    "logStatusWarning": "warnings about valid results, once each",
    "logAll": "all messages",
}
#: dependencies of outputs that depend on all inputs and parameters during initialisation
ALL_FOLLOWED: Mapping[str, Sequence[str]] = MappingProxyType({})
#: types of FMI 3.0
_TYPES3 = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean", "String": "String"}
#: name of the declared type of FMI 3.0 by key of CHOICES
_ENUMERATIONS = {
    "inputs.given": "InputsGiven",
    "swivel.mode": "SwivelMode",
    "swivel.attachment": "Attachment",
    "swivel.start": "SwivelStart",
    "mesh.kind": "MeshKind",
    "model.fidelity": "Fidelity",
}


class Build(NamedTuple):
    """Facts of the FMU itself for the model description.

    ``token`` is the GUID; ``date`` is UTC as in 2026-01-31T12:00:00Z, or empty; ``sources`` are the
    C files that make a native FMU, none for the Python flavour; ``stop`` is the default
    experiment's, ``tolerance`` that of the model's own error control, where it has one. A model
    other than the rope gives its ``name``, ``description`` and ``identifier``, and one without
    directional derivatives or events says so; ``initial`` names the variables that some outputs
    follow during initialisation; the others follow all.
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
    events: bool = True
    initial: Mapping[str, Sequence[str]] = ALL_FOLLOWED
    identifier: str = MODEL


def model_description(described: Mapping[int, Variable], build: Build) -> Element:
    """Return the root element of FMI 2.0 for the variables by value reference."""
    variables = described.values()
    sources = []
    if build.sources:
        sources = [node("SourceFiles", *(node("File", name=name) for name in build.sources))]
    interface = node(
        "CoSimulation",
        *sources,
        modelIdentifier=build.identifier,
        needsExecutionTool=False,
        canHandleVariableCommunicationStepSize=True,
        canGetAndSetFMUstate=True,
        canSerializeFMUstate=True,
        canInterpolateInputs=any(v.causality == "input" and v.name in RATES for v in variables),
        maxOutputDerivativeOrder=0,
        canRunAsynchronuously=False,
        canBeInstantiatedOnlyOncePerProcess=False,
        canNotUseMemoryManagementFunctions=False,
        providesDirectionalDerivative=build.derivatives,
    )
    units = units_of(variables)
    types = [
        node("SimpleType", node("Real", **quantity_attributes(u)), name=DECLARED_TYPES[u].name)
        for u in units
    ]
    listed = [
        node(
            "ScalarVariable",
            node(v.kind, **_type_attributes(v), start=v.start),
            name=v.name,
            valueReference=reference,
            **_common_attributes(v),
        )
        for reference, v in described.items()
    ]
    indices = {v.name: index for index, v in enumerate(variables, start=1)}
    outputs = {v.name: indices[v.name] for v in variables if v.causality == "output"}
    at_start = (
        node("Unknown", dependencies=_dependencies(build, x, indices), index=k)
        for x, k in outputs.items()
    )
    later = (
        node("Unknown", dependencies=_dependencies_later(x), index=k) for x, k in outputs.items()
    )
    content = _Content(
        interface=interface,
        units=units,
        types=types,
        variables=listed,
        structure=[node("Outputs", *later), node("InitialUnknowns", *at_start)],
    )
    return _document(build, {"fmiVersion": "2.0", "guid": build.token}, content)


def model_description3(gathered: Sequence[VariableArray], time: int, build: Build) -> Element:
    """Return the root element of FMI 3.0.

    ``time`` is the value reference of the independent variable.
    """
    interface = node(
        "CoSimulation",
        modelIdentifier=build.identifier,
        maxOutputDerivativeOrder=0,
        canGetAndSetFMUState=True,
        canSerializeFMUState=True,
        canHandleVariableCommunicationStepSize=True,
        mightReturnEarlyFromDoStep=build.events,
        hasEventMode=build.events,
        providesDirectionalDerivatives=build.derivatives,
        needsExecutionTool=False,
        canBeInstantiatedOnlyOncePerProcess=False,
        providesAdjointDerivatives=False,
        providesPerElementDependencies=False,
        providesIntermediateUpdate=False,
        canReturnEarlyAfterIntermediateUpdate=False,
        providesEvaluateDiscreteStates=False,
    )
    variables = [array.variable for array in gathered]
    units = units_of(variables)
    types = [
        node("Float64Type", name=DECLARED_TYPES[unit].name, **quantity_attributes(unit))
        for unit in units
    ]
    types += map(
        _enumeration, dict.fromkeys(_choice(v.name) for v in variables if choices_of(v.name))
    )
    independent = {"causality": "independent", "variability": "continuous", "description": "time"}
    listed = [node("Float64", name="time", valueReference=time, **independent, declaredType="Time")]
    listed += map(_variable3, gathered)
    numbers = {array.name: array.reference for array in gathered}
    outputs = {
        array.name: array.reference for array in gathered if array.variable.causality == "output"
    }
    structure = [
        node("Output", valueReference=k, dependencies=_dependencies_later(x))
        for x, k in outputs.items()
    ]
    structure += [
        node(
            "InitialUnknown",
            dependencies=_dependencies(build, name, numbers),
            valueReference=number,
        )
        for name, number in outputs.items()
    ]
    head = {"fmiVersion": "3.0", "instantiationToken": build.token}
    return _document(build, head, _Content(interface, units, types, listed, structure))


def build_description(build: Build, fmi: int) -> Element:
    """Return sources/buildDescription.xml: a shared library, which comes first, and a static one.

    In a shared library the functions of FMI have their own names, in a static one the model
    identifier before them.
    """
    override = node("PreprocessorDefinition", name=f"FMI{fmi}_OVERRIDE_FUNCTION_PREFIX", value=1)
    prefix = node(
        "PreprocessorDefinition", name=f"FMI{fmi}_FUNCTION_PREFIX", value=f"{build.identifier}_"
    )
    configurations = (
        _configuration(build, "shared library: the functions of FMI have no prefix", override),
        _configuration(
            build, "static linking: the functions of FMI begin with the model identifier", prefix
        ),
    )
    return node("fmiBuildDescription", *configurations, fmiVersion="3.0")


def _configuration(build: Build, description: str, definition: Element) -> Element:
    files = [node("SourceFile", name=name) for name in build.sources]
    sources = node("SourceFileSet", *files, definition, language="C99")
    return node(
        "BuildConfiguration", sources, modelIdentifier=build.identifier, description=description
    )


class _Content(NamedTuple):
    """Content of a model description that differs between the versions of FMI."""

    interface: Element
    units: Sequence[str]
    types: Sequence[Element]
    variables: Sequence[Element]
    structure: Sequence[Element]


def _document(build: Build, head: Mapping[str, str], content: _Content) -> Element:
    """Return the root element of either version."""
    categories = (
        node("Category", name=name, description=text) for name, text in LOG_CATEGORIES.items()
    )
    if build.tolerance is None:
        tolerance = None
    else:
        tolerance = f"{build.tolerance:g}"
    return node(
        "fmiModelDescription",
        content.interface,
        node("UnitDefinitions", *map(unit_definition, content.units)),
        node("TypeDefinitions", *content.types),
        node("LogCategories", *categories),
        node(
            "DefaultExperiment",
            startTime=0,
            stopTime=f"{build.stop:g}",
            stepSize=f"{STEP:g}",
            tolerance=tolerance,
        ),
        node("ModelVariables", *content.variables),
        node("ModelStructure", *content.structure),
        **head,
        modelName=build.name,
        description=build.description,
        author="the balance-rope authors",
        version=build.version,
        copyright="the balance-rope authors",
        license="BSD-3-Clause",
        generationTool=build.tool,
        variableNamingConvention="structured",
        generationDateAndTime=build.date or None,
    )


def _dependencies(build: Build, name: str, numbers: Mapping[str, int]) -> str | None:
    """Return the dependencies of an output during initialisation.

    They are ``numbers`` that identify variables; None for all.
    """
    follows = build.initial.get(name)
    if follows is None:
        return None
    return " ".join(str(numbers[other]) for other in follows)


def _dependencies_later(name: str) -> str | None:
    """Return the dependencies of an output after initialisation: an empty list, or no list."""
    return None if name == "status.message" else ""


def _common_attributes(v: Variable) -> dict[str, str]:
    """Return the attributes of a variable that FMI 2.0 and 3.0 share."""
    attributes = {
        "description": v.description,
        "causality": v.causality,
        "variability": v.variability,
    }
    if v.causality == "output":
        attributes["initial"] = "calculated"
    elif v.causality == "parameter":
        attributes["initial"] = "exact"
    return attributes


def _type_attributes(v: Variable) -> dict[str, Any]:
    """Return declared type, unit and bounds."""
    attributes = {}
    if v.unit:
        attributes = {"declaredType": DECLARED_TYPES[v.unit].name, "unit": v.unit}
    if v.minimum is not None:
        attributes["min"] = f"{v.minimum:g}"
    if v.maximum is not None:
        attributes["max"] = f"{v.maximum:g}"
    return attributes


def _choice(name: str) -> str:
    """Return the key of CHOICES."""
    return ".".join(name.split(".")[-2:])


def _enumeration(key: str) -> Element:
    items = enumerate(CHOICES[key].items())
    nodes = (
        node("Item", name=word, value=code, description=meaning) for code, (word, meaning) in items
    )
    return node("EnumerationType", *nodes, name=_ENUMERATIONS[key])


def _variable3(array: VariableArray) -> Element:
    v = array.variable
    kind = _TYPES3[v.kind]
    type_attributes = _type_attributes(v)
    if choices_of(v.name):
        kind = "Enumeration"
        type_attributes = {"declaredType": _ENUMERATIONS[_choice(v.name)]}
    dimensions = []
    if array.length > 1:
        dimensions = [node("Dimension", start=array.length)]
    return node(
        kind,
        *dimensions,
        name=array.name,
        valueReference=array.reference,
        **_common_attributes(v),
        **type_attributes,
        start=None if v.start is None else " ".join(map(attribute_text, array.starts)),
    )
