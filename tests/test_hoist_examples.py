"""The examples of docs/hoist.md run as they stand there."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from exports import FLAVOURS

from hoist_demo.recording.time_series import read_csv

ROOT = Path(__file__).parents[1]
EXAMPLES = re.findall(r"## Your own (\w+)\n.*?```python\n(.*?)```", (ROOT / "docs/hoist.md").read_text("utf-8"), re.S)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, fmu_of: Callable[[str], Path]) -> Path:
    if "native-2" not in FLAVOURS:
        pytest.skip("needs a C compiler")
    folder = tmp_path_factory.mktemp("examples")
    (folder / "build").mkdir()
    shutil.copyfile(fmu_of("native-2"), folder / "build" / "balance_rope.fmu")
    return folder


def told(folder: Path, name: str) -> dict[str, float]:
    """What the example's summary says, by quantity."""
    code = dict(EXAMPLES)[name]
    head = f"import sys; sys.path.insert(0, {str(ROOT)!r})\n"
    done = subprocess.run(
        [sys.executable, "-c", head + code], cwd=folder, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    found = re.findall(r"^  (.+?)  +(-?[\d.e+-]+)(?: .*)?$", done.stdout, re.M)
    return {quantity: float(value) for quantity, value in found}


def test_each_example_fits_on_a_screen() -> None:
    assert [name for name, _ in EXAMPLES] == ["controller", "hoist"]
    assert all(len(code.strip().splitlines()) <= 35 for _, code in EXAMPLES)


def test_a_controller_of_one_s_own_winds_and_ends_below_the_landing(folder: Path) -> None:
    said = told(folder, "controller")
    assert said["travel reached, left conveyance"] == pytest.approx(90.0, abs=0.2)
    # the law of the example has no position loop; the text says 0.14 m
    assert said["final position error"] == pytest.approx(140.0, abs=5.0)


def test_a_hoist_of_one_s_own_winds_with_its_rope_and_leaves_a_table(folder: Path) -> None:
    said = told(folder, "hoist")
    assert said["travel reached, left conveyance"] == pytest.approx(150.0, abs=0.01)
    recording = read_csv(folder / "signals.csv")
    # 185 m of 10 kg/m between ends 150 m apart: the right leg is 167.5 m long
    assert recording["right.fy"][0] == pytest.approx(-167.5 * 10.0 * 9.81, rel=0.01)
