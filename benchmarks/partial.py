"""One thing fitted with the calibrated chain held: the figures of docs/hold.md.

python benchmarks/partial.py rezero --recordings DIR    5 mrad put into a real arm (panda_3)
python benchmarks/partial.py together --seat 0.05       all zeros lost at once, simulated arms
python benchmarks/partial.py together --planned         the same, poses by record --calibration
python benchmarks/partial.py changes --recordings DIR   0.5 and 1 mrad: told or not (--draws 2)
python benchmarks/partial.py changes --robot ur5e       the same of simulated arms (--planned)
python benchmarks/partial.py tool --robot ur5e          a tip's spread elsewhere, simulated arms
python benchmarks/partial.py handeye                    a board's elsewhere, simulated arms
python benchmarks/partial.py tracker --recordings DIR   a real tool and base by 8 poses (ur10)

What these decide and state of changed zeros, boards and outliers: doubts.py beside it.

Simulated arms bend and wind, their ball sits to 0.05 to 0.1 mm an axis, and 30 + 30 samples at each
of two bases calibrate them, 50 mm between the sockets. --first and --draws split a run: figures are
root mean squares, so those of equal portions are pooled by their squares.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from pathlib import Path

import numpy as np
from worlds import TRANSLATION, TURN, realistic_flaws

import mukca
from mukca.recorder import Sample, read_table_placement
from mukca.solver.calibration import FullModel, quaternion_of
from mukca.solver.design import Reach, plan_poses
from mukca.solver.identification.data import CALIPER_DEVIATION, Pose, hand_eye, measure
from mukca.solver.identification.robot import BallModel, Origin, rotation_vectors, turn
from mukca.solver.partial import identifiable_zeros, zero_covariance
from mukca.solver.poses import InverseKinematics
from mukca.solver.results import CalibratedRobot
from mukca.tools.simulation import Base, Imperfection, perturb, reachable_bases, record

TRAINED = ("frontcenter", "backleft")
PUT_IN = 5e-3
Fresh = tuple[mukca.Calibration, mukca.Placement]
"""A calibration, and samples at a placement that it was not calibrated at."""


def rezero(folder: Path, draws: int) -> Iterator[str]:
    """Zeros put into held-out samples of a real arm, 6 in each socket."""
    placements = mukca.read_placements(folder)
    train = [p for p in placements if p.name.endswith(TRAINED)]
    others = [p for p in placements if p not in train]
    calibration = mukca.calibrate(mukca.load_robot(folder / "nominal.urdf"), train)
    names, generator = calibration.robot.joint_names, np.random.default_rng(0)
    wrong = 0
    found: dict[int, list[tuple[float, float, bool]]] = {
        j: [] for j in range(1, len(names) - 1)
    }
    for draw in range(draws):
        since = few(others[draw % len(others)], 6, generator)
        wrong += bool(mukca.rezero(calibration, since).changed)
        for j, rows in found.items():
            q = since.positions - PUT_IN * np.eye(len(names))[j]
            moved = mukca.Placement.of_arrays(
                "since", q, since.sockets, names, distance=0.05
            )
            told = [one.joint for one in mukca.rezero(calibration, moved).changed]
            zero = mukca.rezero(calibration, moved, [names[j]]).joints[j]
            rows.append(
                (zero.offset - PUT_IN, zero.standard_deviation, told == [names[j]])
            )
    yield f"none put in: some named in {wrong} of {draws}"
    for j, rows in found.items():
        rms = (sum(off**2 for off, _, _ in rows) / draws) ** 0.5
        stated = sum(deviation for _, deviation, _ in rows) / draws
        yield (
            f"{names[j]}: rms {1e3 * rms:.2f} mrad, stated {1e3 * stated:.2f}, "
            f"named in {sum(told for _, _, told in rows)} of {draws}"
        )


def changes(cases: Iterator[Fresh], generator: np.random.Generator) -> Iterator[str]:
    """Changes told, none, 0.5 or 1 mrad put into each joint but the first and last."""
    told = {0.0: [0, 0], 5e-4: [0, 0], 1e-3: [0, 0]}
    for calibration, placement in cases:
        since, names = few(placement, 6, generator), calibration.robot.joint_names
        for size, counts in told.items():
            for j in range(1, len(names) - 1) if size else [0]:
                q = since.positions - size * np.eye(len(names))[j]
                moved = mukca.Placement.of_arrays(
                    "since", q, since.sockets, names, distance=0.05
                )
                counts[0] += (
                    mukca.what_changed(calibration, moved).verdict.exit_status == 1
                )
                counts[1] += 1
    yield ", ".join(f"{1e3 * size:g} mrad: {a} of {b}" for size, (a, b) in told.items())


def recorded(folder: Path, draws: int) -> Iterator[Fresh]:
    """Yield a real arm calibrated by each pair of its placements, and each of the others."""
    placements, robot = (
        mukca.read_placements(folder),
        mukca.load_robot(folder / "nominal.urdf"),
    )
    for pair in combinations(placements, 2):
        calibration = mukca.calibrate(robot, list(pair))
        for placement in [p for p in placements if p not in pair for _ in range(draws)]:
            yield calibration, placement


def tracker(folder: Path, draws: int) -> Iterator[str]:
    """Errors of a real arm's probe: the chain by 150 positions, probe and tracker by 8 poses."""
    points, poses = (
        read_table_placement(folder / f"{kind}.csv") for kind in ("points", "poses")
    )
    robot, found = mukca.load_robot("ur10"), list[tuple[float, float]]()
    for draw in range(draws):
        order = np.random.default_rng(draw).permutation(len(poses.samples)).tolist()
        calibration = mukca.calibrate(robot, picked(points, order[:150]))
        result = mukca.handeye(calibration, picked(poses, order[150:158]), "beside")
        rest = replace(picked(poses, order[158:]), poses_of="camera")
        measured = measure(rest, robot, poses_of="camera")
        T, own = (
            result.calibration.flange(measured.positions),
            Pose.of(result.frame.origin),
        )
        at = T[:, :3, :3] @ result.target.translation + T[:, :3, 3]
        away = np.linalg.norm(at - own.apply(result.size * measured.points), axis=1)
        R = T[:, :3, :3] @ result.target.rotation
        off = rotation_vectors(
            R @ (own.rotation @ measured.rotations).transpose(0, 2, 1)
        )
        found.append((float(away.mean()), float(np.linalg.norm(off, axis=1).mean())))
    place, angle = 1e3 * np.mean(found, axis=0)
    yield f"tool at the other poses: mean {place:.3f} mm, {angle:.2f} mrad"


def picked(placement: mukca.Placement, rows: list[int]) -> mukca.Placement:
    """Return some samples of a placement."""
    samples = tuple(placement.samples[i] for i in sorted(rows))
    return replace(placement, samples=samples, files=())


def few(
    placement: mukca.Placement, count: int, generator: np.random.Generator
) -> mukca.Placement:
    """Return some samples of each socket of a placement."""
    sockets = placement.sockets
    rows = np.concatenate(
        [
            generator.choice(np.flatnonzero(sockets == k), count, replace=False)
            for k in (0, 1)
        ]
    )
    q, names = placement.positions[rows], placement.joint_names
    return mukca.Placement.of_arrays("since", q, sockets[rows], names, distance=0.05)


@dataclass(frozen=True)
class Drawn:
    """A simulated arm that bends, and its calibration by 2 x (30 + 30) samples."""

    arm: mukca.Robot
    how: Imperfection
    calibration: mukca.Calibration

    @property
    def truth(self) -> CalibratedRobot:
        """The true arm, by its readings."""
        return CalibratedRobot(self.arm, (), np.zeros(0), self.how.deflection)

    def carrying(self, tip: np.ndarray) -> mukca.Robot:
        """Return the true arm with its ball at a tip on the flange [m]."""
        ball = self.arm.ball_joint
        joint = replace(ball, origin=Origin.of([*tip, *ball.origin.rpy]))
        return replace(self.arm, joints=(*self.arm.joints[:-1], joint))


Arms = Iterator[tuple[Drawn, np.random.Generator]]


def drawn(name: str, draws: range, seat: float | None) -> Arms:
    """Yield simulated arms; their ball's seat is drawn where None is given [m]."""
    robot = mukca.load_robot(name)
    for draw in draws:
        generator = np.random.default_rng([7, draw])
        arm = perturb(robot, generator, TRANSLATION, TURN)
        how = realistic_flaws(robot, generator)
        how = how if seat is None else replace(how, noise=seat)
        bases = reachable_bases(arm, generator, 2)
        train = [record(arm, base, generator, imperfection=how) for base in bases]
        yield Drawn(arm, how, mukca.calibrate(robot, train)), generator


def simulated(arms: Arms, *, plan: bool) -> Iterator[Fresh]:
    """Yield simulated arms, each at three bases that it was not calibrated at."""
    for one, generator in arms:
        for base in reachable_bases(one.arm, generator, 3):
            if plan:
                yield one.calibration, planned(one, base, generator, 6)
            else:
                yield (
                    one.calibration,
                    record(one.arm, base, generator, imperfection=one.how),
                )


class Planned(InverseKinematics):
    """A hand that leads an arm to planned poses, as near as the ball's seat lets it."""

    def __init__(self, robot: mukca.Robot, poses: np.ndarray) -> None:
        super().__init__(robot)
        self.poses = poses

    def reach(
        self, points: np.ndarray, generator: np.random.Generator, rounds: int = 40
    ) -> np.ndarray:
        """Return the planned poses with the ball at each point."""
        q = self.poses
        for _ in range(8):
            pose, J = self.ball_and_neck(q)
            q = (
                q
                + (np.linalg.pinv(J[:, :3]) @ (points - pose[:, :3])[:, :, None])[
                    :, :, 0
                ]
            )
        return q


def planned(
    one: "Drawn", base: Base, generator: np.random.Generator, count: int
) -> mukca.Placement:
    """Return samples at the poses that ``mukca record --calibration`` leads to."""
    reach, known = Reach(one.arm), zero_covariance(one.calibration)
    pools = {k: reach.poses(base.sockets[k], 600) for k in (0, 1)}
    away = (base.sockets[1] - base.sockets[0]) / base.distance
    known = known.with_lengths({0: -away, 1: away}, CALIPER_DEVIATION)
    order = [0] * count + [1] * count
    guide = Planned(
        one.arm, plan_poses(known, identifiable_zeros(known, pools), pools, order)
    )
    return record(
        one.arm, base, generator, samples=count, imperfection=one.how, guide=guide
    )


def together(arms: Arms, *, plan: bool) -> Iterator[str]:
    """Zeros of all joints but the first and last, 10 mrad put into each at once."""
    rows: dict[int, list[tuple[float, float, bool]]] = {6: [], 10: []}
    for one, generator in arms:
        joints = one.arm.joint_names
        size = 1e-2 * generator.choice([-1, 1], len(joints))
        size[[0, -1]] = 0.0
        (base,) = reachable_bases(one.arm, generator, 1)
        since = record(one.arm, base, generator, samples=10, imperfection=one.how)
        for count, found in rows.items():
            some = (
                planned(one, base, generator, count)
                if plan
                else few(since, count, generator)
            )
            q = some.positions - size
            moved = mukca.Placement.of_arrays(
                "since", q, some.sockets, joints, distance=0.05
            )
            named = mukca.rezero(one.calibration, moved, joints[1:-1]).joints[1:-1]
            told = [zero.joint for zero in mukca.rezero(one.calibration, moved).changed]
            right = told == list(joints[1:-1])
            found += [
                (zero.offset - put, zero.standard_deviation, right)
                for zero, put in zip(named, size[1:-1].tolist(), strict=True)
            ]
    for count, found in rows.items():
        off, stated, told = 1e3 * np.mean(np.square(found), axis=0) ** 0.5
        yield (
            f"{count} + {count} samples: rms {off:.3f} mrad, stated {stated:.3f}, all named in "
            f"{told**2 / 1e4:.0f} %"
        )


def tool(arms: Arms) -> Iterator[str]:
    """Scatter of a tip about points elsewhere, found by 4, 8 and 12 touches of one point."""
    rows: dict[int, list[tuple[float, ...]]] = {4: [], 8: [], 12: []}
    beyond = np.array([0.02, -0.03, 0.12])
    for one, generator in arms:
        tip = beyond + one.arm.ball_joint.origin.xyz
        arm = one.carrying(tip)
        first, *others = reachable_bases(arm, generator, 4)
        still, seated = (replace(one.how, noise=noise) for noise in (0.0, 1e-4))
        later = [
            record(arm, b, generator, samples=8, imperfection=still) for b in others
        ]
        q = np.concatenate([p.positions for p in later]).reshape(6, 8, -1)
        touched = record(
            arm, first, generator, samples=12, imperfection=seated
        ).positions
        for count, found in rows.items():
            touches = mukca.Placement.of_arrays("touches", touched[:count], [0] * count)
            result = mukca.tool(one.calibration, touches)
            full = scatter(result.calibration.flange(q, tool="tool")[..., :3, 3])
            alone, nominal = (
                scatter(by_urdf(robot, touched[:count], q))
                for robot in (exported(one.calibration), one.calibration.robot)
            )
            found.append((full, result.elsewhere or 0.0, alone, nominal))
    for count, found in rows.items():
        full, stated, *others = 1e3 * np.mean(np.square(found), axis=0) ** 0.5
        yield (
            f"{count} touches: {full:.3f} mm (stated {stated:.3f}), calibrated.urdf "
            f"{others[0]:.2f}, nominal {others[1]:.2f}"
        )


def handeye(arms: Arms) -> Iterator[str]:
    """Scatter of a board elsewhere, seen by a camera on the arm found by 8, 15 and 30 views."""
    rows: dict[int, list[tuple[float, float, float]]] = {8: [], 15: [], 30: []}
    X = matrix(turn(np.array([0.1, -0.2, 0.4])), np.array([0.05, -0.02, 0.06]))
    for one, generator in arms:
        truth = FullModel(one.truth)
        first, *others = (
            base.centre for base in reachable_bases(one.arm, generator, 4)
        )
        q, seen = views(truth, X, first, 30, generator)
        noisy = [
            matrix(
                turn(generator.normal(0, 1e-3, 3)) @ B[:3, :3],
                B[:3, 3] + generator.normal(0, 3e-4, 3),
            )
            for B in seen
        ]
        later = [views(truth, X, centre, 8, generator) for centre in others]
        for count, found in rows.items():
            result = mukca.handeye(
                one.calibration, board(q[:count], noisy[:count]), "on-arm"
            )
            known, size = result.calibration, np.diag([*[result.size] * 3, 1.0])
            tips = np.array(
                [known.flange(own, tool="camera") @ size @ B for own, B in later]
            )
            errors = [scatter(tips[..., :3, 3])]
            for robot in (exported(one.calibration), one.calibration.robot):
                model = FullModel(CalibratedRobot(robot, (), np.zeros(0)))
                F, M = model.flange(q[:count]), np.linalg.inv(noisy[:count])
                start = hand_eye(F[:, :3, :3], F[:, :3, 3], M[:, :3, :3], M[:, :3, 3])
                U = matrix(start.tool.rotation, start.tool.translation)
                tips = np.array([model.flange(own) @ U @ B for own, B in later])
                errors.append(scatter(tips[..., :3, 3]))
            found.append((errors[0], errors[1], errors[2]))
    for count, found in rows.items():
        full, alone, nominal = 1e3 * np.mean(np.square(found), axis=0) ** 0.5
        yield (
            f"{count} views: {full:.2f} mm, calibrated.urdf {alone:.2f}, nominal {nominal:.2f}"
        )


def matrix(R: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the pose [R p; 0 1]."""
    return np.block([[R, p[:, None]], [np.zeros(3), 1.0]])


def views(
    arm: FullModel,
    X: np.ndarray,
    centre: np.ndarray,
    count: int,
    generator: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """Return readings at which a camera sees a board from above, and the board in the camera."""
    down = np.diag([1.0, -1.0, -1.0])
    board, found = matrix(np.eye(3), centre), list[tuple[np.ndarray, np.ndarray]]()
    while len(found) < count:
        lean = turn(generator.uniform(-0.6, 0.6, 3) * [1, 1, 2])
        R = lean @ down
        camera = matrix(R, centre - R @ [0, 0, generator.uniform(0.25, 0.45)])
        try:
            q = arm.command(camera, tool=X)
        except mukca.MukcaError:
            continue
        found.append((q, np.linalg.inv(camera) @ board))
    return np.array([q for q, _ in found]), np.array([B for _, B in found])


def board(q: np.ndarray, poses: list[np.ndarray]) -> mukca.Placement:
    """Return poses of a board as a recording."""
    turns = quaternion_of(np.array(poses)[:, :3, :3]).tolist()
    rows = zip(q.tolist(), poses, turns, strict=True)
    samples = [
        Sample(tuple(own), 0, point=tuple(B[:3, 3].tolist()), orientation=tuple(R))
        for own, B, R in rows
    ]
    return mukca.Placement("views", tuple(samples))


def scatter(tips: np.ndarray) -> float:
    """Return the rms distance of tips from where each set of them is on average [m]."""
    apart = tips - tips.mean(axis=1, keepdims=True)
    return float(np.mean(np.sum(apart**2, axis=-1))) ** 0.5


def exported(calibration: mukca.Calibration) -> mukca.Robot:
    """Return the robot of ``calibrated.urdf``."""
    calibrated = calibration.calibrated
    joints = zip(calibration.robot.joints, calibrated.origins.tolist(), strict=True)
    moved = tuple(replace(joint, origin=Origin.of(own)) for joint, own in joints)
    return replace(calibration.robot, joints=moved)


def by_urdf(robot: mukca.Robot, touched: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return tips by a URDF alone, the tool by least squares to touches of one point."""

    def flanges(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        points = [
            BallModel(replace(robot, joints=(*robot.joints[:-1], ball)), []).points(
                np.zeros(0), rows
            )
            for ball in (
                replace(robot.ball_joint, origin=Origin.of([*place, 0, 0, 0]))
                for place in np.vstack([np.zeros(3), np.eye(3)])
            )
        ]
        return points[0], np.stack([one - points[0] for one in points[1:]], axis=2)

    p, R = flanges(touched)
    ones = np.tile(-np.eye(3), (len(p), 1, 1))
    unknowns = np.concatenate([R, ones], axis=2).reshape(-1, 6)
    tip = np.linalg.lstsq(unknowns, -p.ravel(), rcond=None)[0][:3]
    p, R = flanges(q.reshape(-1, q.shape[-1]))
    return (p + R @ tip).reshape(*q.shape[:-1], 3)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    what = ("rezero", "changes", "together", "tool", "handeye", "tracker")
    parser.add_argument("what", choices=what)
    parser.add_argument("--recordings", type=Path)
    parser.add_argument("--robot", default="panda")
    parser.add_argument(
        "--seat", type=float, help="the ball's, per axis [mm] (default: drawn)"
    )
    parser.add_argument(
        "--planned",
        action="store_true",
        help="of simulated arms: the poses that tell most",
    )
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument(
        "--first", type=int, default=0, help="the first draw of simulated arms"
    )
    given = parser.parse_args()
    seat = None if given.seat is None else 1e-3 * given.seat
    arms = drawn(given.robot, range(given.first, given.first + given.draws), seat)
    if given.what == "changes":
        real = given.recordings and recorded(given.recordings, given.draws)
        lines = changes(
            real or simulated(arms, plan=given.planned), np.random.default_rng(1)
        )
    elif given.what in ("rezero", "tracker"):
        run = {"rezero": rezero, "tracker": tracker}[given.what]
        lines = run(given.recordings, given.draws)
    else:
        run = {
            "tool": tool,
            "handeye": handeye,
            "together": partial(together, plan=given.planned),
        }
        lines = run[given.what](arms)
    name = given.robot if given.recordings is None else given.recordings.name
    for line in lines:
        print(f"{name}: {line}", flush=True)


if __name__ == "__main__":
    main()
