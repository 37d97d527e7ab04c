"""The source distribution, and the wheel with libraries for all platforms: python -m release.wheels [FOLDER].

In the wheel lies its bill of materials, where PEP 770 has it.

Built in a copy of the packages: a checkout has nothing prebuilt.  SOURCE_DATE_EPOCH, if it is not set, is the time of
the last commit, so that the same commit makes the same bytes.
"""

import base64
import hashlib
import importlib.metadata
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from release.bill import ROOT, bill_of_materials
from release.libraries import add_prebuilt

PACKAGES = ("rope_model", "fmu_src", "hoist_demo")
FILES = (
    "pyproject.toml",
    "README.md",
    "LICENSE",
    "CHANGELOG.md",
    "CITATION.cff",
)


def build(out: Path) -> list[Path]:
    """Source distribution and wheel, in ``out``."""
    installed = {one.name for one in importlib.metadata.distributions()}
    if missing := {"ziglang", "build"} - installed:
        raise RuntimeError(f"wheels need {' and '.join(sorted(missing))}: pip install -e '.[dev]'")
    with tempfile.TemporaryDirectory() as folder:
        stage, made = Path(folder) / "stage", Path(folder) / "made"
        for package in PACKAGES:
            shutil.copytree(
                ROOT / package,
                stage / package,
                ignore=shutil.ignore_patterns("__pycache__", "prebuilt"),
            )
        for name in FILES:
            shutil.copyfile(ROOT / name, stage / name)
        _build("sdist", stage, made)
        add_prebuilt(stage)
        _build("wheel", stage, made)
        add_bill(next(made.glob("*.whl")))
        out.mkdir(parents=True, exist_ok=True)
        return [Path(shutil.copy2(path, out)) for path in sorted(made.iterdir())]


def _build(kind: str, stage: Path, out: Path) -> None:
    command = [sys.executable, "-m", "build", f"--{kind}", "--outdir", str(out), str(stage)]
    # not in this folder: its build/ would be taken for the module
    done = subprocess.run(
        command, cwd=stage, env=_commit_time(), capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(
            f"the {kind} cannot be built:\n{done.stdout[-3000:]}{done.stderr[-3000:]}"
        )


def add_bill(wheel: Path) -> None:
    """The bill of materials into ``wheel``, and into its RECORD."""
    with zipfile.ZipFile(wheel) as old:
        entries = [(info, old.read(info)) for info in old.infolist()]
    record = next(info for info, _ in entries if info.filename.endswith(".dist-info/RECORD"))
    data = bill_of_materials([]).encode()
    name = f"{record.filename.removesuffix('/RECORD')}/sboms/balance-rope.cdx.json"
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as new:
        for info, content in entries:
            if info is record:
                new.writestr(zipfile.ZipInfo(name, info.date_time), data)
                content += f"{name},sha256={digest},{len(data)}\n".encode()
            new.writestr(info, content)


def _commit_time() -> dict[str, str]:
    command = ["git", "log", "-1", "--format=%ct"]
    committed = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=False
    ).stdout.strip()
    return ({"SOURCE_DATE_EPOCH": committed} if committed else {}) | os.environ


if __name__ == "__main__":
    for path in build(Path(sys.argv[1] if len(sys.argv) > 1 else "dist")):
        print(f"{path}  {path.stat().st_size / 1e6:.2f} MB")
