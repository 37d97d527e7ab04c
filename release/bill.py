"""Bill of materials of a release, CycloneDX 1.6 as JSON: what is handed out, what is inside, and what it needs.

Inside are the FMI headers, whose licence asks to be named, and what the compiler links in.  The packages that the wheel
needs are named with their bounds, not with versions: pip chooses those where it installs.
"""

import hashlib
import importlib.metadata
import json
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path

from fmu_src.shell.build import PLATFORMS

ROOT = Path(__file__).resolve().parent.parent

_FMI = ("2.0.5", "3.0.2")


def bill_of_materials(files: Sequence[Path]) -> str:
    """The JSON text for the ``files`` of a release; without files that of what is inside a wheel."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    product = {
        "type": "library",
        "bom-ref": "balance-rope",
        "name": project["name"],
        "version": project["version"],
        "description": project["description"],
        "licenses": _license(project["license"]),
        "purl": f"pkg:pypi/{project['name']}@{project['version']}",
    }
    inside, needed = (
        [*_headers(), _compiler()],
        [_name_of(text) for text in project["dependencies"]],
    )
    optional = [
        _name_of(text) | {"scope": "optional"} for text in project["optional-dependencies"]["study"]
    ]
    parts = [*map(_file, sorted(files)), *inside, *needed, *optional]
    references = [str(part["bom-ref"]) for part in (*inside, *needed, *optional)]
    whole = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": product},
        "components": parts,
        "dependencies": [{"ref": "balance-rope", "dependsOn": references}],
    }
    return json.dumps(whole, indent=2) + "\n"


def sha256(path: Path) -> str:
    """Hexadecimal."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _license(name: str) -> list[dict[str, dict[str, str]]]:
    return [{"license": {"id": name}}]


def _file(path: Path) -> dict[str, object]:
    hashes = [{"alg": "SHA-256", "content": sha256(path)}]
    return {"type": "file", "bom-ref": f"file:{path.name}", "name": path.name, "hashes": hashes}


def _headers() -> list[dict[str, object]]:
    """FMI headers of the Modelica Association, in the sources of each FMU."""
    return [
        {
            "type": "library",
            "bom-ref": f"fmi-headers-{version[0]}",
            "name": f"FMI {version[0]} headers",
            "supplier": {"name": "Modelica Association"},
            "version": version,
            "licenses": _license("BSD-2-Clause"),
        }
        for version in _FMI
    ]


def _compiler() -> dict[str, object]:
    """Zig's own C runtime lies in the libraries; on Windows mingw-w64's start-up code, too."""
    version = importlib.metadata.version("ziglang")
    return {
        "type": "application",
        "bom-ref": "ziglang",
        "name": "ziglang",
        "version": version,
        "description": f"compiled the libraries for {', '.join(PLATFORMS)}; its run-time routines are linked in",
        "licenses": _license("MIT"),
        "purl": f"pkg:pypi/ziglang@{version}",
    }


def _name_of(requirement: str) -> dict[str, object]:
    name = re.match(r"[\w.-]+", requirement)
    assert name is not None, requirement
    bounds = {"name": "balance-rope:requirement", "value": requirement}
    return {
        "type": "library",
        "bom-ref": name[0],
        "name": name[0],
        "scope": "required",
        "purl": f"pkg:pypi/{name[0].lower()}",
        "properties": [bounds],
    }
