"""XML documents as trees of nodes."""

from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from rope_model.texts import xml_text


def node(tag: str, /, *children: Element, **attributes: object) -> Element:
    """Return an element; attributes that are None are left out, truth values are spelled as in XML."""
    element = Element(
        tag, {name: plain(value) for name, value in attributes.items() if value is not None}
    )
    element.extend(children)
    return element


def plain(value: object) -> str:
    """Return a value as the text of an attribute."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def xml_bytes(root: Element) -> bytes:
    """Return the document, indented; its texts may come from anywhere."""
    for element in root.iter():
        element.attrib.update({name: xml_text(value) for name, value in element.attrib.items()})
    ElementTree.indent(root)
    text: str = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()
