"""Threads of a host that is not Python instantiate, initialise, step and free the rope at once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest
import threads

pytestmark = pytest.mark.skipif(threads.why_not() != "", reason=threads.why_not())


@pytest.mark.parametrize(("flavour", "count", "runs"), [("python", 8, 1), ("native-2", 16, 5)])
def test_many_threads_have_the_bits_of_one(
    flavour: str, count: int, runs: int, fmu_of: Callable[[str], Path], tmp_path: Path
) -> None:
    program, fmu = threads.build(tmp_path), fmu_of(flavour)
    unzipped = Path(fmpy.extract(str(fmu), str(tmp_path / "unzipped")))
    for _ in range(runs):
        done = threads.run(program, fmu, unzipped, count)
        assert done.returncode == 0, done.stdout + done.stderr[-3000:]
        assert done.stdout.startswith(f"{count} threads, 40 numbers each, 0 differ")
