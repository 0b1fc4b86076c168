"""Arms calibrated per minute, by processes and by a Dask cluster of the same size, in one run.

    python benchmarks/fleet.py [--arms 1000] [--method paper]

Simulated Pandas, each with origins of its own, 2 x 30 samples at two placements, one held out. All
are calibrated by one process, by all cores, and by as many workers of a local Dask cluster, one of
which is killed on the way in a further run. All must give the same errors to the last digit.
"""

import argparse
import os
import signal
import threading
import time
from functools import partial

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import mukca
from mukca.tools.workers import Workers


def arm(method: str, seed: int) -> tuple[float, float]:
    """Return the errors of one simulated arm at the placement held out: nominal, calibrated."""
    robot = mukca.load_robot("panda")
    _, (train, test) = mukca.simulate_recordings(robot, 2, seed=seed, noise=5e-5)
    summary = mukca.calibrate(robot, train, test=test, method=method).errors.summary.test
    assert summary is not None
    return summary.nominal.mean_absolute_error, summary.loaded.mean_absolute_error


def timed(workers: Workers, method: str, arms: int) -> tuple[list[tuple[float, float]], float]:
    begin = time.perf_counter()
    errors = workers.map(partial(arm, method), range(arms))
    return errors, time.perf_counter() - begin


def told(name: str, arms: int, seconds: float, than: float | None = None) -> None:
    ratio = "" if than is None else f"   {100 * (seconds / than - 1):+.1f} % against the processes"
    print(f"{name:34s} {60 * arms / seconds:7.1f} arms/min{ratio}", flush=True)


def kill_one(client: "object", after: float) -> None:
    """Kill the process of one worker of the cluster."""
    time.sleep(after)
    pids = client.run(os.getpid)  # type: ignore[attr-defined]
    os.kill(next(iter(pids.values())), signal.SIGKILL)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, default=1000)
    parser.add_argument("--method", choices=("auto", "paper"), default="auto")
    arguments = parser.parse_args()
    from distributed import Client, LocalCluster

    arms, method, cores = arguments.arms, arguments.method, os.cpu_count() or 1
    count = max(1, arms // cores)
    few, seconds = timed(Workers(1), method, count)
    told(f"1 process ({count} arms)", count, seconds)
    errors, by_processes = timed(Workers(cores), method, arms)
    told(f"{cores} processes", arms, by_processes)
    assert errors[:count] == few
    with (
        LocalCluster(n_workers=cores, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        address = cluster.scheduler_address
        same, by_cluster = timed(Workers(cluster=address), method, arms)
        told(f"Dask, {cores} workers", arms, by_cluster, by_processes)
        assert same == errors
        threading.Thread(target=kill_one, args=(client, by_cluster / 3), daemon=True).start()
        same, seconds = timed(Workers(cluster=address), method, arms)
        told("the same, a worker killed", arms, seconds, by_processes)
        assert same == errors
    means = 1e3 * np.mean(errors, axis=0)
    print(f"all {arms} arms the same each time; off by {means[0]:.2f} mm before, "
          f"{means[1]:.3f} mm after, on average")  # fmt: skip


if __name__ == "__main__":
    main()
