"""Study files that tests write."""

from collections.abc import Callable
from pathlib import Path

from hoist_demo.study.definition import Study, read_study

Read = Callable[..., Study]


def reader(folder: Path, fmu: Path) -> Read:
    """Reads the text of a study file, which it writes into ``folder``; with the rope ``fmu`` if none is given."""

    def read(text: str, rope: Path = fmu) -> Study:
        path = folder / "STUDY.toml"
        path.write_text(f'study.fmu = "{rope}"\n{text}', encoding="utf-8")
        return read_study(path)

    return read
