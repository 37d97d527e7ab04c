"""Builds the FMU; ``balance-rope export`` on the command line.

The FMU holds copies of rope_model and fmu_src, the interpreted kernels for every platform and the compiled ones for
the exporting platform.  The importing host needs Python with numpy and casadi.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import os
import re
import sys
import tempfile
import time
import uuid
from collections.abc import Mapping
from pathlib import Path

from pythonfmu.builder import FmuBuilder

from rope_model.parameters import Level
from rope_model.simulation.mesh import partition, suited
from rope_model.simulation.rope_system import write_bundle

from .archive import read_archive, write_archive
from .attachments import attachments
from .interface import NO_CHANGES, Value, preset_with, variables
from .profile import Profile

SOURCES = ("rope_model", "fmu_src")
#: what the FMU needs not: parts of the export, and of the native flavour
_LEFT_OUT = {"export.py", "archive.py", "attachments.py", "documentation.py", "reference.py", "terminals.py"}
_LEFT_OUT |= {"arrays.py", "model_description3.py", "modal.py", "public.py", "native"}


def export_fmu(
    destination: Path,
    preset: str = "rope-120",
    level: Level = "standard",
    start: Mapping[str, Value] = NO_CHANGES,
    profile: Profile = Profile(),  # noqa: B008  it is frozen
) -> Path:
    """Write the FMU with the start values of ``preset``, at a level of accuracy and with ``start``, to ``destination``.

    The folder is made if needed.  Two exports of the same sources give the same bytes when SOURCE_DATE_EPOCH is set.
    """
    data = preset_with(preset, level, start)
    scene = data.scene
    described = profile.described(variables(data)).values()
    mesh = suited(scene.mesh, scene.rope, scene.layout)
    elements = partition(mesh, scene.rope.length, 0.5 * scene.rope.length).lengths.size
    with tempfile.TemporaryDirectory(prefix="balance_rope_") as folder:
        stage = Path(folder)
        kernels = stage / "kernels"
        write_bundle(elements, kernels)
        key = _build_key(f"{preset} {level} {sorted(start.items())} {profile}", kernels)
        package, script = stage / f"balance_rope_{key}", stage / f"balance_rope_slave_{key}.py"
        _copy_package(package)
        slave = (_root() / "fmu_src" / "slave.py").read_text(encoding="utf-8")
        slave = re.sub(r"(?m)^from (rope_model|fmu_src)", rf"from {package.name}.\1", slave)
        script.write_text(slave, encoding="utf-8")
        (stage / "build.json").write_text(
            json.dumps(
                _build_facts(preset, level, key)
                | {"start": dict(start), "outputs": profile.outputs, "stop": profile.stop},
                indent=1,
            ),
            encoding="utf-8",
        )
        draft = stage / "out" / "draft.fmu"
        draft.parent.mkdir()
        FmuBuilder.build_FMU(script, draft, [package, kernels, stage / "build.json"], documentation_folder=None)
        sys.path.remove(str(stage))  # the builder leaves it there
        write_archive(destination, read_archive(draft) | attachments(described, data, fmi=2, native=False))
    return destination


def _build_facts(preset: str, level: Level, key: str) -> dict[str, str]:
    stamp = time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", time.time())))
    return {
        "preset": preset,
        "level": level,
        "guid": str(uuid.uuid5(uuid.NAMESPACE_OID, f"balance-rope {key}")),
        "version": importlib.metadata.version("balance-rope"),
        "tool": f"balance-rope {importlib.metadata.version('balance-rope')}, "
        f"PythonFMU {importlib.metadata.version('pythonfmu')}",
        "date": time.strftime("%Y-%m-%dT%H:%M:%SZ", stamp),
    }


def _build_key(start_values: str, kernels: Path) -> str:
    """Hash of everything that decides how the FMU behaves."""
    digest = hashlib.sha256(start_values.encode())
    for name in ("casadi", "numpy", "pythonfmu"):
        digest.update(f"{name} {importlib.metadata.version(name)}\n".encode())
    for path in sorted([*_sources(), *kernels.iterdir()]):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:12]


def _root() -> Path:
    return Path(__file__).resolve().parent.parent


def _sources() -> list[Path]:
    files = [path for package in SOURCES for path in sorted((_root() / package).rglob("*.py"))]
    return [path for path in files if not _LEFT_OUT.intersection(path.relative_to(_root()).parts)]


def _copy_package(package: Path) -> None:
    """rope_model and fmu_src as subpackages of ``package``, their absolute imports made relative."""
    for path in _sources():
        copy = package / path.relative_to(_root())
        copy.parent.mkdir(parents=True, exist_ok=True)
        text = path.read_text(encoding="utf-8")
        if path.is_relative_to(_root() / "fmu_src"):
            text = re.sub(r"(?m)^from rope_model", "from ..rope_model", text)
        copy.write_text(text, encoding="utf-8")
    (package / "__init__.py").write_text("", encoding="utf-8")
