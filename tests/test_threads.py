"""Threads of a host that is not Python instantiate, initialise, step and free the rope at once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest
import threads

pytestmark = pytest.mark.skipif(threads.why_not() != "", reason=threads.why_not())


@pytest.mark.parametrize(("flavour", "runs"), [("python", 1), ("native-2", 5)])
def test_sixteen_threads_have_the_bits_of_one(
    flavour: str, runs: int, fmu_of: Callable[[str], Path], tmp_path: Path
) -> None:
    program, fmu = threads.build(tmp_path), fmu_of(flavour)
    unzipped = Path(fmpy.extract(str(fmu), str(tmp_path / "unzipped")))
    for _ in range(runs):
        done = threads.run(program, fmu, unzipped)
        assert done.returncode == 0, done.stdout + done.stderr[-3000:]
        assert done.stdout.startswith("16 threads, 40 numbers each, 0 differ")
