"""Tables as CSV files: columns by name, numbers to six digits."""

import csv
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: columns by name with their unit; numbers, or text
Table = Mapping[str, NDArray[Any]]
#: tables by the name of their file
Tables = Mapping[str, Table]
#: what measures the tables of a package, by the name of the part
Measures = Mapping[str, Callable[[], Tables]]


def table(names: Sequence[str], rows: Sequence[Sequence[Any]]) -> Table:
    """Columns from rows."""
    return {
        name: np.array(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)
    }


def rows(t: Table, **wanted: str | float | tuple[str, ...] | tuple[float, ...]) -> Table:
    """The rows whose columns have the wanted values: rows(t, family=("eem", "tmn"), coupling="coupled")."""
    kept = np.ones(len(next(iter(t.values()))), dtype=bool)
    for name, value in wanted.items():
        kept &= np.isin(t[name], value)
    return where(t, kept)


def where(t: Table, kept: NDArray[np.bool_]) -> Table:
    """Return the rows that are ``kept``."""
    return {name: column[kept] for name, column in t.items()}


def records(t: Table) -> list[dict[str, Any]]:
    """Return the rows as dictionaries."""
    return [
        dict(zip(t, row, strict=True))
        for row in zip(*(column.tolist() for column in t.values()), strict=True)
    ]


def write(tables: Tables, folder: Path) -> None:
    """One CSV file per table."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, columns in tables.items():
        with (folder / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
            out = csv.writer(file, lineterminator="\n")
            out.writerow(columns)
            out.writerows([_cell(x) for x in row] for row in zip(*columns.values(), strict=True))


def read(folder: Path) -> Tables:
    """Every table of a folder; a column is numeric when all its cells are, an empty one of them being NaN."""
    tables = {}
    for path in sorted(folder.glob("*.csv")):
        with path.open(newline="", encoding="utf-8") as file:
            names, *rows = csv.reader(file)
        tables[path.stem] = {
            name: _column(cells) for name, cells in zip(names, zip(*rows, strict=True), strict=True)
        }
    return tables


def _cell(value: Any) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"


def _column(cells: Sequence[str]) -> NDArray[Any]:
    try:
        if not any(cells):
            return np.array(cells)
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells)
