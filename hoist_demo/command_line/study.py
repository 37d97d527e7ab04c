"""The command ``balance-rope study``."""

from __future__ import annotations

import argparse
import sys
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

from hoist_demo.command_line.support import (
    CHECKED,
    HOIST_UNCHECKED,
    INTERRUPTED,
    add_results,
    describe,
    results_folder,
)

if TYPE_CHECKING:
    from hoist_demo.study.definition import Study
    from hoist_demo.study.perform import StudyResult
    from hoist_demo.study.store import Store

_DESCRIPTION = """\
Wind many times with the rope's FMU, over parameters that a TOML file names, on all cores or on a dask cluster.
Every finished run is kept at once: start the same command again to go on after an interruption."""

_EPILOG = """\
examples:
  balance-rope study examples/studies/controllers.toml
  balance-rope study STUDY.toml --scheduler tcp://host:8786    on the workers of a dask scheduler

Results in --out: results.parquet (pandas.read_parquet opens it) and results.csv, one row per run, data.csv, where each
number comes from, and report.html.
exit code: 0 all runs wound to the end, 1 some did not (their causes are printed and in the table), 2 wrong study
file or arguments, 130 interrupted.
"""


def add_study(study: argparse.ArgumentParser) -> None:
    """Add description and options of the command ``study``."""
    describe(study, _study, _DESCRIPTION, _EPILOG)
    study.add_argument(
        "study", type=Path, metavar="STUDY.toml", help="what to vary, see docs/reference/files.md"
    )
    study.add_argument("--fmu", type=Path, metavar="PATH", help="the rope, instead of the file's")
    where = study.add_mutually_exclusive_group()
    where.add_argument(
        "--workers", type=int, metavar="N", help="processes on this machine (one per core)"
    )
    where.add_argument(
        "--scheduler", metavar="ADDRESS", help="a dask scheduler, e.g. tcp://host:8786"
    )
    add_results(study, "study")


def _study(options: argparse.Namespace) -> int:
    # dask, pandas and pyarrow are needed here only, and load slowly
    try:
        from hoist_demo.study.cluster import cluster  # noqa: F401  only whether it is there
        from hoist_demo.study.perform import write_partial_results
        from hoist_demo.study.store import Store
    except ModuleNotFoundError as error:
        raise ValueError(
            f"a study needs {error.name}: pip install 'balance-rope[study]'"
        ) from error
    from hoist_demo.study.definition import read_study

    if options.workers is not None and options.workers < 1:
        raise ValueError(
            f"--workers {options.workers} must be at least 1: leave it out for one per core"
        )
    watched = partial(tqdm, desc="checking", unit="run", file=sys.stderr, leave=False, disable=None)
    study = read_study(options.study, options.fmu, watched)
    if options.check:
        print(f"{options.study}: {len(study.samples)} runs; {CHECKED}; {HOIST_UNCHECKED}")
        return 0

    store = Store(results_folder(options.out or Path("out") / "study" / options.study.stem))
    try:
        result = _run(study, store, options)
    except KeyboardInterrupt:
        table_path = write_partial_results(study, store)
        kept = "no run was finished"
        if table_path is not None:
            kept = f"what is finished is kept in {table_path}"
        print(f"\ninterrupted: {kept}; the same command goes on", file=sys.stderr)
        return INTERRUPTED
    _print_result(result)
    report = _write_report(study, result, store.directory, options.study.name)
    print(f"open in a browser: {report}")
    return result.exit_code


def _run(study: Study, store: Store, options: argparse.Namespace) -> StudyResult:
    """Wind what is not finished yet, beside a bar that shows the progress."""
    from hoist_demo.study.cluster import cluster, run_samples
    from hoist_demo.study.perform import run_study

    keys: list[str] = []
    if study.plan is None:
        keys = [sample.data.key(study.fmu_hash) for sample in study.samples]
    total = len(set(keys)) or None
    there = len(store.finished_keys(keys))
    if there:
        print(f"{there} of {total} runs are there already")
    with (
        cluster(options.workers, options.scheduler) as client,
        tqdm(
            total=total,
            initial=there,
            desc="winding",
            unit="run",
            file=sys.stderr,
            disable=None,
        ) as bar,
    ):
        return run_study(
            study,
            store,
            partial(run_samples, client, study, store=store, finished=lambda *_: bar.update()),
        )


def _print_result(result: StudyResult) -> None:
    """Print what struck, warnings, causes of runs that stopped, the table's path and what is best."""
    for run, passed in result.passages.items():
        print(f"{run}: {passed}", file=sys.stderr)
    for text, runs in result.warnings.items():
        more = f" and {len(runs) - 1} more" if len(runs) > 1 else ""
        print(f"{runs[0]}{more}: warning: {text}", file=sys.stderr)
    for run, cause in result.causes.items():
        print(f"{run}: {cause}", file=sys.stderr)
    print(f"{result.summary}: {result.table}")
    for remark in result.remarks:
        print(f"not monotonic: {remark}")
    if result.best is not None:
        print(result.best.text, file=sys.stdout if result.best.feasible else sys.stderr)


def _write_report(study: Study, result: StudyResult, folder: Path, file_name: str) -> Path:
    """Write data.csv and the page, print the data by status, and return the page's path."""
    from hoist_demo.cosimulation.participants.fmu_description import read_fmu
    from hoist_demo.report.html.study import study_report
    from hoist_demo.report.rows import provenance_table, render, status_rows
    from hoist_demo.run.provenance import write_data
    from hoist_demo.study.provenance import study_provenance
    from hoist_demo.study.store import read_results

    results = read_results(result.table)
    parameters = [
        name
        for name in results.table.columns
        if name in study.units or name in ("variant", "controller")
    ]
    meta: dict[str, Any] = {
        "title": study.title,
        "parameters": parameters,
        "study file": file_name,
        "hoist": study.hoist,
        "FMU": study.fmu.name,
        "SHA-256": study.fmu_hash,
        "FMI version": read_fmu(study.fmu).description.fmiVersion,
        "version": version("balance-rope"),
    }
    provenance = study_provenance(study)
    write_data(provenance, folder / "data.csv")
    print("\n" + render(status_rows(provenance)) + "\n")
    data = [provenance_table(provenance)]
    return study_report(results, meta, folder / "report.html", data, result, study.objective)
