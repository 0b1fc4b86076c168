"""What guiding is worth, on simulated arms.

    python benchmarks/guide.py --enough --arms 4    ENOUGH of two placements, and what solve says
    python benchmarks/guide.py --travel --arms 5    how far a hand leads the arm from pose to pose
    python benchmarks/guide.py --curves --arms 3    error curves: errors by poses for these

``--arms`` are those of each robot, from the seed of ``--first`` on. From 300 on
ENOUGH was said of three seeds each of all 24 arms that are shipped, and of three more of koch,
panda, so101, ur5e and wxai (of so100 two of three); after it none was NOT ENOUGH.

A simulated arm differs from its model by 2 mm and 5 mrad a joint. A guided operator hits the
proposed pose within 0.15 rad a joint.
"""

import argparse
import itertools
import os
from dataclasses import dataclass, replace
from functools import partial

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from worlds import realistic_flaws

from mukca.recorder import Placement, Sample
from mukca.solver.assessment import repeatability_of
from mukca.solver.calibration import calibrate
from mukca.solver.design import (
    ParameterCovariance,
    from_prior,
    workspace_of,
)
from mukca.solver.diagnostics import is_coarse
from mukca.solver.identification.data import (
    CALIPER_DEVIATION,
)
from mukca.solver.identification.effects import COMPLIANCE, CURVE, random_curves
from mukca.solver.identification.model import Deflection, Noise, extend
from mukca.solver.identification.robot import (
    Robot,
    choose_parameters,
    load_robot,
    shipped_robots,
)
from mukca.solver.poses import InverseKinematics
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.parallel import Workers
from mukca.tools.recording import PoseSelector
from mukca.tools.simulation import (
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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, default=1, help="of each robot")
    parser.add_argument("--first", type=int, default=0, help="the seed of its first")
    parser.add_argument("--robots", nargs="+")
    what = parser.add_mutually_exclusive_group(required=True)
    for name in ("--enough", "--travel", "--curves"):
        what.add_argument(name, action="store_true")
    parser.add_argument("--each", type=int, default=15, help="samples in a socket")
    add_options(parser, WorkerOptions)
    a = parser.parse_args()
    workers = read_options(a).workers
    if a.enough:
        names = a.robots or list(shipped_robots())
        compare_enough(a.first, a.arms, names, workers)
    elif a.travel:
        compare_travel(a.first, a.arms, a.robots or list(TRAVELLED), workers)
    else:
        compare_curved(a.first, a.arms, a.each, a.robots or ["ur10"], workers)


if __name__ == "__main__":
    main()
