"""Arms calibrated per minute, by processes and by a Dask cluster of the same size, in one run.

    python benchmarks/fleet.py [--arms 1000] [--method paper] [--samples 8]

Simulated Pandas, each with origins of its own, recorded at two placements, one held out. All are
calibrated by one process, by two, four, ... up to all cores, and by as many workers of a local Dask
cluster, one of which is killed on the way in a further run. All must give the same errors to the
last digit. One arm is little work, so that what handing it over costs is seen.
"""

import argparse
import os
import signal
import threading
import time
from dataclasses import replace
from functools import partial

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import psutil

import mukca
from mukca.solver.robot.kinematics import BallModel
from mukca.solver.robot.urdf import Robot
from mukca.tools.simulated_arms import perturb
from mukca.tools.workers import Workers

NOISE = 5e-5


def recorded(
    robot: Robot, placements: list[mukca.Placement], samples: int, seed: int
) -> list[mukca.Placement]:
    """Return what an arm that is a little off reads, near poses that the nominal arm reads."""
    generator = np.random.default_rng(seed)
    model = BallModel(robot, range(robot.origins.size))
    origins = perturb(robot, generator, 2e-3, 5e-3).origins.ravel()
    results: list[mukca.Placement] = []
    for placement in placements:
        chosen = np.array([generator.permutation(30)[:samples] + 30 * k for k in (0, 1)]).ravel()
        kept = [placement.samples[i] for i in chosen]
        q = np.array([sample.position for sample in kept])
        seats = model.points(model.nominal, q) + generator.normal(0, NOISE, (len(q), 3))
        for _ in range(6):
            linear = model.linearise(origins, q)
            q += (np.linalg.pinv(linear.by_joints) @ (seats - linear.points)[:, :, None])[:, :, 0]
        read = (replace(s, position=tuple(row)) for s, row in zip(kept, q.tolist(), strict=True))
        results.append(replace(placement, samples=tuple(read)))
    return results


def arm(
    method: str, placements: list[mukca.Placement], samples: int, seed: int
) -> tuple[float, float]:
    """Return the errors of one simulated arm at the placement held out: nominal, calibrated."""
    robot = mukca.load_robot("panda")
    train, test = recorded(robot, placements, samples, seed)
    summary = mukca.calibrate(robot, train, test=test, method=method).errors.summary.test
    assert summary is not None
    return summary.nominal.mean_absolute_error, summary.loaded.mean_absolute_error


class Race:
    """The same arms again and again, by one kind of workers after the other."""

    def __init__(self, method: str, samples: int, arms: int) -> None:
        _, placements = mukca.simulate_recordings(
            mukca.load_robot("panda"), 2, translation=0, rotation=0, noise=0
        )
        self.work, self.arms = partial(arm, method, placements, samples), arms
        self.errors: list[tuple[float, float]] = []
        self.work(0)  # so that the first run finds everything loaded, too
        self.seconds: dict[str, float] = {}

    def run(self, name: str, workers: Workers, against: str | None = None) -> float:
        """Calibrate all arms, and tell how fast that was."""
        begin, cpu = time.perf_counter(), processor_seconds()
        errors = workers.map(self.work, range(self.arms))
        seconds = self.seconds[name] = time.perf_counter() - begin
        cpu = (processor_seconds() - cpu) / self.arms
        self.errors = self.errors or errors
        assert errors == self.errors, f"{name}: other errors than the first run's"
        ratio = f"   {self.seconds[against] / seconds:.2f} x {against}" if against else ""
        speed = f"{60 * self.arms / seconds:8.1f} arms/min, {1e3 * cpu:.0f} ms of processor each"
        print(f"{name:20s}{speed}{ratio}", flush=True)
        return seconds


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
    parser.add_argument("--samples", type=int, default=8, help="in each socket, at most 30")
    parser.add_argument("--method", choices=("auto", "paper"), default="paper")
    arguments = parser.parse_args()
    import dask
    from distributed import Client, LocalCluster

    # Dask's looks at itself take 5 % of this computer; on one that is a cluster alone, they may.
    dask.config.set({"distributed.worker.profile.enabled": False})
    dask.config.set({"distributed.admin.tick.interval": "1s"})
    cores = os.cpu_count() or 1
    race = Race(arguments.method, arguments.samples, arguments.arms)
    sizes = [1, *(2**k for k in range(1, 12) if 2**k < cores), cores]
    for count in dict.fromkeys(sizes):
        race.run(f"processes: {count}", Workers(count), "processes: 1" if count > 1 else None)
    all_cores = f"processes: {cores}"
    with (
        LocalCluster(n_workers=cores, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        workers = Workers(cluster=cluster.scheduler_address)
        seconds = race.run(f"Dask workers: {cores}", workers, all_cores)
        threading.Thread(target=kill_one, args=(client, seconds / 3), daemon=True).start()
        race.run("one of them killed", workers, all_cores)
    means = 1e3 * np.mean(race.errors, axis=0)
    print(f"all {race.arms} arms the same each time; off by {means[0]:.2f} mm before, "
          f"{means[1]:.3f} mm after, on average")  # fmt: skip


if __name__ == "__main__":
    main()
