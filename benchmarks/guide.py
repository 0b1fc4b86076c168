"""What guiding is worth: sessions that stop by themselves against 30 + 30 poses.

    python benchmarks/guide.py                      24 simulated arms
    python benchmarks/guide.py --arms 6             fewer
    python benchmarks/guide.py --goal-mm 1          sessions that go on to, or stop at, this goal
    python benchmarks/guide.py --recordings DIR     choosing among the poses of real recordings
    python benchmarks/guide.py --enough --arms 4    ENOUGH of two placements, and what solve says
    python benchmarks/guide.py --travel --arms 5    how far a hand leads the arm from pose to pose
    python benchmarks/guide.py --curves --arms 3    error curves: errors by poses for these

With these three ``--arms`` are those of each robot, from the seed of ``--first`` on. From 300 on
ENOUGH was said of three seeds each of all 24 arms that are shipped, and of three more of koch,
panda, so101, ur5e and wxai (of so100 two of three); after it none was NOT ENOUGH.

A simulated arm differs from its model by 2 mm and 5 mrad a joint; each sample has 0.1 mm of noise.
The operator's travel from pose to pose, and so the spread of the poses, match real recordings:
about 0.8 rad root mean square a joint between consecutive poses. A guided operator hits the
proposed pose within 0.15 rad a joint. Both fit the same rigid model.

Errors of distances are root mean squares over pairs of poses in the workspace. Most of such an
error is one number, the arm's scale, which all distances share: it comes out anywhere within its
bell curve. So one arm says little about the gauge, and many are needed: each distance's error
over its predicted deviation is squared and averaged over all arms, and should come to 1.
"""

import argparse
import itertools
import os
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from worlds import realistic_flaws

from mukca.recorder import Placement, Sample, read_placements
from mukca.solver.assessment import repeatability_of
from mukca.solver.calibration import calibrate
from mukca.solver.design import (
    ParameterCovariance,
    from_fit,
    from_prior,
    workspace_of,
)
from mukca.solver.diagnostics import is_coarse
from mukca.solver.identification.data import (
    CALIPER_DEVIATION,
    RobotRecordings,
    measure,
    observe,
)
from mukca.solver.identification.effects import COMPLIANCE, CURVE, random_curves
from mukca.solver.identification.inference import Posterior, estimate
from mukca.solver.identification.model import Deflection, ExtendedModel, Noise, extend
from mukca.solver.identification.robot import (
    BallModel,
    Robot,
    choose_parameters,
    load_robot,
    shipped_robots,
    workspace,
)
from mukca.solver.poses import InverseKinematics
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.parallel import Workers
from mukca.tools.recording import PoseSelector
from mukca.tools.simulation import (
    Base,
    Imperfection,
    lead,
    perturb,
    reachable_bases,
    record,
)

NOISE = 1e-4
STEP = 0.8
"""How far a joint moves from one pose to the next, where nobody guides [rad]."""
AIM = 0.15
"""How far a joint is off the pose that was proposed [rad]."""


@dataclass
class Hand:
    """Leads a simulated arm, ball in socket."""

    arm: Robot
    generator: np.random.Generator
    noise: float = NOISE
    aim: np.ndarray | None = None
    """The pose that is led to by :meth:`reach`, shape (m,)."""

    def __post_init__(self) -> None:
        self.guide = InverseKinematics(self.arm)

    def reach(self, seats: np.ndarray, generator: np.random.Generator) -> np.ndarray:
        """Return poses near the aim, with the ball in some seats, shape (N, m)."""
        return np.array([self.lead(self.aim, seat, AIM) for seat in seats])

    def lead(
        self, q: np.ndarray | None, socket: np.ndarray, spread: float
    ) -> np.ndarray:
        """Return a pose near another, with the ball in a socket."""
        for _ in range(40 if q is not None else 0):
            start = q + self.generator.normal(0, spread, (8, len(q)))
            start = np.clip(start, self.guide.lower + 1e-3, self.guide.upper - 1e-3)
            pose, _ = self.guide.ball_and_neck(start)
            seats = np.tile(socket, (8, 1)) + self.generator.normal(0, self.noise, 3)
            found, arrived = self.guide._follow(
                start, np.concatenate([seats, pose[:, 3:]], axis=1)
            )
            leans = pose[:, 5] < -np.cos(np.deg2rad(55))
            good = arrived & leans & (np.abs(found - start).max(axis=1) < np.pi)
            if good.any():
                return found[good][0]
        seat = socket[None] + self.generator.normal(0, self.noise, 3)
        return self.guide.reach(seat, self.generator)[0]


def guided(
    hand: Hand, base: Base, coach: PoseSelector, most: int = 60
) -> tuple[list[Sample], float]:
    """Record until the coach has enough; return the samples and the gauge."""
    samples: list[Sample] = []
    socket, q, advice = 0, None, None
    while len(samples) < most:
        aim = q if advice is None or advice.target is None else np.array(advice.target)
        q = hand.lead(aim, base.sockets[socket], AIM if samples else STEP)
        samples.append(Sample(tuple(q.tolist()), socket, number=len(samples) + 1))
        advice = coach.advise(samples, socket, q)
        if advice.enough:
            return samples, advice.predicted
        if advice.leave:
            socket = 1 - socket
            advice = coach.advise(samples, socket, q)
    return samples, advice.predicted if advice else np.nan


def unguided(hand: Hand, base: Base, each: int = 30) -> list[Sample]:
    """Record as many as the paper did, walking from pose to pose."""
    samples: list[Sample] = []
    for socket in (0, 1):
        q = None
        for _ in range(each):
            q = hand.lead(q, base.sockets[socket], STEP)
            samples.append(Sample(tuple(q.tolist()), socket, number=len(samples) + 1))
    return samples


def fitted(robot: Robot, samples: list[Sample]) -> Posterior:
    placement = Placement("train", tuple(samples), robot.joint_names, 0.05)
    data = observe(RobotRecordings(robot, [measure(placement, robot)]))
    return estimate(extend(robot, choose_parameters(robot)), data).arm


def truth(arm: Robot, found: Posterior, test: Placement) -> tuple[float, float, float]:
    """Return the error held out, that of distances [m], and that over the predicted one."""
    q = test.positions
    balls = found.model.ball.points(found.values, q)
    errors = []
    for k in (0, 1):
        here = balls[test.sockets == k]
        errors += np.linalg.norm(here - here.mean(axis=0), axis=1).tolist()
    q = workspace(found.model.robot, 400)  # those of workspace_of
    true, said = (
        BallModel(arm, []).points(np.zeros(0), q),
        found.model.ball.points(found.values, q),
    )
    lengths = [np.linalg.norm(p[1::2] - p[::2], axis=1) for p in (true, said)]
    off = lengths[1] - lengths[0]
    predicted = from_fit(found).deviations(workspace_of(found.model, found.x))
    return float(np.mean(errors)), _rms(off), _rms(off / predicted)


SIXES = (*([0] * 6 + [1] * 6) * 2, *[0] * 3, *[1] * 3)
LOOKED = (22, 24, 27, 30)
"""Numbers of samples at which a session is asked for more than a pose."""


def enough(case: tuple[str, int]) -> tuple[int, bool, str]:
    """Return samples until ENOUGH at two places of 15 + 15, its scope, and what is missed then.

    No samples are none. A hand follows the session's poses and goes on after ENOUGH: from there on
    nothing may be missed, neither where it is asked again nor by a solving of both places.
    """
    name, seed = case
    robot = load_robot(name)
    generator = np.random.default_rng([seed, list(shipped_robots()).index(name), 6])
    zeros = is_coarse(repeatability_of(robot, None))
    arm = perturb(robot, generator, 2e-3, 5e-3, zeros=zeros)
    flaws = realistic_flaws(robot, generator)
    hand = Hand(arm, generator, noise=0.0)
    earlier: list[Placement] = []
    said, near, missed = 0, False, ""
    for base in reachable_bases(arm, generator, 2, 0.1):
        coach = PoseSelector(robot, base.distance, parts=earlier)
        samples: list[Sample] = []
        hand.aim = None
        for n, socket in enumerate(SIXES, 1):
            (read,) = lead(arm, base.sockets[socket][None], generator, flaws, hand)
            samples.append(Sample(tuple(read.tolist()), socket, number=n))
            here = Placement(
                base.name, tuple(samples), robot.joint_names, base.distance
            )
            following = SIXES[n % len(SIXES)]
            if n not in LOOKED:
                hand.aim = planned(coach, samples, following, read)
                continue
            advice = coach.advise(samples, following, read)
            hand.aim = None if advice.target is None else np.array(advice.target)
            if advice.enough and not said:
                said, near = n + sum(len(p.samples) for p in earlier), advice.near_only
            elif said and not advice.enough:
                missed = missing(robot, [*earlier, here]) or missed
        earlier.append(here)
    return said, near, (missing(robot, earlier) if said else "") or missed


def missing(robot: Robot, placements: list[Placement]) -> str:
    """Return what a solving says, if that is a FAIL or NOT ENOUGH DATA."""
    zeros = is_coarse(repeatability_of(robot, None)) or None
    verdict = calibrate(robot, placements, zeros=zeros).verdict
    if verdict.kind == "not_enough" or verdict.status in ("better", "fail"):
        counts = "+".join(str(len(p.samples)) for p in placements)
        return f"{counts} samples, {verdict.title}: {verdict.text}"
    return ""


def compare_enough(first: int, count: int, names: list[str], workers: Workers) -> None:
    cases = [(name, seed) for name in names for seed in range(first, first + count)]
    found = workers.map(enough, cases)
    for case, (_, _, missed) in zip(cases, found, strict=True):
        if missed:
            print(*case, missed)
    print(
        "arm           ENOUGH by 15 + 15 twice   samples until   near only   then NOT ENOUGH"
    )
    for i, name in enumerate([*names, "all"]):
        own = found[i * count : (i + 1) * count] or found
        said = [until for until, _, _ in own if until]
        near, no = (
            sum(near for _, near, _ in own),
            sum(bool(missed) for *_, missed in own),
        )
        print(f"{name:<14} {len(said):>10} of {len(own):<10} {np.median(said or [0]):>10.0f} "
              f"{near:>12} {no:>14}")  # fmt: skip


TRAVELLED = ("panda", "ur5e", "iiwa14", "xarm7")


ASKED = np.array([0.55, 0.65, 0.65, 4, 7, 70, 1.05, 1.10])
"""Of a plan's means over those of before: travel of the base joint, of the joint that travels most
and of all; steps of more than 120 degrees in the mean and at most, the median step [deg]; both
errors."""


def travel(case: tuple[str, int]) -> np.ndarray:
    """Return figures of 12 + 12 in sixes, planned, and of the nearest of the best, 12 and then 12.

    For each of both: travel of the base joint, of the joint that travels most, of all, steps of
    more than 120 degrees, the median step [deg], both errors, and steps with the ball lifted.
    """
    name, seed = case
    robot = load_robot(name)
    seeds = [seed, list(shipped_robots()).index(name)]
    generator = np.random.default_rng([*seeds, 4])
    arm = perturb(robot, generator, 2e-3, 5e-3)
    (base,) = reachable_bases(arm, generator, 1)
    model = extend(robot, choose_parameters(robot))
    anywhere = workspace_of(model, np.zeros(model.size))
    along = (base.sockets[1] - base.sockets[0]) / np.linalg.norm(
        base.sockets[1] - base.sockets[0]
    )
    figures = []
    for of, order in ((planned, SIXES[:24]), (nearest, sorted(SIXES[:24]))):
        hand = Hand(arm, np.random.default_rng([*seeds, 5]))
        coach = PoseSelector(robot, 0.05)
        samples: list[Sample] = []
        q, target, lifted = None, None, 0
        for socket, following in itertools.zip_longest(order, order[1:], fillvalue=1):
            spread = STEP if target is None else AIM
            q = hand.lead(q if target is None else target, base.sockets[socket], spread)
            samples.append(Sample(tuple(q.tolist()), socket, number=len(samples) + 1))
            target = of(coach, samples, following, q)
            stays = target is not None and socket == following
            lifted += stays and coach._pool.lifted(samples, q, target)
        known = from_prior(model, Noise(NOISE, 0.0), 2)
        known = known.with_lengths({0: -along, 1: along}, CALIPER_DEVIATION)
        for sample in samples:
            known = known.with_samples(np.array([sample.position]), sample.socket)
        own, shape = (
            known.covariance[: model.size, : model.size],
            anywhere.judged[:, 1:],
        )
        turned = np.rad2deg(np.abs(np.diff([s.position for s in samples], axis=0)))
        total, most = turned.sum(axis=0), turned.max(axis=1)
        figures.append(
            [total[0], total.max(), total.sum(), (most > 120).sum(), np.median(most),
             known.error(anywhere), np.sum(shape * (own @ shape)) ** 0.5, lifted]
        )  # fmt: skip
    return np.array(figures)


def planned(
    coach: PoseSelector, samples: list[Sample], socket: int, q: np.ndarray
) -> np.ndarray | None:
    """Return the next pose, all that ``coach.advise`` works out of one, shape (m,)."""
    known = knowledge(coach, samples)
    where = workspace_of(coach._model, known.x)
    target, _ = coach._next(known, where, samples, coach._order(samples, socket), q)
    return None if target is None else np.array(target)


def nearest(
    coach: PoseSelector, samples: list[Sample], socket: int, q: np.ndarray
) -> np.ndarray | None:
    """Return the nearest of the poses that teach nearly most; None before a socket's first."""
    poses = coach._pool.candidates(samples, socket)[:120]
    if not len(poses):
        return None
    known = knowledge(coach, samples)
    where = workspace_of(known.model, 0 * known.x)
    gains = known.variance_reduction(poses, socket, where)[1]
    far = np.abs(poses - q).max(axis=1)
    far[gains < 0.85 * gains.max()] = np.inf
    return poses[int(np.argmin(far))]


def knowledge(coach: PoseSelector, samples: list[Sample]) -> ParameterCovariance:
    return coach._covariance(samples, coach._fitted(samples))


def compare_travel(first: int, count: int, names: list[str], workers: Workers) -> None:
    cases = [(name, seed) for name in names for seed in range(first, first + count)]
    found = np.array(workers.map(travel, cases))
    ratios = found[:, 0] / found[:, 1].clip(1e-9)
    print("planned in sixes, and (but for steps) over the nearest of the best, 12 and then 12\n"
          "arm        base joint  worst joint  all joints  steps > 120 deg  at most  median step"
          "  error  without scale  lifted")  # fmt: skip
    rows = [(name, slice(i * count, (i + 1) * count)) for i, name in enumerate(names)]
    for name, own in [*rows, ("all", slice(None))]:
        r, (new, old) = ratios[own].mean(axis=0), found[own].mean(axis=0)
        print(f"{name:<10} {r[0]:10.2f} {r[1]:12.2f} {r[2]:11.2f} {new[3]:9.1f} of {old[3]:4.1f}"
              f"{found[own, 0, 3].max():8.0f} {new[4]:6.0f} of {old[4]:3.0f} {r[5]:6.2f} "
              f"{r[6]:14.2f} {new[7]:7.1f}")  # fmt: skip
    print("{:<10} {:10.2f} {:12.2f} {:11.2f} {:9.0f} {:15.0f} {:6.0f} {:13.2f} {:14.2f}".format(
        "asked", *ASKED))  # fmt: skip


def curved(each: int, case: tuple[str, int]) -> tuple[float, ...]:
    """Return errors elsewhere of an arm whose joints have error curves, twice so many + so many.

    Poses are those for curves, those for other arms, and random ones within reach.
    """
    name, seed = case
    robot = load_robot(name)
    generator = np.random.default_rng([seed, list(shipped_robots()).index(name), 7])
    arm, m = perturb(robot, generator, 2e-3, 5e-3), len(robot.joint_names)
    curves = CURVE.typical_shift * random_curves(m, generator)
    bent = Deflection(
        (COMPLIANCE.name, CURVE.name), (3e-5 * generator.random(m), curves)
    )
    how = Imperfection(5e-5, bent)
    first, second, *others = reachable_bases(arm, generator, 5)
    test = [record(arm, base, generator, imperfection=how) for base in others]
    errors: list[float] = []
    for of in (robot, replace(robot, name="other"), None):
        hand, earlier = (
            Hand(arm, np.random.default_rng([seed, 8]), noise=0.0),
            list[Placement](),
        )
        for base in (first, second):
            coach, samples = PoseSelector(of or robot, base.distance, parts=earlier), []
            order, hand.aim = (*[0] * 6, *[1] * 6) * (each // 6), None
            for socket, following in itertools.zip_longest(
                order, order[1:], fillvalue=1
            ):
                (read,) = lead(
                    arm, base.sockets[socket][None], hand.generator, how, hand
                )
                samples.append(
                    Sample(tuple(read.tolist()), socket, number=len(samples) + 1)
                )
                hand.aim = planned(coach, samples, following, read) if of else None
            earlier.append(
                Placement(base.name, tuple(samples), robot.joint_names, base.distance)
            )
        found = calibrate(robot, earlier, test=test).errors.summary.test
        errors.append(found.calibrated.mean_absolute_error)
    print(name, seed, *(f"{1e3 * one:.3f}" for one in errors), flush=True)
    return tuple(errors)


def compare_curved(
    first: int, count: int, each: int, names: list[str], workers: Workers
) -> None:
    cases = [(name, seed) for name in names for seed in range(first, first + count)]
    found = 1e3 * np.array(workers.map(partial(curved, each), cases))
    means = "by poses for curves {:.3f}, for other arms {:.3f}, random {:.3f}"
    print(f"{each} + {each} at two placements, mm:", means.format(*found.mean(axis=0)))


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def one_arm(
    names: list[str], goal_mm: float | None, i: int
) -> tuple[str, tuple[float, ...]]:
    """Return a line of the table on one simulated arm, and its figures."""
    name = names[i % len(names)]
    robot = load_robot(name)
    generator = np.random.default_rng([i, 3])
    arm = perturb(robot, generator, 2e-3, 5e-3)
    first, second = reachable_bases(arm, generator, 2)
    hand = Hand(arm, generator)
    coach = PoseSelector(robot, 0.05, goal_mm and 1e-3 * goal_mm)
    samples, gauge = guided(hand, first, coach)
    test = record(arm, second, generator, samples=30)
    a = truth(arm, fitted(robot, samples), test)
    b = truth(arm, fitted(robot, unguided(hand, first)), test)
    counts = [sum(s.socket == k for s in samples) for k in (0, 1)]
    text = (
        f"{name:<14} {counts[0]:>2}+{counts[1]:<3}  {1e3 * a[0]:7.2f} {1e3 * b[0]:7.2f}    "
        f"{1e3 * a[1]:7.2f} {1e3 * b[1]:7.2f}    {1e3 * gauge:7.2f} {a[2]:7.2f} {b[2]:7.2f}"
    )
    return text, (*a, *b, gauge, sum(counts))


def simulate(
    count: int, names: list[str], goal_mm: float | None, workers: Workers
) -> None:
    arms = workers.map(partial(one_arm, names, goal_mm), range(count))
    print(
        "arm            poses    held-out [mm]      distances [mm]     gauge   true/predicted"
    )
    print(
        "               guided   guided  30+30      guided  30+30      guided  guided  30+30"
    )
    print("\n".join(text for text, _ in arms))
    table = np.array([figures for _, figures in arms])
    for label, f in (("median", np.median), ("worst", np.max)):
        m = 1e3 * f(table, axis=0)
        print(f"{label:<14} {f(table[:, 7]) / 2:4.0f} x2  {m[0]:7.2f} {m[3]:7.2f}    "
              f"{m[1]:7.2f} {m[4]:7.2f}    {m[6]:7.2f}")  # fmt: skip
    print("true error of distances over the predicted one, all arms together: "
          f"guided {_rms(table[:, 2]):.2f}, 30+30 {_rms(table[:, 5]):.2f}")  # fmt: skip


def choose(model: ExtendedModel, train: Placement, each: int) -> Placement:
    """Return so many samples of each socket, chosen by predicted error before any is fitted."""
    known = from_prior(model, Noise(NOISE, 0.0), 2)
    where = workspace_of(model, np.zeros(model.size))
    left = {k: [s for s in train.samples if s.socket == k] for k in (0, 1)}
    chosen: list[Sample] = []
    for i in range(2 * each):
        socket = i % 2
        q = np.array([s.position for s in left[socket]])
        best = int(np.argmax(known.variance_reduction(q, socket, where)[1]))
        chosen.append(left[socket].pop(best))
        known = known.with_samples(q[best : best + 1], socket)
    chosen.sort(key=lambda s: s.socket)
    return Placement("chosen", tuple(chosen), train.joint_names, train.distance)


def recorded(folder: Path, each: int, draws: int) -> None:
    print(f"{each} + {each} chosen against {draws} random draws, held-out error [mm]")
    for arm, front in (
        ("panda_3", "frontcenter"),
        ("kuka_14", "front"),
        ("dinova_2", "front"),
    ):
        robot = load_robot(str(folder / arm / "nominal.urdf"))
        every = [p.for_joints(robot.joint_names) for p in read_placements(folder / arm)]
        train = next(p for p in every if p.name.endswith("/" + front))
        test = [p for p in every if p is not train]
        generator = np.random.default_rng(0)
        model = extend(robot, choose_parameters(robot))  # takes longer than many a fit
        best = held_out(model, choose(model, train, each), test)
        whole = held_out(model, train, test)
        random = []
        for _ in range(draws):
            rows = [s for k in (0, 1) for s in _draw(train, k, each, generator)]
            drawn = Placement("drawn", tuple(rows), train.joint_names, train.distance)
            random.append(held_out(model, drawn, test))
        below = float(np.mean(np.array(random) < best))
        low, middle = np.quantile(random, [0.25, 0.5])
        print(f"{arm:<10} chosen {1e3 * best:.3f}  all {1e3 * whole:.3f}  random: best quartile "
              f"{1e3 * low:.3f}, median {1e3 * middle:.3f}; {below:.0%} of them below",
              flush=True)  # fmt: skip


def _draw(
    train: Placement, socket: int, each: int, generator: np.random.Generator
) -> list[Sample]:
    here = [s for s in train.samples if s.socket == socket]
    return [here[i] for i in generator.permutation(len(here))[:each]]


def held_out(model: ExtendedModel, train: Placement, test: list[Placement]) -> float:
    """Return the mean held-out error by a rigid fit [m]."""
    data = observe(RobotRecordings(model.robot, [measure(train, model.robot)]))
    found = estimate(model, data).arm
    errors = []
    for placement in test:
        balls = found.model.ball.points(found.values, placement.positions)
        for k in (0, 1):
            here = balls[placement.sockets == k]
            errors.append(np.linalg.norm(here - here.mean(axis=0), axis=1).mean())
    return float(np.mean(errors))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, default=24)
    parser.add_argument(
        "--first", type=int, default=0, help="seed of --enough, --travel, --curves"
    )
    parser.add_argument("--robots", nargs="+", help="instead of all that are shipped")
    parser.add_argument("--goal-mm", type=float, help="instead of the coach's own")
    parser.add_argument("--enough", action="store_true", help="--arms of each robot")
    parser.add_argument("--travel", action="store_true", help="--arms of each robot")
    parser.add_argument(
        "--curves", action="store_true", help="--arms of each, --each in a socket"
    )
    parser.add_argument("--recordings", type=Path)
    parser.add_argument("--each", type=int, default=15)
    parser.add_argument("--draws", type=int, default=200)
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    if arguments.recordings:
        recorded(arguments.recordings, arguments.each, arguments.draws)
    elif arguments.enough:
        names = arguments.robots or list(shipped_robots())
        compare_enough(
            arguments.first, arguments.arms, names, read_options(arguments).workers
        )
    elif arguments.travel:
        names = arguments.robots or list(TRAVELLED)
        compare_travel(
            arguments.first, arguments.arms, names, read_options(arguments).workers
        )
    elif arguments.curves:
        names, workers = arguments.robots or ["ur10"], read_options(arguments).workers
        compare_curved(arguments.first, arguments.arms, arguments.each, names, workers)
    else:
        names = arguments.robots or list(shipped_robots())
        simulate(
            arguments.arms, names, arguments.goal_mm, read_options(arguments).workers
        )


if __name__ == "__main__":
    main()
