"""The readings themselves: copies, coarse steps, or an arm that the hand pushed."""

from collections.abc import Iterable

import numpy as np

from ...identification.data import UNIFORM, steps_of
from ...results import rms
from .ball import loose_here, scattered_placements
from .evidence import INDEPENDENT
from .kinds import Block, NoisePrior, without_columns
from .scene import Scene

SAME = 2e-3
"""Rows that differ by less on every joint are one [rad]."""
COPIED = 0.5
"""A larger share of such rows is a copy."""
NEAR = np.deg2rad(1.0)
"""Postures that differ by less on every joint are nearly one [rad]."""
REPEATED = 0.5
"""Share of such samples that tells a placement of few postures."""
CHANCE = 30.0
"""Logarithm of the odds at most that such a pattern is no chance."""
PUSHED = np.geomspace(2e-4, 5e-3, 8)
"""Joint noise of arms that are pushed [rad]."""
PUSHED_HERE = (5e-4, 4e-3, 0.05)
"""The same of arms that are in one placement [rad]."""


def copies(scene: Scene) -> Iterable[Block]:
    """Return the block of the first socket whose samples are those of an earlier one."""
    # an instrument measures a pose again
    count = scene.samples.count - len(scene.frames)
    of_sockets = [scene.q[rows] for rows in scene.samples.rows[:count]]
    for later, q in enumerate(of_sockets):
        for earlier, others in enumerate(of_sockets[:later]):
            if _alike(q, others, SAME).any(axis=1).mean() > COPIED:
                # the names of a socket, and of that whose copy it is
                placement, socket = scene.labels[later]
                original, socket_of_original = scene.labels[earlier]
                yield without_columns(
                    {
                        "placement": placement,
                        "socket": socket,
                        "of": original,
                        "of_socket": socket_of_original,
                    },
                    CHANCE,
                )
                return


def repeated(scene: Scene) -> Iterable[Block]:
    """Return blocks of placements most of whose samples are in postures of others in the socket."""
    for place, rows in enumerate(scene.places):
        if scene.measurements[place].kind != "sockets":
            continue
        q, seats = scene.q[rows], scene.sockets[rows]
        near = _alike(q, q, NEAR) & (seats[:, None] == seats)
        again = np.tril(near, -1).any(axis=1)
        if again.mean() > REPEATED:
            names = {
                **scene.named(place),
                "samples": len(q),
                "postures": int(np.sum(~again)),
            }
            yield without_columns(names, CHANCE)


def _alike(
    q: np.ndarray,
    others: np.ndarray,
    tolerance: float,
) -> np.ndarray:
    """Tell which postures differ by less from which others on every joint, shape (N, M)."""
    return np.abs(q[:, None] - others).max(axis=2) < tolerance


def quantised(scene: Scene) -> Iterable[Block]:
    """Return the block of readings in coarse steps, which are noise of the joints."""
    steps_of_joints = steps_of(scene.q)
    size = _effect(scene, steps_of_joints)
    if size > scene.noise:
        gain = _gain(scene, steps_of_joints, np.array([UNIFORM]))
        names = {"step": float(steps_of_joints.max()), "size": size}
        yield without_columns(names, CHANCE / 3 + gain)


def of_steps(scene: Scene) -> NoisePrior:
    """Return the belief on the noise of readings in coarse steps."""
    size = _effect(scene, steps_of(scene.q))
    return NoisePrior(max(scene.noise, size), 0.5)


def _effect(
    scene: Scene,
    steps_of_joints: np.ndarray,
) -> float:
    """Return the noise of the ball per axis by steps of the joints [m]."""
    shifts = UNIFORM * scene.by_joints * steps_of_joints
    return rms(np.linalg.norm(shifts, axis=2))


def pushed(scene: Scene) -> Iterable[Block]:
    """Return the block of arms whose joints the hand turned against their gears.

    No hand is on an arm while an instrument measures.
    """
    by_hand = any(m.kind == "sockets" for m in scene.measurements)
    # one placement that stands out is told by itself
    if by_hand and not any(scattered_placements(scene)):
        gain = _gain(scene, np.ones(len(scene.robot.actuated)), PUSHED)
        yield without_columns({}, max(gain, -CHANCE))


def pushed_here(scene: Scene) -> Iterable[Block]:
    """Return blocks of placements in which the joints were turned so, unlike in the others."""
    J = scene.by_joints
    covariances = J @ J.swapaxes(1, 2)
    roots = np.linalg.cholesky(covariances + 1e-6 * np.eye(3))
    for block in loose_here(scene, roots, PUSHED_HERE):
        (names,) = block.parameters
        if scene.measured(names["placement"]).kind == "sockets":
            yield block


def _gain(
    scene: Scene,
    width: np.ndarray,
    trials: np.ndarray,
) -> float:
    """Return how much likelier noise of the joints, times some trial, is than of the ball.

    In the axes V of J J^T = V d^2 V^T, an error e has the variances d^2 t^2 + s^2 by joint noise t
    and the noise s of the ball; by that of the ball alone all axes have one variance.
    """
    errors = scene.remaining
    variance = float(np.mean(errors**2))
    log_even = np.log(max(variance, 1e-14))
    alike = -1.5 * len(errors) * (log_even + 1)
    J = scene.by_joints * width
    squares, axes = np.linalg.eigh(J @ J.swapaxes(1, 2))
    of_joints = squares * trials[:, None, None] ** 2
    of_ball = scene.noise * np.array([1.0, 0.5])
    variances = of_joints + of_ball[:, None, None, None] ** 2
    terms = np.einsum("nij,ni->nj", axes, errors) ** 2 / variances + np.log(variances)
    logs = -0.5 * terms.sum(axis=(2, 3))
    gain = float(logs.max()) - alike
    return INDEPENDENT * gain
