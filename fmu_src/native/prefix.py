"""Names of a source FMU's functions: all begin with the model identifier.

So no other object file has them.

FMI wants that of its own functions where an FMU is linked statically; the headers of the standard
see to it by a macro. The same is done here to all functions and tables that the C files share.
Several FMUs link into one program so.
"""

import re
from collections.abc import Mapping

HEADER = "prefix.h"
LONGEST_IDENTIFIER = 64  #: Characters; compilers tell names apart by at least as many.
_FUNCTION = re.compile(r"^(?!static\b|typedef\b)(?:\w+[ *]+)+(\w+)\(", re.MULTILINE)
_DATA = re.compile(r"^(?:extern )?const (?:\w+ )+(\w+)(?:\[[^\]]*\])*(?: =|;)", re.MULTILINE)
_MACRO = re.compile(r"^ *# *define (\w+)", re.MULTILINE)
_FMI = re.compile(r"fmi[23]\w+")

_TEXT = """\
/* Generated: the names that this FMU's object files share begin with its model identifier.

   So do the functions of FMI, unless FMI{fmi}_OVERRIDE_FUNCTION_PREFIX is defined, as it is for a shared library. */
#ifndef PREFIX_H
#define PREFIX_H

#ifndef FMI{fmi}_FUNCTION_PREFIX
#define FMI{fmi}_FUNCTION_PREFIX {identifier}_
#endif

/* of code that CasADi generates */
#define CODEGEN_PREFIX {identifier}_
#define CASADI_SYMBOL_EXPORT

{names}

#endif
"""


def checked_identifier(identifier: str) -> str:
    """Return a model identifier, which names a file and C functions; ValueError if it cannot."""
    if not (
        re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", identifier)
        and len(identifier) <= LONGEST_IDENTIFIER
    ):
        raise ValueError(
            f"the model identifier {identifier!r} must have letters, digits and _ only, not begin "
            f"with a digit, and be at most {LONGEST_IDENTIFIER} characters long: "
            "give a name such as MyRope"
        )
    return identifier


def with_prefix(sources: Mapping[str, str], identifier: str, fmi: int) -> dict[str, str]:
    """Return the sources with the identifier before their shared names.

    Each C file begins with a header that does it.
    """
    names = "\n".join(f"#define {name} {identifier}_{name}" for name in shared_names(sources))
    header = _TEXT.format(fmi=fmi, identifier=identifier, names=names)
    prefixed = dict(sources)
    for name, text in sources.items():
        if name.endswith(".c"):
            prefixed[name] = f'#include "{HEADER}"\n{text}'
    return prefixed | {HEADER: header}


def shared_names(sources: Mapping[str, str]) -> list[str]:
    """Return the functions and data with external linkage, but for those of FMI."""
    names: set[str] = set()
    macros: set[str] = set()
    for file_name, text in sources.items():
        if _FMI.fullmatch(file_name.removesuffix(".h")):
            continue
        names.update(_FUNCTION.findall(text), _DATA.findall(text))
        macros.update(_MACRO.findall(text))
    return sorted(name for name in names - macros if not _FMI.fullmatch(name))
