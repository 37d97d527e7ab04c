"""The machine that processor times were measured on."""

import os
import platform
from importlib.metadata import version
from pathlib import Path

from evidence.tables import Table, table


def machine() -> Table:
    """Processor, its cores, and the versions of what computes."""
    rows = [
        ("processor", _processor()),
        ("processors", str(os.cpu_count())),
        ("Python", platform.python_version()),
        *((name, version(name)) for name in ("numpy", "casadi")),
    ]
    return table(("what", "value"), rows)


def _processor() -> str:
    """The processor's model where the system tells, or its architecture."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.is_file() else []
    names = (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.machine())
