"""Variables as modelDescription.xml of FMI 3.0 (native flavour): arrays, enumerations, the time."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from fmu_src.arrays import Array
from fmu_src.model_description import (
    Build,
    add_log_categories,
    common_attributes,
    experiment,
    facts,
    initial_dependencies,
    type_attributes,
)
from fmu_src.units import QUANTITIES, add_units, quantity_attributes, units_of
from rope_model.parameters import CHOICES
from rope_model.scene_names import choices_of

_KINDS = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean", "String": "String"}
#: key of CHOICES -> name of the declared type
_ENUMERATIONS = {
    "inputs.given": "InputsGiven",
    "swivel.mode": "SwivelMode",
    "swivel.start": "SwivelStart",
    "mesh.kind": "MeshKind",
    "solver.kernels": "KernelForm",
    "model.fidelity": "Fidelity",
}


def model_description3(gathered: Sequence[Array], time: int, build: Build) -> Element:
    """The root element; ``time`` is the value reference of the independent variable.

    Dependencies as in FMI 2.0, see model_description.
    """
    root = Element("fmiModelDescription", {"fmiVersion": "3.0", "instantiationToken": build.token, **facts(build)})
    SubElement(
        root,
        "CoSimulation",
        modelIdentifier=build.name,
        needsExecutionTool="false",
        canBeInstantiatedOnlyOncePerProcess="false",
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
        providesDirectionalDerivatives=str(build.derivatives).lower(),
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
    variables = [array.variable for array in gathered]
    add_units(root, variables)
    types = SubElement(root, "TypeDefinitions")
    for unit in units_of(variables):
        SubElement(types, "Float64Type", {"name": QUANTITIES[unit].name, **quantity_attributes(unit)})
    for key in dict.fromkeys(_choice(v.name) for v in variables if choices_of(v.name)):
        _add_enumeration(types, key)
    add_log_categories(root)
    SubElement(root, "DefaultExperiment", experiment(build))
    listed, structure = SubElement(root, "ModelVariables"), SubElement(root, "ModelStructure")
    attributes = {"name": "time", "valueReference": str(time), "causality": "independent", "variability": "continuous"}
    SubElement(listed, "Float64", attributes | {"description": "time", "declaredType": "Time"})
    for array in gathered:
        _add_variable(listed, array)
    numbers = {array.name: array.reference for array in gathered}
    outputs = [array for array in gathered if array.variable.causality == "output"]
    for array in outputs:
        SubElement(structure, "Output", valueReference=str(array.reference), dependencies="")
    for array in outputs:
        follows = initial_dependencies(build, array.name, numbers)
        SubElement(structure, "InitialUnknown", follows, valueReference=str(array.reference))
    return root


def build_description(build: Build, fmi: int) -> Element:
    """sources/buildDescription.xml, which ``fmpy compile`` and other tools need."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    files = SubElement(
        SubElement(root, "BuildConfiguration", modelIdentifier=build.name), "SourceFileSet", language="C99"
    )
    for name in build.sources:
        SubElement(files, "SourceFile", name=name)
    if fmi == 3:  # the binary's functions have no prefix; those of FMI 2.0 have none anyway
        SubElement(files, "PreprocessorDefinition", name="FMI3_OVERRIDE_FUNCTION_PREFIX", value="1")
    return root


def _choice(name: str) -> str:
    """Key of CHOICES."""
    return ".".join(name.split(".")[-2:])


def _add_enumeration(types: Element, key: str) -> None:
    enumeration = SubElement(types, "EnumerationType", name=_ENUMERATIONS[key])
    for code, (word, meaning) in enumerate(CHOICES[key].items()):
        SubElement(enumeration, "Item", name=word, value=str(code), description=meaning)


def _add_variable(parent: Element, array: Array) -> None:
    v = array.variable
    attributes = {"name": array.name, "valueReference": str(array.reference), **common_attributes(v)}
    kind = _KINDS[v.kind]
    if not choices_of(v.name):
        attributes |= type_attributes(v)
    else:
        kind = "Enumeration"
        attributes["declaredType"] = _ENUMERATIONS[_choice(v.name)]
    if v.start is not None:
        attributes["start"] = " ".join(
            str(start).lower() if v.kind == "Boolean" else str(start) for start in array.starts
        )
    node = SubElement(parent, kind, attributes)
    if array.length > 1:
        SubElement(node, "Dimension", start=str(array.length))
