"""A system of FMUs as an SSP archive (System Structure and Parameterization 1.0, ssp-standard.org).

An output and an input of the same name in two different FMUs are connected. So are two of which one has the other's
name behind that of the other's component, as the input `lively.left.fy_mean` and `left.fy_mean` of `lively`, or the
output `lively.left.x` and its `left.x`, which then listens to no other. The FMUs themselves answer for their files:
their model descriptions are read, nothing else.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from fmu_src.archive import write_archive
from fmu_src.attachments import xml_bytes

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"
OMS = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
_KINDS = {float: "Real", int: "Integer", bool: "Boolean", str: "String"}
#: types of FMI 3.0 in the words of SSP 1.0
_TYPES3 = {
    "Float64": "Real",
    "Int32": "Integer",
    "Boolean": "Boolean",
    "String": "String",
    "Enumeration": "Enumeration",
}


@dataclass(frozen=True)
class Component:
    """An FMU of the system, and values for its parameters."""

    name: str
    fmu: Path
    parameters: Mapping[str, float | int | bool | str]


@dataclass(frozen=True)
class _Port:
    """A variable that is connected, with its unit ('' for none)."""

    component: str
    name: str
    kind: str  # Real, Integer, Boolean
    causality: str
    unit: str


def export_ssp(
    destination: Path, name: str, components: Sequence[Component], stop: float, step: float, description: str = ""
) -> Path:
    """Write the system with its FMUs; stop time and communication step in s. Same FMUs, same bytes.

    The step is an annotation, one that libcosim reads and one that OMSimulator asks for; SSP 1.0 itself has no place
    for it, and knows the types of FMI 3.0 by the names of FMI 2.0.
    """
    described = {c.name: _read(c) for c in components}
    root = Element("ssd:SystemStructureDescription", {"version": "1.0", "name": name})
    for prefix, uri in (("ssd", SSD), ("ssc", SSC), ("ssv", SSV), ("osp", OSP), ("oms", OMS)):
        root.set(f"xmlns:{prefix}", uri)
    root.set("generationTool", "balance-rope")
    system = SubElement(root, "ssd:System", {"name": name, "description": description})
    ports = [port for c in components for port in _ports(c.name, described[c.name])]
    pairs = _pairs(ports)
    connected = {port for pair in pairs for port in pair}
    elements = SubElement(system, "ssd:Elements")
    for component in components:
        _add_component(elements, component, [p for p in ports if p.component == component.name and p in connected])
    connections = SubElement(system, "ssd:Connections")
    for start, end in pairs:
        SubElement(
            connections,
            "ssd:Connection",
            startElement=start.component,
            startConnector=start.name,
            endElement=end.component,
            endConnector=end.name,
        )
    _add_master(system, step)
    _add_units(root, described.values(), {port.unit for port in connected} - {""})
    _add_experiment(root, stop, step)
    files = {"SystemStructure.ssd": xml_bytes(root)}
    files |= {f"resources/{c.name}.fmu": c.fmu.read_bytes() for c in components}
    write_archive(destination, files)
    return destination


def _read(component: Component) -> Element:
    """The model description; ValueError for another FMI version and for parameters that there are not."""
    with zipfile.ZipFile(component.fmu) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    version = root.get("fmiVersion")
    if version not in ("2.0", "3.0"):
        raise ValueError(
            f"FMU '{component.fmu}' has fmiVersion = {version}, but must have 2.0 or 3.0: export one of these"
        )
    known = {v.get("name") for v in _variables(root) if v.get("causality") in ("parameter", "input")}
    if unknown := sorted(set(component.parameters) - known):
        raise ValueError(f"{component.name} has no parameter {', '.join(unknown)}: see its documentation for the names")
    return root


def _variables(description: Element) -> list[Element]:
    return list(description.find("ModelVariables") or ())


def _ports(component: str, description: Element) -> list[_Port]:
    ports = []
    for variable in _variables(description):
        name, causality = str(variable.get("name")), str(variable.get("causality"))
        kind = variable[0] if variable.tag == "ScalarVariable" else variable
        if causality in ("input", "output"):
            ports.append(_Port(component, name, _TYPES3.get(kind.tag, kind.tag), causality, kind.get("unit", "")))
    return ports


def _pairs(ports: Sequence[_Port]) -> list[tuple[_Port, _Port]]:
    """Output and input of one name in two components; one with the other's component before its name goes first."""
    pairs = []
    for end in (port for port in ports if port.causality == "input"):
        others = [p for p in ports if p.causality == "output" and p.component != end.component]
        own = [p for p in others if f"{p.component}.{p.name}" == end.name or f"{end.component}.{end.name}" == p.name]
        pairs += [(start, end) for start in own or others if own or start.name == end.name]
    for start, end in pairs:
        if (start.kind, start.unit) != (end.kind, end.unit):
            raise ValueError(
                f"{start.component}.{start.name} is {start.kind} in {start.unit!r}, but {end.component}.{end.name} is "
                f"{end.kind} in {end.unit!r}: rename one of them"
            )
    return pairs


def _add_component(parent: Element, component: Component, ports: Sequence[_Port]) -> None:
    node = SubElement(
        parent,
        "ssd:Component",
        name=component.name,
        type="application/x-fmu-sharedlibrary",
        source=f"resources/{component.name}.fmu",
        implementation="CoSimulation",
    )
    connectors = SubElement(node, "ssd:Connectors")
    for port in ports:
        connector = SubElement(connectors, "ssd:Connector", name=port.name, kind=port.causality)
        SubElement(connector, f"ssc:{port.kind}", {"unit": port.unit} if port.unit else {})
    if not component.parameters:
        return
    binding = SubElement(SubElement(node, "ssd:ParameterBindings"), "ssd:ParameterBinding")
    values = SubElement(binding, "ssd:ParameterValues")
    # the name by which ecos and libcosim apply a set
    parameter_set = SubElement(values, "ssv:ParameterSet", {"version": "1.0", "name": "initialValues"})
    parameters = SubElement(parameter_set, "ssv:Parameters")
    for name, value in component.parameters.items():
        text = str(value).lower() if isinstance(value, bool) else str(value)
        SubElement(SubElement(parameters, "ssv:Parameter", name=name), f"ssv:{_KINDS[type(value)]}", value=text)


def _add_master(system: Element, step: float) -> None:
    """The fixed-step master without which OMSimulator does not open a system; it steps all FMUs at once."""
    annotation = SubElement(SubElement(system, "ssd:Annotations"), "ssc:Annotation", type="org.openmodelica")
    information = SubElement(SubElement(annotation, "oms:Annotations"), "oms:SimulationInformation")
    SubElement(
        information,
        "oms:FixedStepMaster",
        description="oms-ma",
        stepSize=repr(step),
        absoluteTolerance="1e-4",
        relativeTolerance="1e-4",
    )


def _add_units(root: Element, descriptions: Iterable[Element], used: set[str]) -> None:
    """Definitions of the units that the connectors name, from the model descriptions."""
    units: dict[str, dict[str, str]] = {}
    for description in descriptions:
        for unit in description.iter("Unit"):
            base = unit.find("BaseUnit")
            if unit.get("name") in used and base is not None:
                units[str(unit.get("name"))] = dict(base.attrib)
    node = SubElement(root, "ssd:Units")
    for name in sorted(units):
        SubElement(SubElement(node, "ssc:Unit", name=name), "ssc:BaseUnit", units[name])


def _add_experiment(root: Element, stop: float, step: float) -> None:
    experiment = SubElement(root, "ssd:DefaultExperiment", startTime="0.0", stopTime=repr(stop))
    annotations = SubElement(experiment, "ssd:Annotations")
    annotation = SubElement(annotations, "ssc:Annotation", type="com.opensimulationplatform")
    SubElement(SubElement(annotation, "osp:Algorithm"), "osp:FixedStepAlgorithm", baseStepSize=repr(step))
