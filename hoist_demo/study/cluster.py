"""Runs on dask.distributed: a cluster of this machine's cores, or a scheduler elsewhere.

Every worker is handed the FMU's bytes when it joins, also one that replaces a dead one, so that no
folder need be shared. Short runs are handed out several at a time, as handing over costs a tenth of
one. Runs whose worker died are given to others; after three deaths they are given singly, and after
three more a run is recorded as an error.
"""

import logging
import math
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import dask
from dask.distributed import (
    Client,
    Future,
    LocalCluster,
    Worker,
    WorkerPlugin,
    as_completed,
    get_worker,
)

from hoist_demo.run.data import RunData
from hoist_demo.run.metrics import UNITS
from hoist_demo.study.definition import Study, StudyRun
from hoist_demo.study.outcome import ERROR, Outcome, execute
from hoist_demo.study.store import Store
from rope_model.files import write_bytes

_log = logging.getLogger(__name__)
#: Called with the key and the outcome of every run as it is recorded.
Finished = Callable[[str, Outcome], None]
#: Time that a worker works on what it is given at once, if that is more than one run [s].
BATCH = 0.5
QUEUED_BATCHES = 2  #: Batches per thread given before others have ended.
MIN_THREADS = 16  #: Threads that are counted at least: workers may join.

#: Nobody looks at the stacks that workers would sample a hundred times a second, nor at the
#: machine's load, nor at how late each part of the cluster is fifty times a second; and no run
#: fills the memory in a tenth of a second.
_UNWATCHED = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.tick.interval": "1s",
    "distributed.worker.memory.monitor-interval": "1s",
    "distributed.scheduler.allowed-failures": 2,
}


class FmuOnWorkers(WorkerPlugin):  # type: ignore[misc]  # distributed has no types
    """Plugin that writes the FMU into the folder of every worker."""

    idempotent = True  # a search hands it over before each of its rounds

    def __init__(self, fmu_hash: str, content: bytes) -> None:
        self.name = f"fmu-{fmu_hash}"
        self._hash = fmu_hash
        self._content = content

    def setup(self, worker: Worker) -> None:
        """Write the FMU; the worker calls this when it joins."""
        write_bytes(_fmu_of(Path(worker.local_directory), self._hash), self._content)


@contextmanager
def cluster(workers: int | None, scheduler: str | None) -> Iterator[Client]:
    """Yield a client of the given scheduler, or of a local cluster.

    A local cluster has one process with one thread per worker.
    """
    if scheduler is not None:
        try:
            client = Client(scheduler, timeout="20s")
        except (OSError, ValueError) as error:
            raise ValueError(
                f"--scheduler {scheduler} cannot be reached ({error}): start it, or leave it out"
            ) from error
        with client:
            yield client
        return
    # distributed tells every coming and going of its parts; what matters of it is each run's cause
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    count = os.cpu_count() if workers is None else workers
    options = {
        "threads_per_worker": 1,
        "processes": True,
        "dashboard_address": ":0",
        "silence_logs": logging.CRITICAL,
    }
    with (
        dask.config.set(_UNWATCHED),
        LocalCluster(n_workers=count, **options) as local,
        Client(local) as client,
    ):
        yield client


def run_samples(
    client: Client,
    study: Study,
    samples: Sequence[StudyRun],
    store: Store,
    finished: Finished = lambda *_: None,
) -> list[str]:
    """Carry out what the store does not hold yet, and return the key of each sample."""
    keys = [sample.data.key(study.fmu_hash) for sample in samples]
    done = store.finished_keys(keys)
    waiting = {
        key: sample.data for key, sample in zip(keys, samples, strict=True) if key not in done
    }
    if not waiting:
        return keys
    client.register_plugin(FmuOnWorkers(study.fmu_hash, study.fmu.read_bytes()))
    for one in _Batches(client, study.fmu_hash, waiting).finished():
        store.write(one.key, waiting[one.key], one.outcome, one.worker)
        _log.info(
            "%s %s on %s: %s",
            one.key,
            one.outcome.status,
            one.worker,
            one.outcome.cause or "wound to the end",
        )
        finished(one.key, one.outcome)
    return keys


class _FinishedRun(NamedTuple):
    """Run that a worker has carried out."""

    key: str
    outcome: Outcome
    worker: str  # its name; "" where the run failed


class _FinishedBatch(NamedTuple):
    """Runs that a worker has carried out in one call."""

    outcomes: list[Outcome]
    worker: str
    took: float  # s


class _Batches:
    """Runs that wait for workers, in batches as long as the pace of the runs asks for."""

    def __init__(self, client: Client, fmu_hash: str, waiting: Mapping[str, RunData]) -> None:
        self._client = client
        self._fmu_hash = fmu_hash
        self._waiting = waiting
        self._remaining = [*waiting]
        self._submitted = as_completed()
        self._batches: dict[Future, list[str]] = {}
        self._pace = BATCH  # time that a run takes [s]

    def finished(self) -> Iterator[_FinishedRun]:
        """Yield the runs as they finish, and submit others."""
        while self._remaining or self._batches:
            self._fill_queue()
            future = next(self._submitted)
            # a worker keeps outcomes as long as anybody holds their future
            batch = self._batches.pop(future)
            try:
                done: _FinishedBatch = future.result()
            except Exception as error:  # whatever the cluster raises is that run's cause
                if len(batch) > 1:  # it is not known which
                    for key in batch:
                        self._submit([key])
                    continue
                cause = f"{type(error).__name__}: {error}"
                failed = Outcome(ERROR, cause, dict.fromkeys(UNITS, math.nan), {})
                done = _FinishedBatch([failed], worker="", took=0.0)
            else:
                # one that fails at once says little
                self._pace = max(done.took / len(batch), 0.5 * self._pace)
            for key, outcome in zip(batch, done.outcomes, strict=True):
                yield _FinishedRun(key, outcome, done.worker)

    def _fill_queue(self) -> None:
        """Submit batches until there are enough for all threads."""
        threads = max(1, sum(self._client.ncores().values()))
        while self._remaining and len(self._batches) < QUEUED_BATCHES * max(threads, MIN_THREADS):
            by_pace = int(BATCH / self._pace)
            fair = len(self._remaining) // (QUEUED_BATCHES * threads)
            size = max(1, min(by_pace, fair))
            self._submit(self._remaining[:size])
            del self._remaining[:size]

    def _submit(self, batch: list[str]) -> None:
        runs = [self._waiting[key] for key in batch]
        name = f"runs-{len(batch)}-{batch[0]}"
        future = self._client.submit(_work, runs, self._fmu_hash, key=name, pure=False)
        self._batches[future] = batch
        self._submitted.add(future)


def _work(runs: Sequence[RunData], fmu_hash: str) -> _FinishedBatch:
    """Carry out runs on a worker."""
    worker = get_worker()
    begin = time.perf_counter()
    outcomes = [execute(run, _fmu_of(Path(worker.local_directory), fmu_hash)) for run in runs]
    return _FinishedBatch(outcomes, str(worker.name), time.perf_counter() - begin)


def _fmu_of(directory: Path, fmu_hash: str) -> Path:
    return directory / f"{fmu_hash}.fmu"
