"""What handing work over costs: arms calibrated by processes and by Dask, in one run.

    python benchmarks/fleet.py [--arms 1000] [--method paper] [--samples 8]

Simulated Pandas, each with origins of its own, recorded at two placements, one held out. Overhead
is the time beyond that of plain loops: of one here, or, for all cores, of one in each of as many
processes side by side, which share the computer but hand nothing over. What it takes to start
processes or a cluster, once, is told apart. One of the Dask workers is killed on the way in a
further run. All runs must give the same errors to the last digit. One arm is little work,
so that what handing it over costs is seen.
"""

import argparse
import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MUKCA_CHECK_COVARIANCES", "1")

import numpy as np
import psutil

import mukca
from mukca.solver.identification.robot import BallModel, Robot
from mukca.tools.parallel import Workers
from mukca.tools.simulation import perturb

NOISE = 5e-5


def recorded(
    robot: Robot, placements: list[mukca.Placement], samples: int, seed: int
) -> list[mukca.Placement]:
    """Return what an arm that is a little off reads, near poses that the nominal arm reads."""
    generator = np.random.default_rng(seed)
    model = BallModel(robot, range(robot.origins.size))
    values = model.parameters_at(perturb(robot, generator, 2e-3, 5e-3).origins)
    results: list[mukca.Placement] = []
    for placement in placements:
        chosen = np.array(
            [generator.permutation(30)[:samples] + 30 * k for k in (0, 1)]
        ).ravel()
        kept = [placement.samples[i] for i in chosen]
        q = np.array([sample.position for sample in kept])
        seats = model.points(model.nominal, q) + generator.normal(0, NOISE, (len(q), 3))
        for _ in range(6):
            linear = model.linearise(values, q)
            q += (
                np.linalg.pinv(linear.by_joints) @ (seats - linear.points)[:, :, None]
            )[:, :, 0]
        read = (
            replace(s, position=tuple(row))
            for s, row in zip(kept, q.tolist(), strict=True)
        )
        results.append(replace(placement, samples=tuple(read)))
    return results


def arm(
    method: str, placements: list[mukca.Placement], samples: int, seed: int
) -> tuple[float, float]:
    """Return the errors of one simulated arm at the placement held out: nominal, calibrated."""
    robot = mukca.load_robot("panda")
    train, test = recorded(robot, placements, samples, seed)
    summary = mukca.calibrate(
        robot, train, test=test, method=method
    ).errors.summary.test
    assert summary is not None
    return summary.nominal.mean_absolute_error, summary.loaded.mean_absolute_error


def loop(
    work: Callable[[int], tuple[float, float]], arms: Sequence[int]
) -> tuple[float, float]:
    """Return how long a plain loop over some arms takes, and what it computes [s]."""
    work(arms[0])  # finds everything loaded from then on
    begin, cpu = time.perf_counter(), time.process_time()
    for seed in arms:
        work(seed)
    return time.perf_counter() - begin, time.process_time() - cpu


class Race:
    """The same arms again and again, by one kind of workers after the other."""

    def __init__(self, method: str, samples: int, arms: int) -> None:
        _, placements = mukca.simulate_recordings(
            mukca.load_robot("panda"), 2, translation=0, rotation=0, noise=0
        )
        self.work, self.arms = partial(arm, method, placements, samples), range(arms)
        self.errors: list[tuple[float, float]] = []
        self.cpu = 0.0

    def plain(self, loops: int) -> float:
        """Return how long so many loops take side by side, and print it."""
        shares = [self.arms[i::loops] for i in range(loops)]
        times = Workers(loops).map(partial(loop, self.work), shares)
        seconds, self.cpu = max(wall for wall, _ in times), sum(cpu for _, cpu in times)
        self._tell(
            "one plain loop" if loops == 1 else f"{loops} plain loops", seconds, ""
        )
        return seconds

    def processes(self, count: int, plain: float) -> None:
        """Calibrate all arms by processes, and tell what that costs beyond plain loops."""
        begin = time.perf_counter()
        Workers(count).map(self.work, self.arms[:count])
        start = time.perf_counter() - begin - plain * count / len(self.arms)
        seconds, cpu = self.run(Workers(count))
        self.overhead(f"{count} processes", seconds - start, cpu, plain, start)

    def dask(self, count: int, plain: float) -> None:
        """Calibrate all arms by a cluster of this computer, and again while a worker is killed."""
        from distributed import Client, LocalCluster

        begin = time.perf_counter()
        with (
            LocalCluster(
                n_workers=count, threads_per_worker=1, dashboard_address=None
            ) as cluster,
            Client(cluster, set_as_default=False) as client,
        ):
            workers = Workers(cluster=cluster.scheduler_address)
            # This loads everything there, too.
            workers.map(self.work, self.arms[:count])
            start = time.perf_counter() - begin - plain * count / len(self.arms)
            seconds, cpu = self.run(workers)
            self.overhead(f"{count} Dask workers", seconds, cpu, plain, start)
            if count > 1:
                threading.Thread(
                    target=kill_one, args=(client, seconds / 3), daemon=True
                ).start()
                self.overhead("one of them killed", *self.run(workers), plain)

    def run(self, workers: Workers) -> tuple[float, float]:
        """Calibrate all arms, and return how long it took, and the processor time [s]."""
        begin, cpu = time.perf_counter(), processor_seconds()
        errors = workers.map(self.work, self.arms)
        seconds, cpu = time.perf_counter() - begin, processor_seconds() - cpu
        self.errors = self.errors or errors
        assert errors == self.errors, "other errors than the first run's"
        return seconds, cpu

    def overhead(
        self, name: str, seconds: float, cpu: float, plain: float, start: float = 0.0
    ) -> None:
        """Print what was needed beyond plain loops: once started, and with the start."""
        words = f"   overhead {100 * (seconds / plain - 1):.1f} %"
        words += f" (of processor time {100 * (cpu / self.cpu - 1):.1f} %)"
        if start:
            total = 100 * ((seconds + start) / plain - 1)
            words += f", {total:.1f} % with the start of {start:.1f} s"
        self._tell(name, seconds, words)

    def _tell(self, name: str, seconds: float, words: str) -> None:
        speed = f"{60 * len(self.arms) / seconds:8.1f} arms/min"
        print(f"{name:20s}{speed}{words}", flush=True)


def processor_seconds() -> float:
    """Return what this process and all below it have computed: the same on a busy machine."""
    here = psutil.Process()
    return sum(sum(p.cpu_times()[:4]) for p in (here, *here.children(recursive=True)))


def kill_one(client: "object", after: float) -> None:
    """Kill the process of one worker of the cluster."""
    time.sleep(after)
    pids = client.run(os.getpid)  # type: ignore[attr-defined]
    os.kill(next(iter(pids.values())), signal.SIGKILL)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, default=1000)
    parser.add_argument(
        "--samples", type=int, default=8, help="in each socket, at most 30"
    )
    parser.add_argument("--method", choices=("auto", "paper"), default="paper")
    arguments = parser.parse_args()
    import dask

    # Dask's looks at itself take a tenth of such a fit. And by its default malloc returns memory at
    # once, and then asks for the same again: another tenth.
    dask.config.set({"distributed.worker.profile.enabled": False})
    dask.config.set({"distributed.admin.tick.interval": "1s"})
    malloc = {"MALLOC_TRIM_THRESHOLD_": 2**27, "MALLOC_MMAP_THRESHOLD_": 2**25}
    dask.config.set(
        {f"distributed.nanny.pre-spawn-environ.{k}": v for k, v in malloc.items()}
    )
    cores = os.cpu_count() or 1
    race = Race(arguments.method, arguments.samples, arguments.arms)
    for count in dict.fromkeys((1, cores)):
        plain = race.plain(count)
        if count > 1:
            race.processes(count, plain)
        race.dask(count, plain)
    means = 1e3 * np.mean(race.errors, axis=0)
    print(f"all {len(race.arms)} arms the same each time; off by {means[0]:.2f} mm before, "
          f"{means[1]:.3f} mm after, on average")  # fmt: skip


if __name__ == "__main__":
    main()
