"""The readings themselves: copies, coarse steps, or an arm that the hand pushed."""

from collections.abc import Iterable

import numpy as np

from .ball import loose_here, scattered_placements
from .evidence import INDEPENDENT
from .kinds import Block, NoisePrior, without_columns
from .scene import Scene

SAME, COPIED = 2e-3, 0.5
"""Rows that differ by less on every joint are one [rad]; a larger share of them is a copy."""
NEAR, REPEATED = np.deg2rad(1.0), 0.5
"""Postures that differ by less on every joint are nearly one [rad]; and the share of such samples
that tells a placement of few postures."""
CHANCE = 30.0
"""Logarithm of the odds at most that such a pattern is no chance."""
EXACT = 1e-3
"""Part of a step to which readings are multiples of it."""
UNIFORM = 12**-0.5
"""Standard deviation of what is as likely anywhere in a step of 1."""
PUSHED, PUSHED_HERE = np.geomspace(2e-4, 5e-3, 8), (5e-4, 4e-3, 0.05)
"""Joint noise of arms that are pushed, and of those that are in one placement [rad]."""


def copies(scene: Scene) -> Iterable[Block]:
    """Return the block of the first socket whose samples are those of an earlier one."""
    sockets = [scene.q[rows] for rows in scene.samples.rows]
    # an instrument measures a pose again
    count = len(sockets) - len(scene.frames)
    for later, earlier in ((k, j) for k in range(count) for j in range(k)):
        twins = _alike(sockets[later], sockets[earlier], SAME)
        if twins.any(axis=1).mean() > COPIED:
            name, socket = scene.labels[later]
            of, of_socket = scene.labels[earlier]
            names = {
                "placement": name,
                "socket": socket,
                "of": of,
                "of_socket": of_socket,
            }
            yield without_columns(names, CHANCE)
            return


def repeated(scene: Scene) -> Iterable[Block]:
    """Return blocks of placements most of whose samples are in postures of others in the socket."""
    for place, rows in enumerate(scene.places):
        q, seats = scene.q[rows], scene.sockets[rows]
        near = _alike(q, q, NEAR) & (seats[:, None] == seats)
        again = np.tril(near, -1).any(axis=1)
        if scene.measurements[place].kind == "sockets" and again.mean() > REPEATED:
            postures = int(np.sum(~again))
            names = {**scene.named(place), "samples": len(q), "postures": postures}
            yield without_columns(names, CHANCE)


def _alike(q: np.ndarray, others: np.ndarray, tolerance: float) -> np.ndarray:
    """Tell which postures differ by less from which others on every joint, shape (N, M)."""
    return np.abs(q[:, None] - others).max(axis=2) < tolerance


def steps(scene: Scene) -> np.ndarray:
    """Return the steps in which each joint reads, shape (m,) [rad]; 0 where there is none."""
    steps_of_joints = np.zeros(scene.q.shape[1])
    for j, column in enumerate(scene.q.T):
        gaps: np.ndarray = np.diff(np.unique(column.round(9)))
        step = float(gaps.min(initial=np.inf, where=gaps > 1e-7))
        multiples = column / step
        off = float(np.abs(multiples - multiples.round()).max())
        if np.isfinite(step) and off < max(EXACT, 1e-6 / step):
            steps_of_joints[j] = step
    return steps_of_joints


def quantised(scene: Scene) -> Iterable[Block]:
    """Return the block of readings in coarse steps, which are noise of the joints."""
    step = steps(scene)
    size = _effect(scene, step)
    if size > scene.noise:
        gain = _gain(scene, step, np.array([UNIFORM]))
        names = {"step": float(step.max()), "size": size}
        yield without_columns(names, CHANCE / 3 + gain)


def of_steps(scene: Scene) -> NoisePrior:
    """Return the belief on the noise of readings in coarse steps."""
    return NoisePrior(max(scene.noise, _effect(scene, steps(scene))), 0.5)


def _effect(scene: Scene, step: np.ndarray) -> float:
    """Return the noise of the ball per axis by steps of the joints [m]."""
    shifts = UNIFORM * scene.by_joints * step
    return float(np.mean(shifts**2 * step.size)) ** 0.5


def pushed(scene: Scene) -> Iterable[Block]:
    """Return the block of arms whose joints the hand turned against their gears.

    No hand is on an arm while an instrument measures.
    """
    by_hand = any(m.kind == "sockets" for m in scene.measurements)
    # one placement that stands out is told by itself
    if by_hand and not any(scattered_placements(scene)):
        usual = np.ones(scene.q.shape[1])
        yield without_columns({}, max(_gain(scene, usual, PUSHED), -CHANCE))


def pushed_here(scene: Scene) -> Iterable[Block]:
    """Return blocks of placements in which the joints were turned so, unlike in the others."""
    J = scene.by_joints
    roots = np.linalg.cholesky(J @ J.transpose(0, 2, 1) + 1e-6 * np.eye(3))
    for block in loose_here(scene, roots, PUSHED_HERE):
        if scene.measured(block.parameters[0]["placement"]).kind == "sockets":
            yield block


def _gain(scene: Scene, width: np.ndarray, trials: np.ndarray) -> float:
    """Return how much likelier noise of the joints, times some trial, is than of the ball."""
    e, J = scene.remaining, scene.by_joints * width
    even = max(float(np.mean(e**2)), 1e-14)
    alike = -1.5 * len(e) * (np.log(even) + 1)
    squares, axes = np.linalg.eigh(J @ J.transpose(0, 2, 1))
    along = np.einsum("nij,ni->nj", axes, e)
    of_joints = squares * trials[:, None, None] ** 2
    of_ball = scene.noise * np.array([1.0, 0.5])
    variances = of_joints + of_ball[:, None, None, None] ** 2
    terms = along**2 / variances + np.log(variances)
    logs: np.ndarray = -0.5 * terms.sum(axis=(2, 3))
    return INDEPENDENT * (float(logs.max()) - alike)
