"""Independent pieces of work, done by the processes of this computer or by a Dask cluster.

The result of a piece of work depends on what it is given alone, seeds included, so it is the same
wherever it was done. A worker that is lost costs what it was doing, which another one does again.
"""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Container, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, ProcessPoolExecutor
from concurrent.futures import wait as wait_for
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from multiprocessing import resource_tracker
from multiprocessing.connection import wait
from typing import Any, TypeVar

from ...errors import MukcaError
from ...solver.calibration import UsageError

Item = TypeVar("Item")
Result = TypeVar("Result")
ANSWER_SECONDS = 10.0
"""Within this time a scheduler answers, and has a worker."""
LOOK_SECONDS = 2.0
MOST_LOOKS = 15
"""Looks in a row that may find a cluster without any worker, as while they start again."""
MOST_LOSSES = 3
"""Losses of processes in a row without any piece of work done in between."""
SHARES = 32
"""Shares of the work for each worker, at least: handing one over costs 20 ms of processor time."""
COMPUTING = ("mukca", "numpy", "casadi")
"""Packages on which results depend."""


class WorkersLostError(MukcaError):
    """There is nobody left to do the work."""

    failed = True


@dataclass(frozen=True)
class Workers:
    """Who does the work."""

    processes: int = 1
    """Number of processes of this computer."""
    cluster: str | None = None
    """Address of a Dask scheduler, as in ``tcp://10.0.0.7:8786``, whose workers do it instead."""

    def map(
        self,
        work: Callable[[Item], Result],
        items: Sequence[Item],
        done: Callable[[int], object] = lambda _: None,
    ) -> list[Result]:
        """Do a piece of work for each item, and return the results in the items' order.

        ``work`` is a function at the top of a module, or a ``functools.partial`` of one; what it
        raises ends all the work, and is raised here. ``done`` is told the index of each item, in
        whatever order.

        Raises:
            WorkersLostError: Workers were lost again and again, or all of them.
            UsageError: No such cluster, or it has other versions of what computes.
        """
        results: dict[int, Result] = {}
        if self.cluster is None and (self.processes == 1 or len(items) < 2):
            for i, item in enumerate(items):
                results[i] = work(item)
                done(i)
        losses = 0
        while len(results) < len(items):
            before = len(results)
            try:
                with self._pool(len(items)) as pool:
                    for i, result in _gather(pool, work, items, results):
                        results[i] = result
                        done(i)
            except BrokenProcessPool:  # begin anew with what is not done yet
                losses = losses + 1 if len(results) == before else 1
                if losses == MOST_LOSSES:
                    raise WorkersLostError(
                        f"processes ended {losses} times without doing anything, with "
                        f"{len(items) - before} of {len(items)} left to do: is the memory full? "
                        "Try fewer by --processes"
                    ) from None
        return [results[i] for i in range(len(items))]

    def _pool(self, count: int) -> AbstractContextManager["_Pool"]:
        if self.cluster is not None:
            return _cluster(self.cluster)
        return _processes(min(self.processes, count))


@dataclass
class _Pool:
    """Workers that are there."""

    executor: Executor
    count: int
    workers: Callable[[], object] = lambda: True
    """False where there is no worker now."""
    lost: tuple[type[Exception], ...] = ()
    """Raised by a piece of work that ended several workers."""


def _gather(
    pool: _Pool,
    work: Callable[[Item], Result],
    items: Sequence[Item],
    completed: Container[int],
) -> Generator[tuple[int, Result]]:
    """Yield the results that are not known yet, with their indices, as they come."""
    waiting = [i for i in range(len(items)) if i not in completed]
    total, looks = len(waiting), 0
    size = 1 + total // (1 + SHARES * pool.count)
    shares = [waiting[i : i + size] for i in range(0, total, size)]
    with started_apart():
        futures = {
            pool.executor.submit(_do, work, [items[i] for i in share]): share
            for share in shares
        }
    while futures:
        finished, _ = wait_for(futures, LOOK_SECONDS, FIRST_COMPLETED)
        looks = 0 if finished or pool.workers() else looks + 1
        if looks > MOST_LOOKS:
            raise WorkersLostError(
                f"the cluster has had no worker for {looks * LOOK_SECONDS:.0f} s, with "
                f"{sum(map(len, futures.values()))} of {total} left to do"
            )
        for future in finished:
            share = futures.pop(future)
            try:
                results = future.result()
            except pool.lost:
                raise WorkersLostError(
                    f"piece {share[0]} of the work, or one of {len(share)} from there, ended "
                    "several workers: is their memory full?"
                ) from None
            yield from zip(share, results, strict=True)


def _do(work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    return [work(item) for item in items]


@contextmanager
def _cluster(address: str) -> Generator[_Pool]:
    """Workers of a Dask cluster; one without any, or of other versions, is refused."""
    try:
        from distributed import Client, KilledWorker
    except ImportError:
        raise UsageError("--cluster needs Dask: pip install 'mukca[cluster]'") from None
    try:
        client: Any = Client(address, timeout=ANSWER_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        raise UsageError(
            f"--cluster {address}: no Dask scheduler answers there ({type(error).__name__}); start "
            "one with `dask scheduler`, and `dask worker ADDRESS` on each computer"
        ) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=ANSWER_SECONDS)
        except TimeoutError:
            raise UsageError(
                f"--cluster {address}: it has no worker; start some with `dask worker {address}`"
            ) from None
        mine = _versions()
        for worker, theirs in client.run(_versions).items():
            for name in COMPUTING:
                if theirs[name] != mine[name]:
                    raise UsageError(
                        f"--cluster {address}: worker {worker} has {name} {theirs[name]}, here is "
                        f"{mine[name]}; install the same everywhere"
                    )
        executor: Executor = client.get_executor(pure=False)
        try:
            yield _Pool(
                executor,
                sum(client.nthreads().values()),
                client.nthreads,
                (KilledWorker,),
            )
        finally:
            executor.shutdown(wait=False)


def _versions() -> dict[str, str]:
    return {name: version(name) for name in COMPUTING}


@contextmanager
def _processes(count: int) -> Generator[_Pool]:
    """Processes of this computer. Whatever ends them, none is left behind."""
    children = set(multiprocessing.active_children())
    spawn = multiprocessing.get_context("spawn")
    executor = ProcessPoolExecutor(count, spawn, _prepare, (os.getpid(),))
    try:
        yield _Pool(executor, count)
    except BaseException:
        for child in set(multiprocessing.active_children()) - children:
            child.kill()
        raise
    finally:
        executor.shutdown(cancel_futures=True)


@contextmanager
def started_apart() -> Generator[None]:
    """Start processes that Ctrl-C does not reach; here it waits until they are started."""
    if sys.platform == "win32":
        yield
        return
    resource_tracker.ensure_running()  # which unblocks Ctrl-C when it is started
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _prepare(parent: int) -> None:
    """Leave Ctrl-C to the parent, and end when it ends, however it does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, args=(parent,), daemon=True).start()


def _end_with_parent(parent: int) -> None:
    process = multiprocessing.parent_process()
    if process and process.pid == parent:
        wait([process.sentinel])
        sys.stderr.close()
        os._exit(1)
