"""Files of an FMU besides description and code.

These are documentation, licences, icons, terminals and reference results.
"""

import importlib.metadata
from collections.abc import Collection
from pathlib import Path
from xml.etree.ElementTree import Element

from fmu_src.documentation import index_html
from fmu_src.interface import Variable
from fmu_src.model_description import MODEL
from fmu_src.reference_run import reference_files
from fmu_src.xml import node, xml_bytes
from rope_model.cases import RopeCase

_HERE = Path(__file__).resolve().parent
#: position of each terminal on the icon (0 ... 200, y up): where the rope meets the conveyance
_POSITIONS = {"left": (60.0, 104.0), "right": (140.0, 144.0)}
_FORCE = ("fx", "fy", "fz", "mx", "my", "mz")
_DEPENDENCIES = """\
This FMU runs Python code: the importing process must be, or be able to load, a CPython 3.11 or newer in which the
packages numpy, scipy and casadi (3.8.2 or newer) can be imported.  In a process that is not Python the FMU's library
loads libpython3.x (python3.dll on Windows), which the dynamic linker must find, and PYTHONPATH must name the folder of
the packages; of several Pythons, preload the right one.

The rope is the published system in plain Python, to be read and changed.  The native flavour of this FMU is the
complete model, is some 25 times as fast and has no such needs: balance-rope export.
"""


def attachments(
    described: Collection[Variable], case: RopeCase, fmi: int, native: bool
) -> dict[str, bytes]:
    """Return the contents of the files by path in the FMU."""
    files = {"documentation/index.html": index_html(described, native).encode(), **licenses()}
    if fmi == 3:
        files["terminalsAndIcons/terminalsAndIcons.xml"] = xml_bytes(terminals_and_icons(described))
        for name in ("icon.png", "icon.svg", "end.png", "end.svg"):
            files[f"terminalsAndIcons/{name}"] = (_HERE / "pictures" / name).read_bytes()
    else:
        # FMI 2.0.4 takes the terminals of FMI 3.0 as they are, and FMI Library refuses their
        # other fmiVersion
        files["model.png"] = (_HERE / "pictures" / "icon.png").read_bytes()
    if not native:
        files["documentation/licenses/pythonfmu.txt"] = license_text("pythonfmu").encode()
        files["documentation/externalDependencies.txt"] = _DEPENDENCIES.encode()
    return files | reference_files(case, MODEL, [v.name for v in described], native=native)


def licenses() -> dict[str, bytes]:
    """Return the licences of this project and of the FMI headers by path in the FMU."""
    headers = (_HERE / "pages" / "fmi-headers.txt").read_bytes()
    return {
        "documentation/licenses/license.txt": license_text().encode(),
        "documentation/licenses/fmi-headers.txt": headers,
    }


def license_text(package: str = "balance-rope") -> str:
    """Return a package's licence, as installed.

    A checkout's egg-info has no copy, another distribution of the package may have one.
    """
    for distribution in importlib.metadata.distributions(name=package):
        text = distribution.read_text("licenses/LICENSE")
        if text:
            return text
    raise RuntimeError(
        f"the licence is missing from the installed package {package}; install it anew"
    )


def terminals_and_icons(described: Collection[Variable]) -> Element:
    """Return terminalsAndIcons.xml of FMI 3.0: a terminal at each end of the rope.

    Its members are motion and force of the end. The members of a terminal have the names of the
    variables without the side.
    """
    corners = {"x1": "0", "y1": "0", "x2": "200", "y2": "200"}
    picture = node(
        "GraphicalRepresentation",
        node("CoordinateSystem", **corners, suggestedScalingFactorTo_mm="0.1"),
        node("Icon", **corners),
    )
    terminals = node("Terminals", *(_terminal(side, described) for side in _POSITIONS))
    return node("fmiTerminalsAndIcons", picture, terminals, fmiVersion="3.0")


def _terminal(side: str, described: Collection[Variable]) -> Element:
    x, y = _POSITIONS[side]
    members = []
    for variable in described:
        group, _, member = variable.name.rpartition(".")
        if group == side and (variable.causality == "input" or member in _FORCE):
            members.append(
                node(
                    "TerminalMemberVariable",
                    variableName=variable.name,
                    memberName=member,
                    variableKind="signal",
                )
            )
    picture = node(
        "TerminalGraphicalRepresentation",
        defaultConnectionColor="181 101 29",
        defaultConnectionStrokeSize="2",
        x1=f"{x - 8:g}",
        y1=f"{y - 8:g}",
        x2=f"{x + 8:g}",
        y2=f"{y + 8:g}",
        iconBaseName="end",
    )
    description = (
        f"the {side} suspension point: motion of the conveyance, force and moment of the rope on it"
    )
    return node(
        "Terminal", *members, picture, name=side, matchingRule="plug", description=description
    )
