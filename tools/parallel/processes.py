"""Independent pieces of work, done by the processes of this computer or by a Dask cluster.

The result of a piece of work depends on what it is given alone, seeds included, so it is the same
wherever it was done. A worker that is lost costs what it was doing, which another one does again.
"""

import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from multiprocessing.connection import wait
from typing import Any, TypeVar

from ...errors import MukcaError
from ...solver.calibration import UsageError

Item = TypeVar("Item")
Result = TypeVar("Result")
ANSWER_SECONDS = 10.0
"""Within this time a scheduler answers, and has a worker."""
ALONE_SECONDS = 30.0
"""A cluster may be without any worker for so long, for instance while they are started again."""
POLL_SECONDS = 0.02
LOOK_SECONDS = 2.0
SHARES = 32
"""To so many for each worker the work is cut at first."""
SHARE_SECONDS = 1.0
"""After this time a share is given back: handing one over costs 20 ms of processor time."""
COMPUTING = ("mukca", "numpy", "casadi")
"""Packages on which results depend."""


class WorkersLostError(MukcaError):
    """There is nobody left to do the work."""

    failed = True


def done_by_cluster(
    address: str, work: Callable[[Item], Result], items: Sequence[Item]
) -> Generator[tuple[int, Result]]:
    """Yield results as they come, see :meth:`.processes.Workers.map`."""
    try:
        from distributed import Client
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
        _check_workers(client, address)
        task = partial(share, work, SHARE_SECONDS)

        def hand_over(pieces: Sequence[int], size: int) -> dict[Any, Sequence[int]]:
            shares = [pieces[i : i + size] for i in range(0, len(pieces), size)]
            futures = client.map(task, [[items[i] for i in each] for each in shares], pure=False)
            return dict(zip(futures, shares, strict=True))

        size = 1 + len(items) // (1 + SHARES * sum(client.nthreads().values()))
        futures = hand_over(range(len(items)), size)
        try:
            yield from _gather(client, futures, hand_over)
        finally:
            client.cancel(list(futures), force=True)


def share(work: Callable[[Item], Result], seconds: float, items: Sequence[Item]) -> list[Result]:
    """Do pieces of work until the time is over, and at least one; return what is done."""
    end = time.monotonic() + seconds
    results = [work(items[0])]
    for item in items[1:]:
        if time.monotonic() > end:
            break
        results.append(work(item))
    return results


def _check_workers(client: Any, address: str) -> None:
    """Refuse a cluster without workers, or with workers that would compute something else."""
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


def _versions() -> dict[str, str]:
    return {name: version(name) for name in COMPUTING}


def _gather(
    client: Any,
    futures: dict[Any, Sequence[int]],
    hand_over: Callable[[Sequence[int], int], dict[Any, Sequence[int]]],
) -> Generator[tuple[int, Any]]:
    from distributed import KilledWorker, as_completed

    finished: Any = as_completed(futures, loop=client.loop)
    total = sum(map(len, futures.values()))
    looked = alive = time.monotonic()
    while futures:
        if not finished.has_ready():
            time.sleep(POLL_SECONDS)
            now = time.monotonic()
            if now - looked > LOOK_SECONDS:
                looked, alive = now, now if client.nthreads() else alive
            if now - alive > ALONE_SECONDS:
                raise WorkersLostError(
                    f"the cluster has had no worker for {ALONE_SECONDS:.0f} s, with "
                    f"{sum(map(len, futures.values()))} of {total} left to do"
                )
            continue
        for future in finished.next_batch(block=False):
            share = futures.pop(future)
            try:
                got = future.result()
            except KilledWorker:
                first, *rest = share
                which = f"pieces {first} to {rest[-1]}" if rest else f"piece {first}"
                raise WorkersLostError(
                    f"{which} of the work ended several workers: is their memory full?"
                ) from None
            future.release()  # a worker that is lost later takes no result with it
            yield from zip(share, got, strict=False)
            if rest := share[len(got) :]:  # in shares that fit into the time
                again = hand_over(rest, len(got))
                futures |= again
                finished.update(again)


MOST_LOSSES = 3
"""So often in a row may processes be lost without any piece of work done in between."""


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
        if self.cluster is not None:
            pairs = done_by_cluster(self.cluster, work, items)
        elif self.processes == 1 or len(items) < 2:
            pairs = ((i, work(item)) for i, item in enumerate(items))
        else:
            pairs = _done_by_processes(min(self.processes, len(items)), work, items)
        with closing(pairs):
            for i, result in pairs:
                results[i] = result
                done(i)
        return [results[i] for i in range(len(items))]


def _done_by_processes(
    processes: int, work: Callable[[Item], Result], items: Sequence[Item]
) -> Generator[tuple[int, Result]]:
    """Give the items to processes; where one is lost, begin anew with what is not done yet."""
    left = dict(enumerate(items))
    losses = 0
    while left:
        try:
            for i, result in _done_by_pool(processes, work, dict(left)):
                del left[i]
                losses = 0
                yield i, result
        except BrokenProcessPool:
            losses += 1
            if losses == MOST_LOSSES:
                raise WorkersLostError(
                    f"processes ended {losses} times without doing anything, with {len(left)} of "
                    f"{len(items)} left to do: is the memory full? Try fewer by --processes"
                ) from None


def _done_by_pool(
    processes: int, work: Callable[[Item], Result], items: Mapping[int, Item]
) -> Generator[tuple[int, Result]]:
    """Yield results as they come. Whatever ends it, no process is left behind."""
    others = set(multiprocessing.active_children())
    spawn = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(processes, spawn, _prepare, (os.getpid(),))
    try:
        futures = {pool.submit(work, item): i for i, item in items.items()}
        for future in as_completed(futures):
            yield futures[future], future.result()
    except BaseException:
        for child in set(multiprocessing.active_children()) - others:
            child.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _prepare(parent: int) -> None:
    """Leave Ctrl-C to the parent, and end when it ends, however it does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, args=(parent,), daemon=True).start()


def _end_with_parent(parent: int) -> None:
    process = multiprocessing.parent_process()
    if process is not None and process.pid == parent:
        wait([process.sentinel])
        sys.stderr.close()
        os._exit(1)
