"""How soon, and how rightly, a session notices a fault while the hand is still on the arm.

    python benchmarks/sessions.py [--seeds 3] [--robots panda ...] [--faults base@9:5mm ...]

A session is a simulated arm with realistic flaws, its ball mounted where the model does not have
it, servo arms with zeros off by 5 degrees and play; two sockets 100 mm apart, 12 + 12 samples in
the order 0 1 0 1. After every sample from the sixth on it is checked as ``mukca record`` does.
For each fault are counted: sessions with an alarm before it, which is false; those in which the fit
was determined before the last two samples (that it predicts the next sample of the sound twin to a
third of the fault), and of these the ones noticed within two samples of that; those noticed at all;
and those whose cause was the right one at the end.
"""

import argparse
import math
import os
from dataclasses import replace
from functools import cache, partial

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from mukca.recorder import Placement, Sample
from mukca.solver.assessment import ARMS
from mukca.solver.bayes.results import angles_near
from mukca.solver.diagnostics import Fault, LiveCheck
from mukca.solver.diagnostics.hypotheses import ONLY_SOUND, Comparison
from mukca.solver.robot import (
    Origin,
    Robot,
    load_robot,
    rotation,
    rotation_rpy,
    shipped_robots,
)
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.simulation import (
    Base,
    Imperfection,
    Session,
    SessionFault,
    lead,
    perturb,
    reachable_bases,
    realistic_flaws,
    with_faults,
)

SERVOS = ("so100", "so101", "koch", "gen3_lite", "wx250s", "vx300s", "wxai")
MOUNT, ZEROS, PLAY = 0.03, math.radians(5), math.radians(0.5)
FAULTS = (
    *("none", "base@7:5mm", "base@10:5mm", "base@17:3mm", "base@19:10mm"),
    *("ball@9:5mm", "ball@15:3mm", "socket@7+4", "socket@7+6", "socket@19+3"),
    *("bent@10:5mm", "zero@10:1deg", "drift:3mm", "turn@13:3deg", "distance:2mm"),
)
ANGLES = ("zero", "turn")
"""Kinds whose size is no length."""
RIGHT = {
    "base": ("base_moved",),
    "turn": ("base_moved",),
    "drift": ("drift", "base_moved"),
    "ball": ("ball_sample",),
    "bent": ("ball_bent", "base_moved"),
    "socket": ("socket",),
    "distance": ("distance",),
    "zero": ("zero_lost",),
    "loose": ("ball_loose",),
}


def arm_of(robot: Robot, generator: np.random.Generator) -> Robot:
    """Return an arm as it truly is: flawed, its ball mounted elsewhere, its zeros off."""
    arm = perturb(robot, generator, 2e-3, 5e-3)
    servo = robot.name in SERVOS
    joints = []
    for joint in arm.joints:
        xyz, rpy = np.array(joint.origin.xyz), joint.origin.rpy
        if joint is arm.ball_joint:
            xyz = xyz + generator.uniform(-MOUNT, MOUNT, 3)
        elif joint.actuated and servo:
            R = rotation_rpy(rpy) @ rotation(joint.axis, generator.uniform(-ZEROS, ZEROS))
            rpy = tuple(angles_near(np.array(R.full()), np.array(rpy)).tolist())
        joints.append(replace(joint, origin=Origin(tuple(xyz.tolist()), rpy)))
    return replace(arm, joints=tuple(joints))


def session_of(
    name: str, seed: int, text: str, order: tuple[int, ...]
) -> tuple[Robot, list[Sample], Base]:
    """Return a robot, the samples of a session with a fault, and its base."""
    robot = load_robot(name)
    generator = np.random.default_rng([seed, 11])
    arm = arm_of(robot, generator)
    how = realistic_flaws(robot, generator)
    if name in SERVOS:
        how = Imperfection(3e-4, play=PLAY, resolution=math.tau / 4096)
    base = reachable_bases(arm, generator, 1, 0.1)[0]
    sockets = np.array(order)
    read = lead(arm, np.array(base.sockets)[sockets], generator, how)
    fault = SessionFault.parse(text)
    if fault:
        session = Session(arm, read, sockets, np.array(base.sockets), generator)
        read = with_faults(session, [fault])
    rows = zip(read.tolist(), sockets.tolist(), strict=True)
    return robot, [Sample(tuple(q), k, number=i) for i, (q, k) in enumerate(rows, 1)], base


def one(
    order: tuple[int, ...], job: tuple[str, int, str]
) -> tuple[str, int, str, list[Fault | None]]:
    """Return the first fault that is told after each sample of a session."""
    name, seed, text = job
    robot, samples, base = session_of(name, seed, text, order)
    known = ARMS[name].repeatability if name in ARMS else None
    check = LiveCheck(robot, known)
    told: list[Fault | None] = []
    for n in range(1, len(samples) + 1):
        here = Placement("here", tuple(samples[:n]), robot.joint_names, base.distance)
        told.append(next(iter(check.faults([here])), None))
    return name, seed, text, told


@cache
def predicted(name: str, seed: int, order: tuple[int, ...]) -> list[float]:
    """Return how well each sample of a sound session is known before it is taken [m]."""
    robot, samples, base = session_of(name, seed, "none", order)
    check = LiveCheck(robot, ARMS[name].repeatability if name in ARMS else None)
    found = [math.inf] * 6
    for n in range(7, len(samples) + 1):
        here = Placement("here", tuple(samples[:n]), robot.joint_names, base.distance)
        scene = check.scene([here])
        s2 = Comparison(scene, ONLY_SOUND, check.share).candidates[0].sigma ** 2
        new = 3 * int(np.flatnonzero(scene.times[0] == n - 1)[0]) + np.arange(3)
        B, before = scene.nuisances, np.delete(scene.nuisances, new, axis=0)
        known_by = np.linalg.inv(before.T @ before / s2 + np.eye(B.shape[1]))
        found.append(math.sqrt(np.trace(B[new] @ known_by @ B[new].T) / 3 + s2))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--robots", nargs="+")
    parser.add_argument("--faults", nargs="+", default=list(FAULTS))
    parser.add_argument("--order", default="000000111111000000111111")
    add_options(parser, WorkerOptions)
    a = parser.parse_args()
    names = a.robots or list(shipped_robots())
    jobs = [(n, s, f) for f in a.faults for n in names for s in range(a.seeds)]
    table = {f: [0] * 6 for f in a.faults}
    order = tuple(map(int, a.order))
    play = partial(one, order)
    for name, seed, text, told in read_options(a).workers.map(play, jobs):
        fault, row = SessionFault.parse(text), table[text]
        start = fault.start if fault else math.inf
        heard = [i for i, t in enumerate(told, 1) if t]
        late = [i for i in heard if i >= start]
        row[0] += 1
        row[1] += len(late) < len(heard)
        third = fault.size / 3 if fault and fault.size and fault.kind not in ANGLES else MOUNT
        known = [i for i, d in enumerate(predicted(name, seed, order), 1) if d < third]
        at = next((i for i in known if start <= i < len(order)), None)
        row[2] += at is not None
        row[3] += at is not None and bool(late) and late[0] < at + 2
        row[4] += bool(late)
        row[5] += bool(told[-1]) and told[-1].hypothesis.name in RIGHT.get(
            fault.kind if fault else "", ()
        )
    print(f"{'fault':<14}   of  false  determined  in two  noticed  right")
    for text, (n, early, known, soon, noticed, right) in table.items():
        print(f"{text:<14} {n:>4} {early:>6} {known:>11} {soon:>7} {noticed:>8} {right:>6}")


if __name__ == "__main__":
    main()
