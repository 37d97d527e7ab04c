"""SSP archives: systems of FMUs in System Structure and Parameterization 1.0 or 2.0.

The standard is at ssp-standard.org.

An output and an input of the same name in two different FMUs are connected.  So are two if one has
the other's name behind the name of the other's component, such as the input ``lively.left.fy_mean``
and ``left.fy_mean`` of ``lively``, or the output ``lively.left.x`` and its ``left.x``, which then
listens to no other.  Only the model descriptions of the FMUs are read.
"""

import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Literal, NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from fmu_src.archive import write_archive
from fmu_src.xml import node, xml_bytes

NAMESPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
}
Version = Literal["1.0", "2.0"]
#: namespaces of SSP Traceability 1.1, for the statuses of the data
_TRACEABILITY = {
    "srmd": "http://ssp-standard.org/SSPTraceability1/SimulationResourceMetaData",
    "stc": "http://ssp-standard.org/SSPTraceability1/SSPTraceabilityCommon",
}
_STATUSES = "resources/data.srmd"
_KINDS = {float: "Real", int: "Integer", bool: "Boolean", str: "String"}
#: types of FMI 3.0 in the words of SSP 1.0, if they differ
_TYPES3 = {"Float64": "Real", "Int32": "Integer"}


@dataclass(frozen=True)
class Component:
    """FMU of the system, and values for its parameters."""

    name: str
    fmu: Path
    parameters: Mapping[str, float | int | bool | str]


class SystemNumber(NamedTuple):
    """Number on which the system depends, and its status: assumed, published, measured ..."""

    name: str
    value: object
    unit: str
    status: str


@dataclass(frozen=True)
class _Port:
    """Connected variable, with its unit ('' for none)."""

    component: str
    name: str
    kind: str  # Real, Float64, Integer, Int32, Boolean
    causality: str
    unit: str


@dataclass(frozen=True)
class System:
    """The system as a whole."""

    name: str
    stop: float  # s
    step: float  # s, of the communication
    description: str = ""
    version: Version = "1.0"  # of SSP
    data: Sequence[SystemNumber] = ()


def export_ssp(destination: Path, components: Sequence[Component], system: System) -> Path:
    """Write the system with its FMUs.

    The same FMUs give the same bytes.  SSP 1.0 knows the types of FMI 3.0 by the names of FMI 2.0,
    and does not name the file with the status of the data.
    """
    described = {c.name: _read(c) for c in components}
    types = _TYPES3 if system.version == "1.0" else {}
    ports: list[_Port] = []
    for component in components:
        ports += _ports(component.name, described[component.name], types)
    units = {port.unit for port in _connected(ports)} - {""}
    root = node(
        "ssd:SystemStructureDescription",
        _system(system, components, ports),
        node("ssd:Units", *_units(described.values(), units)),
        _default_experiment(system),
        *_meta_data(system),
        version=system.version,
        name=system.name,
        **{f"xmlns:{prefix}": uri for prefix, uri in NAMESPACES.items()},
        generationTool="balance-rope",
    )
    files = {"SystemStructure.ssd": xml_bytes(root)}
    files |= {f"resources/{c.name}.fmu": c.fmu.read_bytes() for c in components}
    if system.data:
        files[_STATUSES] = xml_bytes(_statuses(system.name, system.data))
    write_archive(destination, files)
    return destination


def _connected(ports: Sequence[_Port]) -> set[_Port]:
    return set(chain.from_iterable(_pairs(ports)))


def _system(system: System, components: Sequence[Component], ports: Sequence[_Port]) -> Element:
    """Return the components with their connections, and the step for OMSimulator."""
    connected = _connected(ports)
    nodes = []
    for component in components:
        of_component = [p for p in ports if p.component == component.name and p in connected]
        nodes.append(_component(component, of_component, system.version))
    connections = (
        node(
            "ssd:Connection",
            startElement=start.component,
            startConnector=start.name,
            endElement=end.component,
            endConnector=end.name,
        )
        for start, end in _pairs(ports)
    )
    # OMSimulator opens a system only with a fixed-step master, which steps all FMUs at once
    master = node(
        "oms:FixedStepMaster",
        description="oms-ma",
        stepSize=repr(system.step),
        absoluteTolerance="1e-4",
        relativeTolerance="1e-4",
    )
    return node(
        "ssd:System",
        node("ssd:Elements", *nodes),
        node("ssd:Connections", *connections),
        _annotations(
            "org.openmodelica", node("oms:Annotations", node("oms:SimulationInformation", master))
        ),
        name=system.name,
        description=system.description,
    )


def _default_experiment(system: System) -> Element:
    """Return stop time and step; SSP has no element for the step, and libcosim reads this one."""
    step = node("osp:FixedStepAlgorithm", baseStepSize=repr(system.step))
    algorithm = _annotations("com.opensimulationplatform", node("osp:Algorithm", step))
    return node("ssd:DefaultExperiment", algorithm, startTime="0.0", stopTime=repr(system.stop))


def _meta_data(system: System) -> list[Element]:
    """Return the reference to the file with the status of the data; SSP 1.0 has none."""
    if not system.data or system.version != "2.0":
        return []
    attributes = {
        "kind": "general",
        "type": "application/x-srmd-meta-data",
        "source": _STATUSES,
    }
    return [node("ssc:MetaData", **attributes)]


def _statuses(name: str, data: Sequence[SystemNumber]) -> Element:
    """Return the simulation resource meta data, with an entry for the status of each datum."""
    entries = []
    for datum in data:
        value_text = f"{datum.value} {datum.unit}".strip()
        entries.append(node("stc:ClassificationEntry", keyword=datum.name, description=value_text))
        entries[-1].text = datum.status
    return node(
        "srmd:SimulationResourceMetaData",
        node("stc:Classification", *entries, type="org.balance-rope.status"),
        version="1.1",
        name=name,
        **{f"xmlns:{prefix}": uri for prefix, uri in _TRACEABILITY.items()},
        generationTool="balance-rope",
    )


def _annotations(tool: str, content: Element) -> Element:
    return node("ssd:Annotations", node("ssc:Annotation", content, type=tool))


def _read(component: Component) -> Element:
    """Read the model description; ValueError for another FMI version and for unknown parameters."""
    with zipfile.ZipFile(component.fmu) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    fmi = root.get("fmiVersion")
    if fmi not in ("2.0", "3.0"):
        raise ValueError(
            f"FMU '{component.fmu}' has fmiVersion = {fmi}, but must have 2.0 or 3.0: "
            "export one of these"
        )
    known = {
        v.get("name") for v in _variables(root) if v.get("causality") in ("parameter", "input")
    }
    if unknown := sorted(set(component.parameters) - known):
        raise ValueError(
            f"{component.name} has no parameter {', '.join(unknown)}: "
            "see its documentation for the names"
        )
    return root


def _variables(description: Element) -> list[Element]:
    return description.findall("ModelVariables/*")


def _ports(component: str, description: Element, types: Mapping[str, str]) -> list[_Port]:
    ports = []
    for variable in _variables(description):
        causality = str(variable.get("causality"))
        if causality not in ("input", "output"):
            continue
        # FMI 2.0 has the type in an element of its own
        type_ = variable[0] if variable.tag == "ScalarVariable" else variable
        ports.append(
            _Port(
                component=component,
                name=str(variable.get("name")),
                kind=types.get(type_.tag, type_.tag),
                causality=causality,
                unit=type_.get("unit", ""),
            )
        )
    return ports


def _pairs(ports: Sequence[_Port]) -> list[tuple[_Port, _Port]]:
    """Return outputs and inputs to connect; one with the other component's name has precedence."""
    pairs = []
    outputs = [port for port in ports if port.causality == "output"]
    for end in (port for port in ports if port.causality == "input"):
        others = [port for port in outputs if port.component != end.component]
        addressed = [port for port in others if _is_addressed(port, end)]
        equal = [port for port in others if port.name == end.name]
        pairs += [(start, end) for start in addressed or equal]
    for start, end in pairs:
        if (start.kind, start.unit) != (end.kind, end.unit):
            raise ValueError(
                f"{start.component}.{start.name} is {start.kind} in {start.unit!r}, "
                f"but {end.component}.{end.name} is {end.kind} in {end.unit!r}: "
                "rename one of them"
            )
    return pairs


def _is_addressed(start: _Port, end: _Port) -> bool:
    """Return True if one of the names is the other behind the name of the other's component."""
    return f"{start.component}.{start.name}" == end.name or (
        f"{end.component}.{end.name}" == start.name
    )


def _component(component: Component, ports: Sequence[_Port], version: Version) -> Element:
    connectors = (
        node(
            "ssd:Connector",
            node(f"ssc:{port.kind}", unit=port.unit or None),
            name=port.name,
            kind=port.causality,
        )
        for port in ports
    )
    values = [
        node("ssv:Parameter", node(f"ssv:{_KINDS[type(value)]}", value=value), name=name)
        for name, value in component.parameters.items()
    ]
    bindings = []
    if values:
        # ecos and libcosim apply a set by this name
        parameters = node(
            "ssv:ParameterSet",
            node("ssv:Parameters", *values),
            version=version,
            name="initialValues",
        )
        binding = node("ssd:ParameterBinding", node("ssd:ParameterValues", parameters))
        bindings = [node("ssd:ParameterBindings", binding)]
    return node(
        "ssd:Component",
        node("ssd:Connectors", *connectors),
        *bindings,
        name=component.name,
        type="application/x-fmu-sharedlibrary",
        source=f"resources/{component.name}.fmu",
        implementation="CoSimulation",
    )


def _units(descriptions: Iterable[Element], used: set[str]) -> Iterator[Element]:
    """Yield definitions of the connectors' units, from the model descriptions."""
    units = chain.from_iterable(root.iter("Unit") for root in descriptions)
    bases = {str(unit.get("name")): unit.find("BaseUnit") for unit in units}
    for name in sorted(used):
        base = bases.get(name)
        if base is not None:
            yield node("ssc:Unit", node("ssc:BaseUnit", **base.attrib), name=name)
