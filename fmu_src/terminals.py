"""terminalsAndIcons.xml of FMI 3.0 (and 2.0.4): one terminal per end of the rope, with its motion and its force."""

from __future__ import annotations

from collections.abc import Collection
from xml.etree.ElementTree import Element, SubElement

from fmu_src.interface import Variable

#: place of each terminal on the icon (0 ... 200, y up): where the rope meets the conveyance
_PLACES = {"left": (60.0, 104.0), "right": (140.0, 144.0)}
_FORCE = ("fx", "fy", "fz", "mx", "my", "mz")


def terminals_and_icons(described: Collection[Variable]) -> Element:
    """The root element; the members of a terminal are named as the variables without the side."""
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = SubElement(root, "GraphicalRepresentation")
    corners = {"x1": "0", "y1": "0", "x2": "200", "y2": "200"}
    SubElement(picture, "CoordinateSystem", corners | {"suggestedScalingFactorTo_mm": "0.1"})
    SubElement(picture, "Icon", corners)
    terminals = SubElement(root, "Terminals")
    for side, (x, y) in _PLACES.items():
        terminal = SubElement(
            terminals,
            "Terminal",
            name=side,
            matchingRule="plug",
            description=f"the {side} suspension point: motion of the conveyance, force and moment of the rope on it",
        )
        for variable in described:
            group, _, member = variable.name.rpartition(".")
            if group == side and (variable.causality == "input" or member in _FORCE):
                SubElement(
                    terminal,
                    "TerminalMemberVariable",
                    variableName=variable.name,
                    memberName=member,
                    variableKind="signal",
                )
        SubElement(
            terminal,
            "TerminalGraphicalRepresentation",
            defaultConnectionColor="181 101 29",
            defaultConnectionStrokeSize="2",
            x1=f"{x - 8:g}",
            y1=f"{y - 8:g}",
            x2=f"{x + 8:g}",
            y2=f"{y + 8:g}",
            iconBaseName="end",
        )
    return root
