"""Executors of the parts of a sweep: threads of this process, or any object with `submit`; handling of lost parts."""

import asyncio
import concurrent.futures
import logging
import queue
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, TypeVar

from rsc.errors import RscError, SolverError, one_line
from rsc.study.sweep.compute import LONGEST_REASON, Part, compute_part
from rsc.study.sweep.rows import LOST, MISSING, Rows, empty, joined, texts

# parts handed to somebody else's workers at a time: enough for thousands of workers, and some MB of values
IN_FLIGHT = 4096
POLL = 0.1  # s between looks at a future that does not call back
CONNECT = 10.0  # s to find a scheduler
Label = TypeVar("Label")
_NEVER_RAN = (concurrent.futures.CancelledError, asyncio.CancelledError)


class Executor(Protocol):
    """Anything that calls functions elsewhere: an executor of concurrent.futures, a dask client, submitit, executorlib, ..."""

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> Any:
        """A future: an object with `result()` and either `add_done_callback` or `done()`."""
        ...


@dataclass
class _Task:
    """A part on its way, or (place >= 0) a single case of one."""

    label: Any
    part: Part
    place: int = -1


@dataclass
class _Outcome:
    """What came back of a task: rows, or the problem; `ran` is False where no worker ever took it."""

    task: _Task
    rows: Rows | None
    problem: str = ""
    ran: bool = True


@dataclass
class _CaseByCase:
    """A part whose worker died, while its cases are computed one by one."""

    part: Part
    outcomes: list[_Outcome] = field(default_factory=list)

    @property
    def complete(self) -> bool:
        return len(self.outcomes) == len(self.part.values)

    def rows(self) -> Rows:
        """The rows of all cases, lost ones among them."""
        pieces = [([o.task.place], o.rows or without_rows(o, 1)) for o in self.outcomes]
        return joined(self.part.kind, len(self.part.values), pieces)


def run_parts(
    parts: Iterable[tuple[Label, Part]], executor: Executor, in_flight: int = IN_FLIGHT
) -> Iterator[tuple[Label, Rows, bool]]:
    """Compute parts and yield (label, rows, known) as they come, in any order.

    A part whose worker died is computed again case by case; a case whose worker dies again is lost: it keeps its row, with that
    status. `known` is False where the executor took no work any more, which says nothing about the cases: they are missing.

    Raises
    ------
    SolverError
        A worker that cannot compute: with other versions, or without rsc.
    """
    flight, tasks = _Flight(executor), (_Task(*pair) for pair in parts)
    alone: dict[Any, _CaseByCase] = {}
    for task in tasks:
        flight.submit(task)
        while len(flight) >= in_flight:
            yield from _landed(flight, alone)
    while len(flight):
        yield from _landed(flight, alone)


def _landed(flight: "_Flight", alone: dict[Any, _CaseByCase]) -> Iterator[tuple[Any, Rows, bool]]:
    """Wait for one task; the part that it completes, if it does."""
    outcome = flight.next()
    task = outcome.task
    if task.place >= 0:
        pieces = alone[task.label]
        pieces.outcomes.append(outcome)
        if pieces.complete:
            del alone[task.label]
            yield task.label, pieces.rows(), all(o.ran for o in pieces.outcomes)
    elif outcome.rows is not None:
        yield task.label, outcome.rows, True
    elif not outcome.ran:
        yield task.label, without_rows(outcome, len(task.part.values)), False
    else:
        alone[task.label] = _CaseByCase(task.part)
        for i, values in enumerate(task.part.values):
            flight.submit(_Task(task.label, replace(task.part, values=(values,)), i))


def without_rows(outcome: _Outcome, count: int) -> Rows:
    """Rows of cases without a result: "lost" if their worker died, otherwise "missing"."""
    status, reason = LOST if outcome.ran else MISSING, outcome.problem[:LONGEST_REASON]
    return empty(outcome.task.part.kind, count) | {"status": texts([status] * count), "reason": texts([reason] * count)}


class _Flight:
    """Tasks handed to an executor that have not come back."""

    def __init__(self, executor: Executor) -> None:
        self._executor, self._landed, self._polled = executor, queue.SimpleQueue[tuple[_Task, Any]](), list[tuple[_Task, Any]]()
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def submit(self, task: _Task) -> None:
        """Submit a task; a refusal by the executor becomes its outcome."""
        self._count += 1
        try:
            future = self._executor.submit(compute_part, task.part)
        except Exception as error:
            future = concurrent.futures.Future()
            future.set_exception(concurrent.futures.CancelledError(f"the executor takes no work: {_told(error)}"))
        if hasattr(future, "add_done_callback"):
            future.add_done_callback(lambda own: self._landed.put((task, own)))
        else:
            self._polled.append((task, future))

    def next(self) -> _Outcome:
        """Wait for a task to come back."""
        while True:
            for pair in [pair for pair in self._polled if pair[1].done()]:
                self._polled.remove(pair)
                self._landed.put(pair)
            try:
                task, future = self._landed.get(timeout=POLL)
            except queue.Empty:
                continue
            self._count -= 1
            return _outcome(task, future)


def _outcome(task: _Task, future: Any) -> _Outcome:
    try:
        return _Outcome(task, future.result())
    except (KeyboardInterrupt, SystemExit):
        raise
    except _NEVER_RAN as error:
        return _Outcome(task, None, _told(error), ran=False)
    except RscError:  # other versions: nothing that another try would mend
        raise
    except (ImportError, AttributeError) as error:
        raise SolverError(f"a worker cannot compute ({_told(error)}): must have the same rsc as this process") from None
    except BaseException as error:
        return _Outcome(task, None, f"its worker died ({_told(error)})")


def _told(error: BaseException) -> str:
    first = (str(error).strip().splitlines() or [""])[0]
    return one_line(f"{type(error).__name__}: {first}" if first else type(error).__name__)


@contextmanager
def own_threads(threads: int) -> Iterator[ThreadPoolExecutor]:
    """Threads of this process; leaving early does not wait for the parts that they are at."""
    pool = ThreadPoolExecutor(threads)
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


@contextmanager
def dask_client(address: str) -> Iterator[Executor]:
    """The workers of a dask scheduler at an address, or one that a scheduler file names.

    Whatever happens to it the sweep tells; the tracebacks that dask logs are silenced meanwhile.

    Raises
    ------
    SolverError
        Nothing answers within 10 s, or dask.distributed is not installed.
    """
    try:
        from distributed import Client
    except ImportError:
        raise SolverError("--scheduler needs dask.distributed: pip install \"rotor-stator-contact[cluster]\"") from None
    where = {"scheduler_file": address} if address.endswith(".json") else {"address": address}
    with _no_logs():
        try:
            client = Client(**where, timeout=CONNECT)
        except (OSError, TimeoutError, ValueError) as error:
            raise SolverError(f"{one_line(address)}: no dask scheduler answers within {CONNECT:g} s ({_told(error)})") from None
        try:
            yield client
        finally:
            client.close(timeout=CONNECT)


@contextmanager
def _no_logs() -> Iterator[None]:
    """Nothing is logged meanwhile."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)
