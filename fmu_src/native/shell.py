"""The C files between the FMI functions and model.h, which every FMU has."""

from __future__ import annotations

from pathlib import Path

_HERE = Path(__file__).resolve().parent
_COMMON = ("component.c", "component.h", "model.h", "snapshot.c", "snapshot.h")


def shell(fmi: int, *more: str) -> dict[str, str]:
    """File name -> text, headers of the standard included, and ``more`` C files of this folder."""
    headers = sorted(path.name for path in (_HERE / "include").glob(f"fmi{fmi}*.h"))
    files = [*(_HERE / name for name in (*_COMMON, f"fmi{fmi}.c", *more)), *(_HERE / "include" / h for h in headers)]
    return {path.name: path.read_text(encoding="utf-8") for path in files}
