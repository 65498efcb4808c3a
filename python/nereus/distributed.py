"""More than one process, more than one machine: any Dask cluster.

    nereus.distributed.record(scene, "flight.zarr")                    # all cores of this machine
    nereus.distributed.record(scene, "flight.zarr", client)            # a dask.distributed.Client
    nereus.distributed.sweep(scene, {"scene.seed": range(100)}, function, client)

A worker makes one shard at a time with the threads that it owns, as an HDF5 part in its scratch folder, and
writes the chunks of its pulses into the one store. What is made depends on the number of a pulse alone, so the
store is bit-identical to one run's. A worker that is lost, or does not answer in time, has its shard made by
another one, unless it is the shard that ends them; a shard that is made twice is written twice, with the same
bytes. The store gets its name when it is complete.

In a script that has no client, call these below `if __name__ == "__main__":`, as for every multiprocessing
program.
"""
from __future__ import annotations

import ast
import itertools
import math
import os
import pickle
import sys
import tempfile
import time
import traceback
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from . import __version__ as VERSION
from .dataset import CHANGES, INDEX, source
from .errors import InputError, RunError, SweepError, WorkerError, needs
from .zarr import Draft, Outline, chunk_length, write_rows

if TYPE_CHECKING:
    import xarray
    from distributed import Client

    from .scenario import Scenario

#: Pulses that are tried to measure the cost of one, unless they take longer than TRIAL_S: several blocks of
#: a fast scenario.
TRIAL, TRIAL_S = 256, 10.0
#: A shard that takes this many times what was measured, and this many seconds, is given up.
SLACK, LEAST_S = 10.0, 60.0
#: The trial is given up after this time.
LONGEST_S = 3600.0
#: Times that a shard or case may raise, or lose its worker, before that is passed on.
TRIES = 3
#: A start should be at most this share of a shard.
START_SHARE = 0.1
#: Work of a shard of a long run, so that workers that come later get some, too.
SHARD_S = 60.0
#: Without any worker, jobs may be waiting in a queue.
WAIT_S = 3600.0
GLANCE_S = 0.05


@dataclass(frozen=True)
class Report:
    """What a distributed recording came to."""

    path: str
    pulses: int
    shards: int
    chunk_pulses: int
    remade: int
    estimate_s: float
    seconds: float


def record(
    scene: Scenario,
    path: str | os.PathLike[str],
    client: Client | None = None,
    shards: int | None = None,
    *,
    force: bool = False,
    progress: bool = True,
    timeout_s: float | None = None,
    wait_s: float = WAIT_S,
    chunk_pulses: int | None = None,
) -> Report:
    """Records a scenario as a Zarr store, shard by shard on the workers of a `dask.distributed.Client`.

    `path` is on a file system that all workers share, and so are the files that the scenario names. `shards` is
    their number (default: four for each worker, more where a shard would be longer than a minute, fewer where
    starting would take more than a tenth); `chunk_pulses` the pulses of a chunk (default: as `nereus.zarr`, from the
    scenario alone). A shard that has not come after `timeout_s` (default: ten times what was measured, at least
    60 s) is made elsewhere, with twice the time, and its worker gets no other until it answers. Without any worker
    for `wait_s` (default: an hour, for jobs in a queue) the run is given up. Without a client: a LocalCluster of all
    cores, one thread each, closed afterwards.

    Prints an estimate of the cost first, then progress; returns a `Report`. Raises `OutputExistsError` for a store
    that exists unless `force`, `WorkerError` where workers lack the package, none answers, or a shard has ended
    three of them, and what the engine raises. What fails leaves nothing under the name.
    """
    _needs()
    begun = time.monotonic()
    draft, total, blob = Draft(path, force), scene.pulse_count, _pickled(scene)
    if shards is not None and not 1 <= shards <= total:
        raise InputError(f"shards = {shards}; allowed: 1 to the {total} pulses of the run")
    with _client(client) as client, draft:
        farm = _Farm(client, timeout_s, wait_s, progress, os.path.basename(path))
        trial = min(TRIAL, total)
        outline, start_s, pulse_s = farm.run([_Job("the trial", "_try", (blob, trial), None)])[0]
        outline = replace(outline, attrs={**outline.attrs, "config": scene.text, "first_pulse": 0, "pulses": total})
        chunk = chunk_pulses or chunk_length(total, outline.row_bytes())
        workers = farm.size()
        ranges = _ranges(total, chunk, shards or _shards(workers, total * pulse_s, start_s))
        estimate = (math.ceil(len(ranges) / workers) * start_s) + total * pulse_s / min(workers, len(ranges))
        farm.say(
            f"{total} pulses in {len(ranges)} shards on {workers} workers: about {_span(estimate)} "
            f"({start_s:.1f} s to start a shard, {1 / pulse_s:.0f} pulses/s each), {total * outline.pulse_bytes() / 1e6:.0f} MB"
        )
        draft.create(outline, total, chunk)
        jobs = [
            _Job(f"pulses {a}..{b}", "_make", (blob, outline, str(draft.path), a, b), start_s + (b - a) * pulse_s)
            for a, b in ranges
        ]
        # Every shard knows the changes of reports up to its last pulse: those of the last one are the run's.
        for name, (dims, values, attrs) in farm.run(jobs)[-1].items():
            draft.fixed(name, dims, values, attrs)
        draft.finish()
    return Report(str(draft.out), total, len(ranges), chunk, farm.remade, estimate, time.monotonic() - begun)


def sweep(
    scene: Scenario,
    keys: Mapping[str, Iterable[Any]],
    function: Callable[[Scenario], Any],
    client: Client | None = None,
    *,
    progress: bool = True,
    timeout_s: float | None = None,
    wait_s: float = WAIT_S,
) -> xarray.DataArray | xarray.Dataset:
    """`function(scene)` for every combination of values of some keys of the scenario, labelled by them.

    `keys` has values by key: `{"scene.seed": range(100), "sea.wind_mps": [5, 10]}`. `function` returns a number, an
    array, an `xarray.DataArray`, or a dict of them; all cases the same shapes, dimensions and coordinates. The
    result is a `DataArray`, or a `Dataset` for dicts, whose first dimensions are the keys. Cases of lost workers are
    made again, also those that have not come after `timeout_s` (default: no limit); a case that has ended three
    workers raises `WorkerError`, and so does `wait_s` without any worker. An exception of `function` is passed on as
    `SweepError`.
    """
    _needs()
    for key, values in keys.items():
        if isinstance(values, (str, Mapping)) or not isinstance(values, Iterable):
            raise InputError(f"{key}: {values!r}; allowed: a list of values, such as [{values!r}]")
    keys = {key: list(values) for key, values in keys.items()}
    empty = [key for key, values in keys.items() if not values]
    if not keys or empty:
        raise InputError(f"nothing to sweep: {', '.join(empty) or 'no key'} has no value; allowed: at least one for each key")
    cases = [dict(zip(keys, values)) for values in itertools.product(*keys.values())]
    for key, values in keys.items():
        for value in values:
            # Read here, so that a fault of a key or a value is no worker's.
            scene.set({**cases[0], key: value}).pulse_count
    blob, call = _pickled(scene), _pickled(function)
    with _client(client) as client:
        farm = _Farm(client, timeout_s or math.inf, wait_s, progress, "sweep")
        jobs = [_Job(f"case {case}", "_case", (blob, case, call), None) for case in cases]
        return _labelled(keys, cases, farm.run(jobs))


# On the workers. They are called by name (`_call`), so that a scheduler needs no nereus.


def _threads():
    from distributed import get_worker

    return max(1, get_worker().state.nthreads)


def _owned(blob):
    """The scenario with the threads that this worker owns."""
    return pickle.loads(blob).set({"stream.threads": _threads()})


@contextmanager
def _part(scene, first, last, progress=False):
    """A recorded part of the run, and what its run reports; none where `progress` has ended it by `_Enough`."""
    from distributed import get_worker

    with tempfile.TemporaryDirectory(prefix="nereus-", dir=get_worker().local_directory) as folder:
        path, report = os.path.join(folder, "part.h5"), None
        try:
            report = scene.record(path, pulses=(first, last), progress=progress)
        except _Enough:
            pass
        with source(path) as rec:
            yield rec, report


class _Enough(Exception):
    """The trial has taken its time."""


def _try(blob, pulses):
    """The outline of the recording, seconds to start, seconds a pulse."""
    times = [time.monotonic()]

    def enough(passed, *_):
        if passed:
            times.append(time.monotonic())
        if passed and times[-1] - times[0] > TRIAL_S:
            raise _Enough

    with _part(_owned(blob), 0, pulses, enough) as (rec, report):
        taken = time.monotonic() - times[0]
        if report:
            return Outline.of(rec), taken - report["elapsed_s"], report["elapsed_s"] / pulses
        # Whoever ends it does not say what starting took: less than until the first pulses were made.
        return Outline.of(rec), times[1] - times[0], taken / rec.pulses


def _make(blob, outline, store, first, last):
    """Writes a shard into the store; returns its changes of reports."""
    with _part(_owned(blob), first, last) as (rec, _):
        difference = outline.difference(Outline.of(rec))
        if difference:
            raise WorkerError(f"pulses {first}..{last} are of another recording: {difference} differ; allowed: the same nereus and the same files on all workers")
        index = rec.read(INDEX, (slice(0, rec.pulses),))
        if not np.array_equal(index, np.arange(first, last, dtype=index.dtype)):
            raise RunError(f"pulses {first}..{last}: {rec.pulses} were recorded; a run that may drop or stop pulses cannot be made in shards")
        write_rows(store, rec, first)
        return {name: fixed for name, fixed in rec.fixed.items() if name.startswith(CHANGES)}


@dataclass
class _Failed:
    """The exception of a function, returned so that Dask writes no report of its own, and its text with its place."""

    error: Exception
    text: str


def _case(blob, case, call):
    try:
        return pickle.loads(call)(pickle.loads(blob).set({"stream.threads": _threads(), **case}))
    except Exception as error:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        # cloudpickle sends functions of scripts without the name of their file, from version 3.1.3 on.
        file = "" if frame.filename.startswith("<") else f"{os.path.basename(frame.filename)}, "
        text = f"{type(error).__name__}: {error} ({file}line {frame.lineno}, in {frame.name})"
        try:
            pickle.loads(_pickled(error))
        except Exception:  # not every exception can be sent
            error = RunError(text)
        return _Failed(error, text)


def _caller():
    """What is sent to a worker: pickled by value, because it is no function of a module."""

    def call(name, arguments):
        import importlib
        import pickle

        return getattr(importlib.import_module("nereus.distributed"), name)(*pickle.loads(arguments))

    def version():
        try:
            import importlib

            module = importlib.import_module("nereus.distributed")
            return "", module.VERSION
        except ImportError as error:
            return str(error), None

    return call, version


# Here.


def _pickled(what):
    import cloudpickle

    return cloudpickle.dumps(what)


@contextmanager
def _client(given):
    """The client, or one of a cluster of all cores."""
    from distributed import Client, LocalCluster

    if given is not None:
        yield given
        return
    _guarded()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    with LocalCluster(n_workers=cores, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            yield client


def _needs():
    needs("nereus.distributed", "dask", "distributed", "zarr", "h5py", "xarray", "cloudpickle")


def _guarded():
    """Refuses to start workers from a script that each of them would run again."""
    main = sys.modules["__main__"]
    # As multiprocessing has it: notebooks and `python -m package` are not run again.
    name, path = getattr(getattr(main, "__spec__", None), "name", ""), getattr(main, "__file__", None)
    frame = sys._getframe()
    while frame and not (frame.f_globals is vars(main) and frame.f_code.co_name == "<module>"):
        frame = frame.f_back
    if not frame or not path or name.endswith("__main__") or not os.path.exists(path):
        return
    with open(path, "rb") as script:
        lines = ast.parse(script.read()).body
    under_way = next((line for line in lines if line.lineno <= frame.f_lineno <= line.end_lineno), None)
    if under_way and not (isinstance(under_way, ast.If) and "__name__" in ast.dump(under_way.test)):
        raise InputError(
            f'{path}, line {frame.f_lineno}: every worker would run the script again; remedy: put the call under '
            'if __name__ == "__main__":'
        )


def _shards(workers, work_s, start_s):
    """Four shards a worker, so that all end at about the same time, and one for each SHARD_S of work, whoever is there
    by now; fewer, but one for each worker, where starts would weigh."""
    wanted = max(4 * workers, int(work_s / SHARD_S))
    return max(workers, min(wanted, int(START_SHARE * work_s / max(start_s, 1e-3))))


def _ranges(total, chunk, shards):
    """Ranges of whole chunks that cover all pulses, at most so many."""
    chunks = -(-total // chunk)
    shards = min(shards, chunks)
    edges = [min(total, chunks * k // shards * chunk) for k in range(shards + 1)]
    return list(zip(edges, edges[1:]))


def _span(seconds):
    for unit, length in (("days", 86400), ("h", 3600), ("min", 60)):
        if seconds >= 2 * length:
            return f"{seconds / length:.0f} {unit}"
    return f"{seconds:.0f} s"


@dataclass
class _Job:
    """What a worker is asked: a function of this module by name, and its arguments."""

    name: str
    call: str
    arguments: tuple
    expected_s: float | None


@dataclass
class _Asked:
    """What a worker is doing."""

    future: object
    job: int | None  # None: whether it has the package
    until: float


class _Farm:
    """Jobs on the workers of a client, one at a time on each.

    Workers are asked by name rather than through Dask's own placement: a job belongs to one worker alone, whatever
    its threads, and one that does not answer can be left out until it does.
    """

    def __init__(self, client, timeout_s, wait_s, progress, name):
        self.client, self.timeout_s, self.wait_s, self.progress, self.name = client, timeout_s, wait_s, progress, name
        # Silent: what workers were asked that did not answer in time.
        self.asked, self.ready, self.silent = {}, set(), {}
        self.call, self.version = _caller()
        self.remade, self.shown = 0, ""
        # By job.
        self.lost, self.late = Counter(), Counter()

    def workers(self):
        return self.client.scheduler_info(n_workers=-1)["workers"]

    def size(self):
        """Workers that answer, or may."""
        return max(1, len(self.workers().keys() - self.silent.keys()))

    def say(self, text, stay=True):
        """A line of progress: in place on a terminal, else now and then."""
        if not self.progress:
            return
        terminal = sys.stderr.isatty()
        if stay or terminal:
            blank = " " * max(0, len(self.shown) - len(text))
            print(f"{self.name}: {text}{blank}", end="\n" if stay or not terminal else "\r", file=sys.stderr, flush=True)
            self.shown = "" if stay else text

    def run(self, jobs):
        """Results of all jobs, in order."""
        waiting, results, raised = deque(range(len(jobs))), {}, Counter()
        self.lost, self.late = Counter(), Counter()
        begun = answered = time.monotonic()
        waits = False
        try:
            while len(results) < len(jobs):
                here = set(self.workers())
                for worker in [worker for worker, asked in self.silent.items() if asked.future.status != "pending"]:
                    del self.silent[worker]
                if here - self.silent.keys():
                    answered, waits = time.monotonic(), False
                elif not waits:
                    waits = True
                    self.say(f"no worker answers: waiting for one, {_span(self.wait_s)} at most")
                if time.monotonic() - answered > self.wait_s:
                    silent = len(self.silent.keys() & here)
                    raise WorkerError(
                        f"no worker answers: {len(here)} connected, {silent} given up after a timeout; "
                        "remedy: start workers, or wait longer for those of a queue (wait_s)"
                    )
                for worker, asked in list(self.asked.items()):
                    self.collect(worker, asked, here, jobs, waiting, results, raised)
                self.give(here, jobs, waiting)
                if len(jobs) > 1:
                    self.show(len(results), len(jobs), begun)
                time.sleep(GLANCE_S)
        finally:
            for asked in [*self.asked.values(), *self.silent.values()]:
                if asked.job is not None:
                    asked.future.cancel()
            self.asked = {w: a for w, a in self.asked.items() if a.job is None}
        if len(jobs) > 1:
            self.say(f"{len(jobs)} of {len(jobs)} in {_span(time.monotonic() - begun)}" + (f", {self.remade} made again" if self.remade else ""))
        return [results[k] for k in range(len(jobs))]

    def limit(self, job):
        """Seconds after which a job is asked of another worker."""
        if job is None:
            return LEAST_S  # a first import, on a file system that all share
        return self.timeout_s or max(LEAST_S, SLACK * (job.expected_s or LONGEST_S / SLACK))

    def give(self, here, jobs, waiting):
        """Asks new workers for their version, and gives a job to each that has none."""
        for worker in here - self.silent.keys() - self.asked.keys():
            if worker not in self.ready:
                self.ask(worker, None, self.version, (), self.limit(None))
            elif waiting:
                k = waiting.popleft()
                # Twice the time at each repeat, for machines that are merely slow.
                limit_s = self.limit(jobs[k]) * 2.0 ** self.late[k]
                self.ask(worker, k, self.call, (jobs[k].call, _pickled(jobs[k].arguments)), limit_s)

    def ask(self, worker, job, function, arguments, limit_s):
        future = self.client.submit(function, *arguments, workers=[worker], allow_other_workers=False, pure=False)
        self.asked[worker] = _Asked(future, job, time.monotonic() + limit_s)

    def collect(self, worker, asked, here, jobs, waiting, results, raised):
        """Takes what a worker has answered; one that is lost or silent has its job made elsewhere."""
        status = asked.future.status
        lost = worker not in here or status in ("cancelled", "lost")
        if not lost and status == "pending" and time.monotonic() < asked.until:
            return
        del self.asked[worker]
        error = None
        if status == "finished":
            try:
                result = asked.future.result(timeout=LEAST_S)
                lost = False  # it ended afterwards
                if isinstance(result, _Failed):
                    error, text = result.error, result.text
            except Exception as problem:  # lost on the way
                lost, error = True, problem
        elif status == "error" and not lost:
            error = asked.future.exception()
            text = f"{type(error).__name__}: {error}"
            lost = type(error).__name__ == "KilledWorker"
        if status == "pending" or lost:
            self.ready.discard(worker)
            if lost:
                asked.future.cancel()
                self.count(asked.job, jobs)
            else:
                self.silent[worker] = asked
                self.late[asked.job] += 1
                self.say(f"worker {worker} does not answer: left out until it does")
            if asked.job is not None:
                self.remade += 1
                waiting.appendleft(asked.job)
        elif asked.job is None:
            self.admit(worker, error, None if error else result)
        elif error is None:
            results[asked.job] = result
        else:
            raised[asked.job] += 1
            waiting.append(asked.job)
            if raised[asked.job] == TRIES or jobs[asked.job].call != "_make" or isinstance(error, WorkerError):
                if jobs[asked.job].call == "_case":
                    raise SweepError(f"{jobs[asked.job].name}: {text}") from error
                raise error

    def count(self, job, jobs):
        """Counts a lost worker; what ends them one after the other would do so for ever."""
        self.lost[job] += 1
        if self.lost[job] < TRIES or (job is None and self.ready):
            return
        what = "the import of nereus" if job is None else jobs[job].name
        raise WorkerError(
            f"{what}: {TRIES} workers ended at it, out of memory or by a crash (their logs say which); "
            "remedy: fewer workers with more threads, or more memory for each"
        )

    def admit(self, worker, error, answer):
        """Lets a worker take part that has the same package."""
        why, version = (str(error), None) if error else answer
        if why:
            raise WorkerError(f"worker {worker} cannot import nereus: {why}; allowed: nereus {VERSION} with its dask extra on every worker")
        if version != VERSION:
            raise WorkerError(f"worker {worker} has nereus {version}; allowed: {VERSION}, as here")
        self.ready.add(worker)
        del self.lost[None]

    def show(self, done, total, begun):
        left = (time.monotonic() - begun) * (total - done) / done if done else None
        self.say(f"{done} of {total}, {len(self.asked)} workers" + (f", about {_span(left)} left" if left else ""), stay=False)


def _labelled(keys, cases, results):
    """Results of all combinations as one xarray object."""
    import xarray as xr

    tables = [result if isinstance(result, dict) else {None: result} for result in results]
    sizes = [len(values) for values in keys.values()]
    coords = {key: (key, np.asarray(values) if np.ndim(values[0]) == 0 and not isinstance(values[0], dict) else np.arange(len(values))) for key, values in keys.items()}
    shapes = [{name: np.shape(value) for name, value in table.items()} for table in tables]
    for case, shape in zip(cases, shapes):
        if shape != shapes[0]:
            one, first = (f"shape {of[None]}" if None in of else f"{of}" for of in (shape, shapes[0]))
            raise InputError(f"case {case} returned {one}, case {cases[0]} {first}; allowed: the same names and shapes for all")
    arrays = {}
    for name, first in tables[0].items():
        values = []
        for case, table in zip(cases, tables):
            different = _difference(table[name], first)
            if different:
                raise InputError(f"case {case} returned {name or 'a result'} of other {different} than the first case; allowed: the same for all, in the same order")
            values.append(np.asarray(table[name]))
        dims, own = [f"{name or 'result'}_{k}" for k in range(np.ndim(first))], {}
        if isinstance(first, xr.DataArray):
            dims, own = list(first.dims), {k: v for k, v in first.coords.items()}
        data = np.stack(values).reshape(*sizes, *np.shape(first))
        arrays[name] = xr.DataArray(data, {**coords, **own}, [*keys, *dims], name=name)
    return arrays[None] if None in arrays else xr.Dataset(arrays)


def _difference(one, first):
    """What two results of the same shape are labelled by differently; None of the same."""
    import xarray as xr

    if not isinstance(one, xr.DataArray) and not isinstance(first, xr.DataArray):
        return None
    if getattr(one, "dims", None) != getattr(first, "dims", None):
        return f"dimensions ({', '.join(map(str, getattr(one, 'dims', ()))) or 'none'})"
    for name in sorted(one.coords.keys() | first.coords.keys(), key=str):
        if name not in one.coords or name not in first.coords or not one.coords[name].equals(first.coords[name]):
            return f"coordinates ({name})"
    return None
