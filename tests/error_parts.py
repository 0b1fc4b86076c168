"""Arms with an effect that their model lacks, and the parts of their held-out error.

Gears that turn unevenly 5 times a turn, a play of one joint that is pushed both ways, a table that
tilts by the moment, or none. Its size is the root mean square that it leaves at random poses.
"""

from dataclasses import dataclass, replace

import numpy as np

import mukca
from mukca.recorder import Placement
from mukca.solver.identification.data import measure
from mukca.solver.identification.robot import (
    BallModel,
    Robot,
    gravity_moments,
    workspace,
)
from mukca.solver.studies import error_parts
from mukca.tools.simulation import perturb, reachable_bases, record

ROBOTS = ("panda", "ur5e")
NOISE = 1e-4
CYCLES = 5


@dataclass(frozen=True)
class Effect:
    """What an arm does that its model lacks."""

    arm: Robot
    kind: str
    joint: int
    phase: float
    size: float = 1.0

    def positions(self, q: np.ndarray) -> np.ndarray:
        """Return where the joints truly are, shape (N, m) [rad]."""
        true = q.copy()
        if self.kind == "gears":
            true[:, self.joint] += self.size * np.sin(CYCLES * q[:, self.joint] + self.phase)
        elif self.kind == "play":
            torque = gravity_moments(self.arm, q)[:, self.joint]
            true[:, self.joint] += self.size * np.sign(torque)
        return true

    def ball(self, q: np.ndarray) -> np.ndarray:
        """Return where the ball truly is, shape (N, 3) [m]."""
        points = BallModel(self.arm, ()).points(np.zeros(0), self.positions(q))
        if self.kind == "table":
            turn = self.size * gravity_moments(self.arm, q)[:, 1]
            points += np.outer(turn, [0.0, 0.0, 1.0]) * points[:, :1]
        return points

    def of_size(self, size: float) -> "Effect":
        """Return the effect that leaves such a root mean square at random poses [m]."""
        q = workspace(self.arm, 300)
        small = replace(self, size=1e-3)
        moved = small.ball(q) - replace(self, kind="none").ball(q)
        left = float(np.sqrt(np.mean(np.sum(moved**2, axis=1))))
        return replace(self, size=1e-3 * size / left) if left else self


def recorded(effect: Effect, placement: Placement) -> Placement:
    """Return samples read so that the true ball is where the placement has it."""
    read = placement.positions.copy()
    model = BallModel(effect.arm, ())
    for _ in range(4):
        off = effect.ball(read) - model.points(np.zeros(0), placement.positions)
        J = model.linearise(np.zeros(0), read).by_joints
        read -= (np.linalg.pinv(J) @ off[:, :, None])[:, :, 0]
    pairs = zip(placement.samples, read.tolist(), strict=True)
    return replace(placement, samples=tuple(replace(s, position=tuple(q)) for s, q in pairs))


def draw(kind: str, size: float, seed: int) -> tuple[float, ...]:
    """Return error, noise, want of data, what is not in the model, low, high, and the truth [m]."""
    robot, generator = mukca.load_robot(ROBOTS[seed % 2]), np.random.default_rng(seed)
    arm = perturb(robot, generator, 1e-3, 5e-3)
    joint = int(generator.integers(1, 4))
    effect = Effect(arm, kind, joint, generator.uniform(0, 6)).of_size(size)
    bases = reachable_bases(arm, generator, 3)
    placements = [record(arm, base, generator, samples=25, noise=NOISE) for base in bases]
    placements = [recorded(effect, placement) for placement in placements]
    fit = mukca.calibrate(robot, placements[:2])
    held = measure(placements[2], robot)
    sockets = fit.load.by_socket(robot, held)
    parts = error_parts([(fit.posterior, sockets)])
    assert parts is not None
    squares = 0.0
    for samples in sockets:
        off = fit.ball(samples.q) - effect.ball(samples.q)
        squares += float(np.sum((off - off.mean(axis=0)) ** 2))
    lacking = squares / len(held.positions) - parts.want_of_data**2
    interval = parts.not_in_model
    figures = (parts.error, parts.noise, parts.want_of_data, interval.value)
    return (*figures, interval.low, interval.high, max(lacking, 0.0) ** 0.5)
