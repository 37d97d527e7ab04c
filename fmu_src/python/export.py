"""Export of the FMU of the Python flavour, as ``balance-rope export`` does.

The rope is rope_model.reference, the published system.  pythonfmu's builder makes the FMU: it gets the model
description from the class in slave.py and packs the resources, which are copies of what slave.py imports of rope_model
and fmu_src (own_modules.py).  Its library is replaced, because it answers all calls but doStep with OK even if they
fail, and cannot do otherwise.  Ours is that of fmu_src/shell, with Python behind it (python_model.c).  The
importing host needs Python with numpy, scipy and casadi, and nothing else.
"""

import hashlib
import importlib.metadata
import json
import os
import sys
import tempfile
import time
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path

from pythonfmu.builder import FmuBuilder

from fmu_src.archive import read_archive, write_archive
from fmu_src.attachments import attachments
from fmu_src.interface import NO_CHANGES, Variable, case_with, variables
from fmu_src.model_description import MODEL
from fmu_src.profile import Profile
from fmu_src.python import own_modules
from fmu_src.python.flavour import of_python, require_for_python
from fmu_src.python.own_modules import ROOT, import_from, modules_needed
from fmu_src.shell.build import choose_platforms
from fmu_src.shell.sources import model_sources, texts
from fmu_src.shell.start import Start, binaries_with
from fmu_src.shell.table import start_values
from rope_model.cases import Level
from rope_model.scene_names import Value

_SLAVE = Path(__file__).with_name("slave.py").resolve()
#: implements model.h with Python behind it
_MODEL = Path(__file__).with_name("python_model.c")
#: package of the builder, which adds a copy of it to the FMU
_BUILDER = "pythonfmu"


def export_fmu(
    destination: Path,
    case: str = "rope-120",
    level: Level = "standard",
    start: Mapping[str, Value] = NO_CHANGES,
    profile: Profile = Profile(),  # noqa: B008  it is frozen
    platforms: Sequence[str] | None = None,
) -> Path:
    """Write the FMU with the start values of ``case``, at a level of accuracy and with ``start``.

    The folder is made if needed.  ``platforms`` are names of FMI 3.0, by default all that can be built here.  Two
    exports of the same sources give the same bytes if SOURCE_DATE_EPOCH is set.

    Raises
    ------
    ValueError
        If the rope is more than the published system, which this flavour knows alone.
    """
    chosen = choose_platforms(platforms)
    data = case_with(case, level, start)
    require_for_python(data.scene)
    table = variables(data)
    library = library_sources(table)
    key = _build_key(f"{case} {level} {sorted(start.items())} {profile}", library)
    facts = _build_facts(case, level, key)
    settings = {"start": dict(start), "outputs": profile.outputs, "stop": profile.stop}
    files = _python_files(key, {**facts, **settings})
    files |= binaries_with(
        Start(facts["guid"], start_values(table, fmi=2)),
        library,
        name=MODEL,
        fmi=2,
        platforms=chosen,
    )
    described = of_python(profile.select(table)).values()
    write_archive(destination, files | attachments(described, data, fmi=2, native=False))
    return destination


def _python_files(key: str, build: Mapping[str, object]) -> dict[str, bytes]:
    """Return the files of pythonfmu's FMU without its libraries: model description and resources.

    ``build`` are the facts that slave.py reads from build.json.
    """
    with tempfile.TemporaryDirectory(prefix="balance_rope_") as folder:
        stage = Path(folder)
        package = stage / f"balance_rope_{key}"
        script = stage / f"balance_rope_slave_{key}.py"
        facts = stage / "build.json"
        _copy_modules(package)
        slave = import_from(package.name, _SLAVE.read_text(encoding="utf-8"))
        script.write_text(slave, encoding="utf-8")
        facts.write_text(json.dumps(build, indent=1), encoding="utf-8")
        draft = stage / "out" / "draft.fmu"
        draft.parent.mkdir()
        FmuBuilder.build_FMU(script, draft, [package, facts], documentation_folder=None)
        _unload(stage, package.name, script.stem)
        packed = read_archive(draft)
    files = {name: code for name, code in packed.items() if not name.startswith("binaries/")}
    return _with_package_builder(files, package.name, f"resources/{script.name}")


def library_sources(table: Sequence[Variable]) -> dict[str, str]:
    """Return the C files of the library without start.c."""
    return model_sources(table, texts([_MODEL]), fmi=2)


def _build_facts(case: str, level: Level, key: str) -> dict[str, str]:
    stamp = time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", time.time())))
    return {
        "case": case,
        "level": level,
        "guid": str(uuid.uuid5(uuid.NAMESPACE_OID, f"balance-rope {key}")),
        "version": _version(),
        "tool": f"balance-rope {_version()}, PythonFMU {importlib.metadata.version('pythonfmu')}",
        "date": time.strftime("%Y-%m-%dT%H:%M:%SZ", stamp),
    }


def _build_key(start_values: str, library: Mapping[str, str]) -> str:
    """Return the hash of everything that determines the behaviour of the FMU."""
    digest = hashlib.sha256(start_values.encode())
    for name in ("balance-rope", "casadi", "numpy", "scipy", _BUILDER):
        digest.update(f"{name} {importlib.metadata.version(name)}\n".encode())
    for path in sorted(_sources()):
        digest.update(path.name.encode() + path.read_bytes())
    for name, text in sorted(library.items()):
        digest.update(f"{name}{text}".encode())
    return digest.hexdigest()[:12]


def _sources() -> list[Path]:
    """Return the files that determine the Python code of the FMU, this module among them."""
    return [*modules_needed(_SLAVE), _SLAVE, Path(__file__), Path(own_modules.__file__)]


def _version() -> str:
    return importlib.metadata.version("balance-rope")


def _copy_modules(package: Path) -> None:
    """Copy the modules that the slave imports into ``package``."""
    for path in modules_needed(_SLAVE):
        copy = package / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_text(
            import_from(package.name, path.read_text(encoding="utf-8")), encoding="utf-8"
        )
    (package / "__init__.py").write_text("", encoding="utf-8")
    # the metadata where the FMU runs are those of another version, or there are none
    version = (
        f'"""Version of the project that exported this FMU."""\n\n__version__ = {_version()!r}\n'
    )
    (package / "rope_model" / "version.py").write_text(version, encoding="utf-8")


def _unload(stage: Path, *modules: str) -> None:
    """Remove the folder that the builder puts on the path, and the modules loaded from it."""
    sys.path.remove(str(stage))
    for name in [name for name in sys.modules if name.partition(".")[0] in modules]:
        del sys.modules[name]


def _with_package_builder(
    files: Mapping[str, bytes], package: str, script: str
) -> dict[str, bytes]:
    """Return the files of the FMU with the copy of pythonfmu in ``package``.

    The ``script`` imports it from there.
    """
    shared = f"resources/{_BUILDER}/"
    in_package = f"resources/{package}/{_BUILDER}/"
    moved: dict[str, bytes] = {}
    for name, content in files.items():
        if name.startswith(shared):
            name = in_package + name.removeprefix(shared)
        moved[name] = content
    text = import_from(package, files[script].decode(), (_BUILDER,))
    return moved | {script: text.encode()}
