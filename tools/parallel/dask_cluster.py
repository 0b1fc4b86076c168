"""Independent pieces of work on a Dask cluster, whose workers may be on other computers."""

import time
from collections.abc import Callable, Generator, Sequence
from functools import partial
from importlib.metadata import version
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
        hand_over = partial(_hand_over, client, partial(share, work, SHARE_SECONDS), items)
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


def _hand_over(
    client: Any, work: Any, items: Sequence[Any], pieces: Sequence[int], size: int
) -> dict[Any, Sequence[int]]:
    """Cut pieces to shares of a size, and return which are in whose future."""
    shares = [pieces[i : i + size] for i in range(0, len(pieces), size)]
    futures = client.map(work, [[items[i] for i in share] for share in shares], pure=False)
    return dict(zip(futures, shares, strict=True))


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
