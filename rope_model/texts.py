"""Escaping of external texts (files, flags, file names) for C, CSV, XML, HTML, TOML and terminals.

Each language has one function here, which every text that is not a constant of ours passes on its
way into a file.
"""

import html
import json
import re
import unicodedata

#: characters that XML 1.0 cannot contain, not even as a reference
_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
#: characters that a C literal contains unescaped: no backslash, quotation mark or trigraph
_PLAIN_C = frozenset(map(chr, range(0x20, 0x7F))) - frozenset('"\\?')
#: start of a cell that a spreadsheet takes for a formula; some ignore blanks before it
_FORMULA = re.compile(r"\s*[=+\-@]|\t")
REPLACEMENT = "\ufffd"


def c_string(text: str) -> str:
    """Return a C literal, quotation marks included, that holds the text in UTF-8."""
    # three octal digits end by themselves, whatever follows
    coded = (
        c if c in _PLAIN_C else r"\?" if c == "?" else "".join(f"\\{b:03o}" for b in _utf8(c))
        for c in text
    )
    return '"' + "".join(coded) + '"'


def csv_cell(value: object) -> object:
    """Return a cell of a CSV table; a text that a spreadsheet would compute gets an apostrophe, numbers stay."""
    if not isinstance(value, str):
        return value
    text = value.replace("\r", " ")  # pandas does not quote it, and it would begin a line
    if _FORMULA.match(text) and not _is_number(text):
        return f"'{text}"
    return text


def xml_text(text: str) -> str:
    """Return the text without characters that XML cannot contain; the library that writes it escapes the rest."""
    return _NO_XML.sub(REPLACEMENT, text)


def html_text(text: str) -> str:
    """Return the text as HTML, for elements and for attributes in quotation marks."""
    return html.escape(xml_text(text))


def toml_string(text: str) -> str:
    """Return a basic string of TOML, quotation marks included."""
    # JSON's strings are TOML's, but for surrogates and the character DEL
    return json.dumps(_utf8(text).decode(), ensure_ascii=False).replace("\x7f", "\\u007f")


def printable(text: str) -> str:
    """Return the text on one line, for a terminal, a title or a comment."""
    return "".join(
        c if c.isprintable() or unicodedata.category(c) == "Zs" else REPLACEMENT for c in text
    )


def _utf8(text: str) -> bytes:
    """Return the bytes of the text, with replacements for lone surrogates, which file names may contain."""
    return re.sub("[\ud800-\udfff]", REPLACEMENT, text).encode()


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
