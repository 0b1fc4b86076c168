"""Arms with one flaw, and the pattern that is named in the errors that a fit leaves.

One of the encoders errs by a wave 3 times a turn, the base gives way to where the arm leans, or the
arm grows as it warms up during each placement; or it is sound. The size is the root mean square
that the flaw moves the ball by.
"""

from dataclasses import replace

import numpy as np

import mukca
from mukca.recorder import Placement
from mukca.solver.identification.robot import BallModel, Robot, link_poses, workspace
from mukca.solver.results import ErrorPatterns
from mukca.tools.simulation import perturb, reachable_bases, record

ROBOTS = ("panda", "ur5e")
NOISE = 1e-4
CYCLES = 3
EXPECTED = {"sag": ("reach", "height"), "warm": ("time",), "none": ()}
"""Patterns of a flaw; that of an encoder is its joint's name."""
LACKS = {
    "encoder": ("curves", "transmission"),
    "sag": ("curves", "transmission", "tilt", "compliance"),
}
"""Extensions that the fit is made without, since they take the flaw up: then nothing is left."""


def shift(arm: Robot, kind: str, joint: int, q: np.ndarray) -> np.ndarray:
    """Return how a flaw moves the ball in the order of recording, shape (N, 3)."""
    linear = BallModel(arm, ()).linearise(np.zeros(0), q)
    if kind == "encoder":
        return linear.by_joints[:, :, joint] * np.sin(CYCLES * q[:, [joint]] + 1.0)
    if kind == "warm":
        return linear.points * np.linspace(0, 1, len(q))[:, None]
    masses = np.array([body.mass for body in arm.bodies])
    poses = link_poses(arm.joints, q)
    places = [poses[:, b.joint + 1, :, :3] @ np.array(b.centre) for b in arm.bodies]
    places = [p + poses[:, b.joint + 1, :, 3] for p, b in zip(places, arm.bodies, strict=True)]
    lean = np.einsum("b,bni->ni", masses, np.array(places)) * (kind == "sag")
    turn = np.stack([-lean[:, 1], lean[:, 0], 0 * lean[:, 0]], axis=1)
    return np.cross(turn, linear.points)


def recorded(
    arm: Robot,
    placement: Placement,
    kind: str,
    joint: int,
    size: float,
    generator: np.random.Generator,
) -> Placement:
    """Return samples in random order, read with a flaw while the ball is in its socket."""
    order = generator.permutation(len(placement.samples))
    samples = [placement.samples[i] for i in order]
    seated = np.array([sample.position for sample in samples])
    seats, read = BallModel(arm, ()).points(np.zeros(0), seated), seated.copy()
    for _ in range(5):
        linear = BallModel(arm, ()).linearise(np.zeros(0), read)
        off = linear.points + size * shift(arm, kind, joint, read) - seats
        read -= (np.linalg.pinv(linear.by_joints) @ off[:, :, None])[:, :, 0]
    pairs = zip(samples, read.tolist(), strict=True)
    return replace(placement, samples=tuple(replace(s, position=tuple(q)) for s, q in pairs))


def draw(kind: str, size: float, seed: int) -> tuple[str, ErrorPatterns]:
    """Return the joint that an encoder's flaw is of, and the patterns."""
    robot, generator = mukca.load_robot(ROBOTS[seed % 2]), np.random.default_rng(seed)
    arm = perturb(robot, generator, 1e-3, 5e-3)
    joint = int(generator.integers(1, 4))
    moved = shift(arm, kind, joint, workspace(arm, 300))
    scale = size / max(float(np.sqrt(np.mean(np.sum(moved**2, axis=1)))), 1e-12)
    scale = 0.0 if kind == "none" else scale
    bases = reachable_bases(arm, generator, 3)
    placements = [record(arm, base, generator, samples=25, noise=NOISE) for base in bases]
    placements = [recorded(arm, p, kind, joint, scale, generator) for p in placements]
    settings = {"without": LACKS.get(kind, ()), "as_recorded": kind == "warm"}
    fit = mukca.calibrate(robot, placements[:2], test=placements[2:], **settings)
    patterns = fit.document.error_patterns
    assert patterns is not None
    return robot.joint_names[joint], patterns
