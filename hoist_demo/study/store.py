"""A study's folder: a file for every finished run, written at once and whole, and the table.

    runs/KEY.json       data and outcome of a run; a file that exists is complete
    signals/KEY.parquet its time series and their instants, where the study keeps any; units as in results.parquet
    results.parquet     one row per run in the study's order, units in the schema's field metadata
    results.csv         the same, header ``name [unit]``

The table holds no date: the same study writes the same bytes. pandas and pyarrow are loaded where
tables are written or read: no worker does, and they took a quarter of the time in which it loads
all it needs.
"""

from __future__ import annotations

import json
import logging
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hoist_demo.run.data import RunData
from hoist_demo.study.outcome import FINISHED, Outcome
from rope_model.files import whole_file, write_text
from rope_model.texts import csv_cell

if TYPE_CHECKING:
    import pandas as pd

Units = Mapping[str, str]
_log = logging.getLogger(__name__)
#: Keys of an outcome in a record.
_OUTCOME = {one.name for one in fields(Outcome)} - {
    "signals",
    "units",
}
SEPARATOR = " | "  #: Between the warnings of a run in the table.
_NUMBER = re.compile(r"\d[\d.e+-]*")


def kind_of(text: str) -> str:
    """Return a warning without its numbers: those that differ in them only are of one kind."""
    return _NUMBER.sub("", text)


@dataclass(frozen=True)
class Results:
    """A study's table and the unit of each column, "" for a text."""

    table: pd.DataFrame
    units: dict[str, str]


class Store:
    """Folder with the records and tables of one study."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self._broken: set[Path] = set()  # records of which was warned
        for name in ("runs", "signals"):
            (directory / name).mkdir(parents=True, exist_ok=True)

    def finished_keys(self, keys: Sequence[str]) -> set[str]:
        """Return the keys that need no further run."""
        finished = set()
        for key in keys:
            record = self.read(key)
            if record and record["outcome"]["status"] in FINISHED:
                finished.add(key)
        return finished

    def read(self, key: str) -> dict[str, Any] | None:
        """Read the record of a run, None if there is none.

        A broken record counts as none, with a warning: its run is wound again, and replaces it.
        """
        path = self._path(key)
        if not path.exists():
            return None
        try:
            record: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            if lacking := _OUTCOME - record["outcome"].keys():
                raise KeyError(", ".join(sorted(lacking)))
        except OSError as error:
            raise ValueError(
                f"{path} cannot be read ({error.strerror}): delete it, and its run is wound again"
            ) from error
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            if path not in self._broken:
                self._broken.add(path)
                _log.warning(
                    "%s is no whole record of a run (%s): its run is wound again", path, error
                )
            return None
        return record

    def write(self, key: str, run: RunData, outcome: Outcome, worker: str) -> None:
        """Keep a run: series first, then the record that declares it done."""
        if outcome.signals:
            import pyarrow as pa
            import pyarrow.parquet as pq

            columns = [
                pa.field(n, pa.float64(), metadata={"unit": outcome.units.get(n, "")})
                for n in outcome.signals
            ]
            table = pa.table(
                [pa.array(values) for values in outcome.signals.values()], schema=pa.schema(columns)
            )
            with whole_file(self.directory / "signals" / f"{key}.parquet") as path:
                pq.write_table(table, path)
        recorded = {name: value for name, value in vars(outcome).items() if name in _OUTCOME}
        record = {"key": key, "data": run.record(), "outcome": recorded, "worker": worker}
        write_text(self._path(key), json.dumps(record, indent=1))

    def write_table(self, rows: Sequence[Mapping[str, object]], units: Units, title: str) -> Path:
        """Write results.parquet and results.csv; return the path of the first."""
        import pandas as pd
        import pyarrow as pa
        import pyarrow.parquet as pq

        frame = pd.DataFrame(list(rows))
        table = pa.Table.from_pandas(frame, preserve_index=False)
        columns = [
            field.with_metadata({"unit": units.get(field.name, "")}) for field in table.schema
        ]
        schema = pa.schema(columns, metadata={**(table.schema.metadata or {}), "title": title})
        with whole_file(self.directory / "results.parquet") as path:
            pq.write_table(table.cast(schema), path)
        header = []
        for name in frame.columns:
            unit = units.get(name)
            header.append(csv_cell(f"{name} [{unit}]" if unit else str(name)))
        with whole_file(self.directory / "results.csv") as path:
            frame.map(csv_cell).to_csv(
                path, index=False, header=header, float_format="%.9g", lineterminator="\n"
            )
        return self.directory / "results.parquet"

    def _path(self, key: str) -> Path:
        return self.directory / "runs" / f"{key}.json"


def read_results(path: Path) -> Results:
    """Read a study's ``results.parquet`` or the series of a run, with the units."""
    import pyarrow.parquet as pq

    table = pq.read_table(path)
    units: dict[str, str] = {}
    for field in table.schema:
        metadata = field.metadata or {}
        units[field.name] = metadata.get(b"unit", b"").decode()
    return Results(table.to_pandas(), units)
