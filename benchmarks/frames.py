"""Frames on simulated arms whose truth is known: exactness, intervals, and two arms face to face.

    python benchmarks/frames.py [--draws 50] [--robots panda so101 ...]

1. Without noise, every shipped robot: the ball in an instrument's frame, in a table's, in an
   anchored base, and one tool seen from another's, at sockets held out; the largest error. No more
   than 1e-8 m is left: exact samples are believed to 1e-7 m, so that priors pull a little.
2. With 0.1 mm of noise: how often the stated intervals hold the truth (68.3 and 95.0 %), with the
   standard error over the draws, since errors of one draw go together.
3. Two Pandas 1.2 m apart, 12 + 12 samples at shared placements: error of tool against tool.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from worlds import measured_points, recorded_by_both

from mukca.solver.bases import (
    TiedRobots,
    Visitor,
    base_to_base,
    common_places,
    places_alone,
    tie,
)
from mukca.solver.identification.data import (
    IDENTITY,
    WORLD,
    Pose,
    Samples,
    SocketAt,
    measure,
    observations_at,
)
from mukca.solver.identification.inference import estimate
from mukca.solver.identification.model import extend
from mukca.solver.identification.robot import (
    BallModel,
    Robot,
    choose_parameters,
    load_robot,
    shipped_robots,
    turn,
    workspace,
)
from mukca.solver.results import Measurements
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.parallel import Workers
from mukca.tools.simulation import Base, perturb, reachable_bases, record

USES = ("instrument", "table", "base")
FACING = Pose(turn(np.array([0.0, 0.0, np.pi])), np.array([1.2, 0.0, 0.0]))
"""Where the second of two Pandas stands seen from the first."""
PLACES = (
    (0.6, 0.0, 0.15),
    (0.55, 0.35, 0.3),
    (0.65, -0.35, 0.1),
    (0.58, 0.15, 0.2),
    (0.62, -0.15, 0.25),
)
"""Of the bases between them [m]; other arms stand in proportion to the length of their links."""
PANDA = 1.45
"""Length of a Panda's links [m]."""
ROOM = {"so100": 1.25}
"""By how much farther apart than that an arm must stand, to reach a base from above."""
EXACT = 1e-8
"""Standard deviation that is stated for exact coordinates and distances [m]."""


def fit(
    arms: Sequence[Measurements],
    at: Sequence[SocketAt] = (),
    deviation: float = 3e-5,
) -> TiedRobots:
    """Return the geometry of all arms, and the frames."""
    places, visitors = (
        common_places(arms, sockets_at=at, deviation=deviation),
        list[Visitor](),
    )
    for i, arm in enumerate(arms):
        alone, sockets = places_alone(places, arms, i)
        model, data = (
            extend(arm.robot, choose_parameters(arm.robot)),
            observations_at(alone, arm),
        )
        frame = places.frames.index(arm.base_frame) if i else WORLD
        posterior = estimate(model, data, joint_noise=False)
        visitors.append(Visitor(arm.name, frame, sockets, posterior))
    return tie(visitors, places)


def balls(arm: Robot, q: np.ndarray) -> np.ndarray:
    return BallModel(arm, []).points(np.empty(0), q)


def size_of(robot: Robot) -> float:
    """Return how large a robot is beside a Panda."""
    length = float(np.linalg.norm(robot.origins[:, :3], axis=1).sum())
    return ROOM.get(robot.name, 1.0) * length / PANDA


def seen(found: TiedRobots, i: int, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the balls of one robot in the world, and their slopes by all unknowns."""
    arm, frame = found.arms[i], found.robots[i].frame
    points, J, _ = arm.linearise(Samples.unloaded(q))
    slopes, pose = np.zeros((len(q), 3, len(found.around.mean))), found.poses[frame]
    begin = found.columns[i].start
    slopes[:, :, begin : begin + J.shape[2]] = pose.rotation @ J
    slopes[:, :, found.columns_of(frame)] = pose.slopes(points)
    return pose.apply(points), slopes


def deviations(found: TiedRobots, slopes: np.ndarray) -> np.ndarray:
    return np.linalg.norm(slopes @ found.around.root, axis=2)


def in_frame(
    found: TiedRobots, frame: Pose, arm: Robot, name: str, q: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return errors of the ball's place in a frame, and stated deviations."""
    points, slopes = seen(found, 0, q)
    if name in found.places.frames:
        k = found.places.frames.index(name)
        pose = found.poses[k]
        points = pose.inverse().apply(points)
        slopes[:, :, found.columns_of(k)] = -pose.slopes(points)
        slopes = pose.rotation.T @ slopes
    return points - frame.inverse().apply(balls(arm, q)), deviations(found, slopes)


def sockets_seen(
    bases: Sequence[Base],
    frame: Pose,
    generator: np.random.Generator,
    *,
    noise: float,
    deviation: float,
    name: str,
) -> list[SocketAt]:
    """Return coordinates of sockets in a frame that stands somewhere in the robot's base."""
    sockets: list[SocketAt] = []
    for base in bases:
        for socket, place in enumerate(frame.inverse().apply(np.array(base.sockets))):
            x, y, z = (place + generator.normal(0, 1, 3) * noise).tolist()
            sockets.append(SocketAt(name, (base.name, socket), (x, y, z), deviation))
    return sockets


def one_arm(
    robot: Robot, use: str, seed: int, noise: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return errors and stated deviations of one use by one arm.

    With noise anywhere in the workspace; without, at sockets held out, after more samples.
    """
    generator = np.random.default_rng(seed)
    arm = perturb(robot, generator, 2e-3, 5e-3)
    frame = (
        IDENTITY
        if use == "base"
        else Pose(turn(generator.uniform(-2, 2, 3)), generator.normal(0, 0.5, 3))
    )
    if use == "instrument":
        points = measured_points(arm, frame, generator, noise=noise)
        found = fit([Measurements(robot, [measure(points, robot)])])
        return in_frame(found, frame, arm, use, workspace(arm, 40, 7))
    bases = reachable_bases(arm, generator, 3 if noise else 6)
    samples = 12 if noise else 20
    placements = [
        record(arm, b, generator, samples=samples, noise=noise) for b in bases
    ]
    measured = [measure(replace(p, distance=None), robot) for p in placements]
    deviation = noise / 2 or EXACT
    at = sockets_seen(
        bases, frame, generator, noise=noise / 2, deviation=deviation, name=use
    )
    found = fit([Measurements(robot, measured)], at)
    if noise:
        return in_frame(found, frame, arm, use, workspace(arm, 40, 7))
    held = [
        record(arm, b, generator, samples=4) for b in reachable_bases(arm, generator, 3)
    ]
    q = np.concatenate([p.positions for p in held])
    return in_frame(found, frame, arm, use, q)


def two_arms(
    robots: Sequence[Robot], seed: int, noise: float, count: int = 3, samples: int = 12
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return how far one tool is from the other, by the fit, where they truly meet.

    Returns:
        Errors and stated deviations, shape (N, 3) [m], and the deviation that a user is told.
    """
    generator = np.random.default_rng(seed)
    arms = [perturb(robot, generator, 2e-3, 5e-3) for robot in robots]
    size = size_of(robots[0])
    poses = (IDENTITY, replace(FACING, translation=size * FACING.translation))
    bases = [
        Base(f"p{i}", size * np.array(place), np.array([np.cos(i), np.sin(i), 0.0]))
        for i, place in enumerate(PLACES[:count])
    ]
    held = [_between(bases, generator) for _ in range(6)]
    recorded = recorded_by_both(
        arms, poses, bases, generator, samples=samples, noise=noise
    )
    judged = recorded_by_both(arms, poses, held, generator, samples=4)
    found = fit(
        [
            Measurements(robot, [measure(p, robot) for p in own], name=name)
            for robot, own, name in zip(robots, recorded, "AB", strict=True)
        ],
        deviation=3e-5 if noise else EXACT,
    )
    a, b = (
        seen(found, i, np.concatenate([p.positions for p in own]))
        for i, own in enumerate(judged)
    )
    tools = base_to_base(found, 1).tool_deviation
    return (
        b[0] - a[0],
        deviations(found, b[1] - a[1]),
        np.nan if tools is None else tools,
    )


def _between(bases: Sequence[Base], generator: np.random.Generator) -> Base:
    """Return a base somewhere in the region of others."""
    shares = generator.dirichlet(np.ones(len(bases)))
    return replace(
        bases[0], name="held", centre=shares @ np.array([b.centre for b in bases])
    )


def exact(name: str) -> str:
    """Return a robot's largest errors of each use, without noise."""
    robot = load_robot(name)
    found = {use: one_arm(robot, use, 1, 0.0)[0] for use in USES}
    found["two arms"] = two_arms([robot, robot], 1, 0.0, 5, 20)[0]
    words = "  ".join(f"{use} {np.abs(off).max():.1e}" for use, off in found.items())
    return f"  {name:10s} {words}"


def shares_of(use: str, seed: int) -> list[float]:
    """Return how many errors of one draw lie within 1 and 1.96 stated deviations [%]."""
    panda = load_robot("panda")
    if use in USES:
        errors, stated = one_arm(panda, use, seed, 1e-4)
    else:
        errors, stated, _ = two_arms([panda, panda], seed, 1e-4)
    z = np.abs(errors / stated)
    return [100 * float(np.mean(z < limit)) for limit in (1.0, 1.96)]


def coverage(draws: int, workers: Workers) -> None:
    for use in (*USES, "two arms"):
        shares = workers.map(partial(shares_of, use), range(draws))
        (one, two), (d1, d2) = (
            np.mean(shares, axis=0),
            np.std(shares, axis=0) / draws**0.5,
        )
        print(
            f"{use}: {draws} draws, within 1 sigma {one:.1f} +- {d1:.1f} % (68.3), within "
            f"1.96 sigma {two:.1f} +- {d2:.1f} % (95.0)",
            flush=True,
        )


def met(count: int, samples: int, seed: int) -> tuple[np.ndarray, np.ndarray, float]:
    panda = load_robot("panda")
    return two_arms([panda, panda], seed, 1e-4, count, samples)


def face_to_face(draws: int, workers: Workers) -> None:
    for count, samples in ((3, 12), (2, 12), (3, 30), (2, 30)):
        found = workers.map(partial(met, count, samples), range(draws))
        off = np.concatenate([np.linalg.norm(errors, axis=1) for errors, _, _ in found])
        told = float(np.mean([tools for _, _, tools in found]))
        print(
            f"two Pandas, {count} placements of {samples} + {samples}: tool to tool "
            f"{1e3 * off.mean():.3f} mm on average, {1e3 * np.mean(off**2) ** 0.5:.3f} mm rms, "
            f"stated {1e3 * told:.3f} mm (rms)",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=50)
    parser.add_argument("--robots", nargs="*", default=list(shipped_robots()))
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    workers = read_options(arguments).workers
    print("exact: largest error in m", flush=True)
    print("\n".join(workers.map(exact, arguments.robots)), flush=True)
    if arguments.draws:
        coverage(arguments.draws, workers)
        face_to_face(max(1, arguments.draws // 5), workers)


if __name__ == "__main__":
    main()
