"""How often the verdict is wrong: sound recordings that do not pass, spoilt ones that do.

    python benchmarks/verdicts.py [--good 60] [--bad 60] [--only I ...]

Sound: simulated arms of all shipped robots, 2 x 30 samples at two placements, one of them held
out, each with so much noise as its repeatability suggests; arms of hobby servos have play, coarse
encoders, and zeros that are off by up to 5 degrees, and are calibrated with `--zeros`. Places at
which some joint hardly turns are not chosen, as `mukca plan` would not. Spoilt: the same recordings
after one mistake, taken in turn from the list below. For each the status of the verdict is counted,
and for each PASS by how much distances in the workspace are truly wrong, beside what the verdict
allows: after some mistakes the model is right all the same. The arms do not bend, so what they do
not have is not tried.
"""

import argparse
import math
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import mukca
from mukca.recorder import Placement
from mukca.solver.assessment import ARMS
from mukca.solver.robot import BallModel, shipped_robots, workspace
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.simulation import Imperfection, perturb, reachable_bases, record

REPEATABILITY = {"gen3": 0.15, "lite6": 0.5, "openarm": 0.2, "piper": 0.2, "ur20": 0.1}
REPEATABILITY |= {"uf850": 0.1, "wxai": 1.0}
"""What is given for arms of which no figure is known [mm]; for the Piper as docs/piper.md does."""
NOISE, LEAST_NOISE = 0.3, 5e-5
"""Of the ball's place per axis: a share of the repeatability, and at least so much [m]."""
TRAVEL = math.radians(20)
SERVOS = ("so100", "so101", "koch")
PLAY, TICK, ZERO = math.radians(0.7), 2 * math.pi / 4096, math.radians(5)
SERVO_REPEATABILITY = 2.0
"""As builders of such arms measure it [mm]."""


Truth = Callable[[np.ndarray], np.ndarray]
"""Where the ball truly is, of joint positions as the arm reports them."""


def positions(placement: Placement, change: Callable[[np.ndarray], np.ndarray]) -> Placement:
    rows = change(placement.positions.copy()).tolist()
    samples = zip(placement.samples, rows, strict=True)
    return replace(placement, samples=tuple(replace(s, position=tuple(q)) for s, q in samples))


def flipped(joint: int) -> Callable[[Placement], Placement]:
    def change(q: np.ndarray) -> np.ndarray:
        q[:, joint] *= -1
        return q

    return lambda p: positions(p, change)


def swapped(p: Placement) -> Placement:
    return positions(p, lambda q: q[:, [0, 1, 2, 4, 3, *range(5, q.shape[1])]])


def zero_off(p: Placement) -> Placement:
    return positions(p, lambda q: q + np.eye(q.shape[1])[2] * 0.5)


def few(p: Placement) -> Placement:
    return replace(p, samples=tuple(p.samples[i] for i in (0, 1, 2, 3, 4, 30, 31, 32, 33, 34)))


def alike(p: Placement) -> Placement:
    """The twelve samples of each socket that are most alike."""
    kept: list[int] = []
    for begin in (0, 30):
        q = p.positions[begin : begin + 30]
        order = np.argsort(np.abs(q - np.median(q, axis=0)).max(axis=1))
        kept += sorted((begin + order[:12]).tolist())
    return replace(p, samples=tuple(p.samples[i] for i in kept))


def copied(p: Placement) -> Placement:
    first = [s for s in p.samples if s.socket == 0]
    return replace(p, samples=(*first, *(replace(s, socket=1) for s in first)))


def half_in_the_other(p: Placement) -> Placement:
    samples = [
        replace(s, socket=1 - s.socket) if i % 4 == 0 else s for i, s in enumerate(p.samples)
    ]
    return replace(p, samples=tuple(samples))


MISTAKES: dict[str, tuple[Callable[[Placement], Placement], dict[str, float]]] = {
    # What was done to the recording, or by how much the stated distance is wrong.
    "distance 2 % too long": (lambda p: p, {"distance": 1.02}),
    "distance 4 % too short": (lambda p: p, {"distance": 0.96}),
    "distance of another base": (lambda p: p, {"distance": 2.4}),
    "joint 2's sign": (flipped(1), {}),
    "joint 4's sign": (flipped(3), {}),
    "last joint's sign": (flipped(-1), {}),
    "two columns swapped": (swapped, {}),
    "a zero off by 0.5 rad": (zero_off, {}),
    "five samples a socket": (few, {}),
    "the twelve most alike": (alike, {}),
    "one socket's file copied": (copied, {}),
    "every fourth in the other socket": (half_in_the_other, {}),
}


@dataclass(frozen=True)
class Told:
    """What a recording came to."""

    status: str
    """Of the verdict; ``wrong pass`` where the model is truly worse than a PASS allows."""
    robot: str
    words: str = ""

    def __str__(self) -> str:
        return f"({self.robot}): {self.status}; {self.words}"


def told(robot: mukca.Robot, truth: Truth, placements: list[Placement], **settings: Any) -> Told:
    """Calibrate, and return the verdict; ``refused`` where one line says why there is none."""
    train, test = placements
    without = () if settings.get("zeros") else ("compliance", "tilt", "transmission")
    try:
        calibration = mukca.calibrate(robot, train, test=test, without=without, **settings)
    except mukca.MukcaError as error:
        return Told("refused", robot.name, str(error))
    if calibration.document.distorted:
        return Told("distorted", robot.name)
    verdict = calibration.verdict
    (allowed,) = [row.limit for row in verdict.limits if row.name == "predicted_distance"]
    wrong = workspace_error(truth, calibration)
    words = f"distances truly {1e3 * wrong:.2f} mm off; {verdict.text}"
    failed = verdict.status == "pass" and allowed is not None and wrong > allowed
    return Told("wrong pass" if failed else verdict.status, robot.name, words)


def workspace_error(truth: Truth, calibration: mukca.Calibration) -> float:
    """Return the median error of distances between poses all over the workspace [m]."""
    q = workspace(calibration.robot, 400)
    points = (truth(q), calibration.ball(q))
    true, predicted = (np.linalg.norm(p[1::2] - p[::2], axis=1) for p in points)
    return float(np.median(np.abs(predicted - true)))


def recordings(i: int) -> tuple[mukca.Robot, Truth, list[Placement], dict[str, Any]]:
    """Return a robot, where its ball truly is, its recordings, and what is given with them."""
    names = list(shipped_robots())
    name = names[i % len(names)]
    robot = mukca.load_robot(name)
    given: dict[str, Any] = {}
    if name in REPEATABILITY:
        given = {"repeatability_mm": REPEATABILITY[name]}
    for seed in range(100 + i, 50_000, 1000):
        if name in SERVOS:
            truth, placements = servo_recordings(robot, seed)
            given = SERVO
        else:
            arm, placements = mukca.simulate_recordings(robot, 2, seed=seed, noise=noise_of(name))
            truth = arm.ball
        if all((np.ptp(p.positions, axis=0) >= TRAVEL).all() for p in placements):
            break
    return robot, truth, placements, given


def noise_of(name: str) -> float:
    """Return the noise of the ball's place in its socket, per axis [m]."""
    repeatability = ARMS[name].repeatability if name in ARMS else 1e-3 * REPEATABILITY[name]
    return max(NOISE * repeatability, LEAST_NOISE)


SERVO = {"repeatability_mm": SERVO_REPEATABILITY, "zeros": True}


def base_of(robot: mukca.Robot) -> float:
    """Return the distance of the sockets [m]: one socket holds the first joint of an SO arm."""
    return 0.15 if robot.name.startswith("so1") else 0.05


def servo_recordings(robot: mukca.Robot, seed: int) -> tuple[Truth, list[Placement]]:
    generator = np.random.default_rng(seed)
    arm = perturb(robot, generator, 3e-4, 0.0)
    zeros = generator.uniform(-ZERO, ZERO, len(robot.actuated))
    how = Imperfection(3e-4, play=PLAY, resolution=TICK)
    return lambda q: BallModel(arm, ()).points(np.zeros(0), q + zeros), [
        positions(record(arm, base, generator, imperfection=how), lambda q: q - zeros)
        for base in reachable_bases(arm, generator, 2, base_of(robot))
    ]


def of_sound(i: int) -> Told:
    """Return what sound recordings came to."""
    robot, truth, placements, given = recordings(i)
    return told(robot, truth, placements, **given)


def of_spoilt(i: int) -> Told:
    """Return what the same came to after a mistake."""
    spoil, wrong = MISTAKES[mistake(i)]
    robot, truth, placements, given = recordings(i)
    settings = {name: factor * base_of(robot) for name, factor in wrong.items()}
    return told(robot, truth, [spoil(p) for p in placements], **given, **settings)


def mistake(i: int) -> str:
    """Return the name of a mistake; each round through the robots begins with another."""
    return list(MISTAKES)[(i + i // len(shipped_robots())) % len(MISTAKES)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--good", type=int, default=60)
    parser.add_argument("--bad", type=int, default=60)
    parser.add_argument("--only", type=int, nargs="+", metavar="I", help="these of them alone")
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    workers = read_options(arguments).workers
    sound, spoilt = (
        [i for i in range(count) if i in (arguments.only or range(count))]
        for count in (arguments.good, arguments.bad)
    )
    found = workers.map(of_sound, sound)
    for i, one in zip(sound, found, strict=True):
        if one.status != "pass" or arguments.only:
            print(f"sound {i} {one}")
    print(f"sound recordings: {dict(Counter(one.status for one in found))}", flush=True)
    found = workers.map(of_spoilt, spoilt)
    for i, one in zip(spoilt, found, strict=True):
        if one.status.endswith("pass") or arguments.only:
            print(f"spoilt {i}, {mistake(i)} {one}")
    print(f"spoilt recordings: {dict(Counter(one.status for one in found))}")


if __name__ == "__main__":
    main()
