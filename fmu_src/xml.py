"""XML documents as trees of nodes."""

from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from rope_model.texts import xml_text


def node(tag: str, /, *children: Element, **attributes: object) -> Element:
    """Return an element; attributes that are None are left out."""
    present = {name: value for name, value in attributes.items() if value is not None}
    element = Element(tag, {name: attribute_text(value) for name, value in present.items()})
    element.extend(children)
    return element


def attribute_text(value: object) -> str:
    """Return a value as the text of an attribute, with XML's spelling of truth values."""
    if isinstance(value, bool):
        return str(value).lower()
    return str(value)


def xml_bytes(root: Element) -> bytes:
    """Return the document, indented; its texts may come from anywhere."""
    for element in root.iter():
        element.attrib.update({name: xml_text(value) for name, value in element.attrib.items()})
    ElementTree.indent(root)
    text: str = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()
