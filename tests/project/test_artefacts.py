"""What is handed out, tried where it will live: ARTEFACTS by PLACES, in a Python with NEEDED alone.

The wheel is tried by release.trial, without a checkout and a compiler, in a folder with blanks and umlauts;
``make wheels`` and a slow test of test_public run that.
"""

import importlib.metadata
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import bare_host
import fmpy
import pytest
from bare_host import OURS
from browser import BROWSER, run
from checkout import ROOT
from exports import FLAVOURS
from packaging.requirements import Requirement
from systems import system

from release.trial import readme_steps
from rope_model.compiler import compile_library, find_compiler

HOST = Path(bare_host.__file__)
#: all that the importing environment of the Python FMU needs, and the host
NEEDED = ("numpy", "scipy", "casadi", "fmpy")

pytestmark = [
    pytest.mark.skipif(
        os.name != "posix", reason="links packages and takes rights away as POSIX does"
    ),
    pytest.mark.skipif("native-2" not in FLAVOURS, reason="needs a C compiler"),
]


@dataclass(frozen=True)
class Place:
    """Where an artefact is run; by default another folder, an empty home, no compiler, nothing of the project."""

    folder: str = "here"
    beside: bool = False  # another version of the project, whose import fails, is first on the path
    home: bool = True  # may be written
    writable: bool = True  # the folder in which the FMU is unpacked

    @property
    def restricted(self) -> bool:
        return not (self.home and self.writable)


STRANGE = "Förder maschine 50 % äß #2"
PLACES = {
    "bare": Place(),
    "beside another version": Place(beside=True),
    "home that cannot be written": Place(home=False),
    "read-only folder": Place(writable=False),
    "path with spaces and umlauts": Place(folder=STRANGE),
    "path with umlauts beside another version": Place(folder=STRANGE, beside=True),
}
#: places of ``make test``; all are tried by ``make test-slow``
QUICK = ("path with umlauts beside another version",)
EVERYWHERE = [pytest.param(name, marks=[pytest.mark.slow] * (name not in QUICK)) for name in PLACES]
#: kinds of exports.EXPORTS, which a place has unpacked; the system of two of them
ARTEFACTS = {
    "Python FMU": "python-lean",
    "native FMU of FMI 2.0": "native-2-lean",
    "native FMU of FMI 3.0": "native-3-least",
    "drive FMU of FMI 2.0": "drive-2",
    "drive FMU of FMI 3.0": "drive-3",
    "SSP": "system",
}


def bare_python(folder: Path) -> Path:
    """Return a Python that sees NEEDED, and what these need, linked by name; nothing of this project."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], check=True)
    python = folder / "bin" / "python"
    packages = next((folder / "lib").glob("python*")) / "site-packages"
    for name in _with_requirements(NEEDED):
        distribution = importlib.metadata.distribution(name)
        for top in {file.parts[0] for file in distribution.files or ()} - {"..", "__pycache__"}:
            if not (packages / top).exists():
                (packages / top).symlink_to(distribution.locate_file(top))
    return python


def _with_requirements(names: tuple[str, ...]) -> list[str]:
    """Return the names of the distributions and of all that these require, as far as they are installed."""
    found: list[str] = []
    waiting = [*names]
    while waiting:
        name = waiting.pop()
        try:
            required = importlib.metadata.requires(name) or ()
        except importlib.metadata.PackageNotFoundError:
            continue
        if name not in found:
            found.append(name)
            needs = [
                one
                for one in map(Requirement, required)
                if one.marker is None or one.marker.evaluate()
            ]
            waiting += [one.name for one in needs]
    return found


def other_version(folder: Path) -> Path:
    """Return a folder with another version of the project, of which nothing can be imported."""
    for name in OURS:
        (folder / name).mkdir(parents=True)
        (folder / name / "__init__.py").write_text(
            f"raise ImportError('{name} of another version')\n"
        )
    metadata = folder / "balance_rope-9.9.dist-info" / "METADATA"
    metadata.parent.mkdir()
    metadata.write_text("Metadata-Version: 2.1\nName: balance-rope\nVersion: 9.9\n")
    return folder


def without_rights() -> list[str]:
    """Return the command in front of one that may write only where its files say so; root may write everywhere."""
    if os.geteuid() != 0:
        return []
    if shutil.which("setpriv") is None:
        pytest.skip("root may write everywhere: needs setpriv")
    return ["setpriv", "--bounding-set=-all", "--inh-caps=-all"]


def read_only(folder: Path) -> None:
    for path in [*folder.rglob("*"), folder]:
        if path.is_dir():
            path.chmod(0o555)
        else:
            path.chmod(0o444)


@pytest.fixture(scope="module")
def tried(
    tmp_path_factory: pytest.TempPathFactory, fmu_of: Callable[[str], Path]
) -> Iterator[Callable[[str], Any]]:
    """What the host printed in a place, one process for all artefacts; and in this environment, as ''."""
    python = bare_python(tmp_path_factory.mktemp("bare") / "venv")
    packed = tmp_path_factory.mktemp("system")
    ssp = system(packed, fmu_of("native-2-lean"), fmu_of("drive-2"))
    made: list[Path] = []

    @cache
    def found(name: str) -> Any:
        if not name:
            paths = {}
            for one, kind in ARTEFACTS.items():
                if kind == "system":
                    paths[one] = ssp
                else:
                    paths[one] = fmu_of(kind)
            return _said([sys.executable, str(HOST)], paths, {**os.environ}, packed)
        place = PLACES[name]
        top = tmp_path_factory.mktemp("place") / place.folder
        made.append(top)
        work = top / "work"
        home = top / "home"
        scratch = top / "tmp"
        for folder in (work, home, scratch):
            folder.mkdir(parents=True)
        paths = {}
        for one, kind in ARTEFACTS.items():
            if kind == "system":
                paths[one] = Path(shutil.copy(ssp, top / f"{place.folder}.ssp"))
                continue
            paths[one] = top / one
            fmpy.extract(str(fmu_of(kind)), str(paths[one]))
        # packed, it is unpacked by the host, in a folder below TMPDIR
        paths["Python FMU, packed"] = Path(shutil.copy(fmu_of("python-lean"), top / "rope.fmu"))
        if not place.home:
            read_only(home)
        if not place.writable:
            for path in paths.values():
                read_only(path)
        environment = {"HOME": str(home), "TMPDIR": str(scratch), "PATH": "/nowhere"}
        if place.beside:
            environment["PYTHONPATH"] = str(other_version(top / "other"))
        command = [str(python), "-P", str(HOST)]
        if place.restricted:
            command = [str(shutil.which(word) or word) for word in without_rights()] + command
        said = _said(command, paths, environment, work)
        said["left behind"] = [
            str(path.relative_to(top)) for path in (*home.rglob("*"), *work.rglob("*"))
        ]
        return said

    yield found
    for top in made:  # what is read-only cannot be removed
        for path in top.rglob("*"):
            if path.is_dir():
                path.chmod(0o755)


def _said(
    command: list[str], paths: dict[str, Path], environment: dict[str, str], folder: Path
) -> Any:
    given: list[str] = []
    for name, path in paths.items():
        given += [name, str(path)]
    done = subprocess.run(
        [*command, *given],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-3000:]
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.parametrize("place", EVERYWHERE)
@pytest.mark.parametrize("artefact", ARTEFACTS)
def test_artefact_computes_the_same_wherever_it_lives(
    artefact: str, place: str, tried: Callable[[str], Any]
) -> None:
    expected = tried("")["results"][artefact]
    assert isinstance(expected, list), expected
    assert tried(place)["results"][artefact] == expected
    if artefact == "Python FMU":
        assert tried(place)["results"]["Python FMU, packed"] == expected


@pytest.mark.slow
def test_the_library_built_from_the_sources_of_an_fmu_computes_the_same(
    tried: Callable[[str], Any], fmu_of: Callable[[str], Path], tmp_path: Path
) -> None:
    folder = Path(fmpy.extract(str(fmu_of("native-2-lean")), str(tmp_path / STRANGE)))
    compiler = find_compiler()
    assert compiler is not None
    files = [
        path for path in (folder / "sources").rglob("*") if path.is_file()
    ]  # headers of FMI in a folder
    sources = {path.name: path.read_text(encoding="utf-8") for path in files}
    shared = (*compiler, "-DFMI2_OVERRIDE_FUNCTION_PREFIX")
    shutil.copy(
        compile_library(sources, shared, folder, "built"),
        next((folder / "binaries").rglob("BalanceRope.*")),
    )
    said = _said([sys.executable, str(HOST)], {"built": folder}, {**os.environ}, tmp_path)
    assert said["results"]["built"] == tried("")["results"]["native FMU of FMI 2.0"]


@pytest.mark.parametrize("place", EVERYWHERE)
def test_the_python_fmu_runs_its_own_code_alone(place: str, tried: Callable[[str], Any]) -> None:
    modules = tried(place)["modules"]
    packages = {name.partition(".")[0] for name in modules}
    assert len(packages) == 2, packages  # of the slave, and of what it imports
    assert all(re.fullmatch(r"balance_rope_(slave_)?[0-9a-f]{12}", name) for name in packages), (
        packages
    )
    assert len(modules) > 50
    (version,) = (
        version for name, version in modules.items() if name.endswith(".rope_model.version")
    )
    assert version == importlib.metadata.version("balance-rope")


@pytest.mark.parametrize("place", EVERYWHERE)
def test_an_artefact_leaves_nothing_behind(place: str, tried: Callable[[str], Any]) -> None:
    assert tried(place)["left behind"] == []


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="no Chromium found: apt-get install chromium")
@pytest.mark.parametrize("place", PLACES)
def test_the_report_draws_the_rope_wherever_it_lies(place: str, tmp_path: Path) -> None:
    folder = tmp_path / PLACES[place].folder
    folder.mkdir()
    page = run(folder)
    if not PLACES[place].writable:
        read_only(folder)
    command = [
        str(BROWSER),
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        f"--user-data-dir={tmp_path / 'profile'}",
    ]
    command += [
        "--enable-logging=stderr",
        "--virtual-time-budget=8000",
        "--dump-dom",
        page.as_uri(),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert 'data-bottom="' in done.stdout
    assert "CONSOLE" not in done.stderr


def test_the_trial_of_the_wheel_runs_each_line_of_the_readme() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    steps = [*readme_steps()]
    commands = [step.text.split()[0] for step in steps if step.program == "balance-rope"]
    assert commands == ["new", "show", "wind", "export", "export", "export"]
    assert len(commands) == len(re.findall(r"(?m)^\.venv/bin/balance-rope ", readme))
    assert len(steps) - len(commands) == readme.count("```python\n")


_NATIVE = "from rope_model import balance_rope, rope_120; assert balance_rope(rope_120().scene).form == 'native'"


@pytest.mark.slow
def test_a_rope_is_native_where_the_home_cannot_be_written(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    read_only(home)
    unset = ("BALANCE_ROPE_CACHE", "XDG_CACHE_HOME", "LOCALAPPDATA")
    environment = {name: value for name, value in os.environ.items() if name not in unset}
    environment |= {"HOME": str(home), "TMPDIR": str(tmp_path), "PYTHONPATH": str(ROOT)}
    command = [*without_rights(), sys.executable, "-P", "-c", _NATIVE]
    done = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
