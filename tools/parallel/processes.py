"""Independent pieces of work, done by the processes of this computer or by a Dask cluster.

The result of a piece of work depends on what it is given alone, seeds included, so it is the same
wherever it was done. A worker that is lost costs what it was doing, which another one does again.
"""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from dataclasses import dataclass
from multiprocessing.connection import wait
from typing import TypeVar

from .dask_cluster import WorkersLostError, done_by_cluster

Item = TypeVar("Item")
Result = TypeVar("Result")
MOST_LOSSES = 3
"""So often in a row may processes be lost without any piece of work done in between."""


def _ignore(_: int) -> None:
    pass


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
        done: Callable[[int], None] = _ignore,
    ) -> list[Result]:
        """Do a piece of work for each item, and return the results in the items' order.

        Args:
            work: A function at the top of a module, or a ``functools.partial`` of one. What it
                raises ends all the work, and is raised here.
            items: What it is given, one by one.
            done: Told the index of each item as it is done, in whatever order.

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
    pool = ProcessPoolExecutor(
        processes, multiprocessing.get_context("spawn"), _prepare, (os.getpid(),)
    )
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
