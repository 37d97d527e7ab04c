"""The interface table as modelDescription.xml of FMI 3.0 (native flavour): arrays, enumerations, the time."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from .arrays import Array, arrays
from .interface import CHOICES, Variable, choices_of
from .model_description import (
    EXPERIMENT,
    Build,
    add_log_categories,
    common_attributes,
    dependencies,
    facts,
    type_attributes,
)
from .units import QUANTITIES, add_units, quantity_attributes, units_of

_KINDS = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean", "String": "String"}
#: key of CHOICES -> name of the declared type
_ENUMERATIONS = {
    "swivel.mode": "SwivelMode",
    "mesh.kind": "MeshKind",
    "solver.kernels": "KernelForm",
    "model.rung": "Rung",
}


def model_description3(table: Sequence[Variable], build: Build) -> Element:
    """The root element."""
    root = Element("fmiModelDescription", {"fmiVersion": "3.0", "instantiationToken": build.token, **facts(build)})
    SubElement(
        root,
        "CoSimulation",
        modelIdentifier=build.name,
        needsExecutionTool="false",
        canBeInstantiatedOnlyOncePerProcess="false",
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
        providesDirectionalDerivatives="true",
        providesAdjointDerivatives="false",
        providesPerElementDependencies="false",
        canHandleVariableCommunicationStepSize="true",
        maxOutputDerivativeOrder="0",
        providesIntermediateUpdate="false",
        mightReturnEarlyFromDoStep="false",
        canReturnEarlyAfterIntermediateUpdate="false",
        hasEventMode="false",
        providesEvaluateDiscreteStates="false",
    )
    add_units(root, table)
    _add_types(root, table)
    add_log_categories(root)
    SubElement(root, "DefaultExperiment", EXPERIMENT)
    variables, structure = SubElement(root, "ModelVariables"), SubElement(root, "ModelStructure")
    time = {"name": "time", "valueReference": str(len(table)), "causality": "independent"}
    SubElement(
        variables, "Float64", time | {"description": "time", "variability": "continuous", "declaredType": "Time"}
    )
    gathered = arrays(table)
    for array in gathered:
        _add_variable(variables, array)
    outputs = [array for array in gathered if array.variable.causality == "output"]
    inputs = " ".join(str(array.reference) for array in gathered if array.variable.causality == "input")
    for array in outputs:
        attributes = dependencies(array.variable, inputs)
        SubElement(structure, "Output", {"valueReference": str(array.reference), **attributes})
    for array in outputs:
        SubElement(structure, "InitialUnknown", valueReference=str(array.reference))
    return root


def build_description(build: Build) -> Element:
    """sources/buildDescription.xml: what ``fmpy compile`` and other tools need to compile the sources."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    files = SubElement(
        SubElement(root, "BuildConfiguration", modelIdentifier=build.name), "SourceFileSet", language="C99"
    )
    for name in build.sources:
        SubElement(files, "SourceFile", name=name)
    # the binary's functions have no prefix
    SubElement(files, "PreprocessorDefinition", name="FMI3_OVERRIDE_FUNCTION_PREFIX", value="1")
    return root


def _add_types(root: Element, table: Sequence[Variable]) -> None:
    types = SubElement(root, "TypeDefinitions")
    for unit in units_of(table):
        SubElement(types, "Float64Type", {"name": QUANTITIES[unit].name, **quantity_attributes(unit)})
    for key, name in _ENUMERATIONS.items():
        enumeration = SubElement(types, "EnumerationType", name=name)
        for code, word in enumerate(CHOICES[key]):
            SubElement(enumeration, "Item", name=word, value=str(code))


def _add_variable(parent: Element, array: Array) -> None:
    v = array.variable
    attributes = {"name": array.name, "valueReference": str(array.reference), **common_attributes(v)}
    kind = _KINDS[v.kind]
    if choices_of(v.name) is None:
        attributes |= type_attributes(v)
    else:
        kind = "Enumeration"
        attributes["declaredType"] = _ENUMERATIONS[".".join(v.name.split(".")[-2:])]
    if v.start is not None:
        attributes["start"] = " ".join(
            str(start).lower() if v.kind == "Boolean" else str(start) for start in array.starts
        )
    node = SubElement(parent, kind, attributes)
    if array.length > 1:
        SubElement(node, "Dimension", start=str(array.length))
