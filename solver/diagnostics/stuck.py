"""A joint that reads one and the same angle although it moved: an encoder or a topic that is stuck.

The angle of each such sample is unknown then: it is sought together with the places of the seats.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from .hypotheses import Candidate, Scene, kind_of, sound_recordings
from .robust_fit import UNEXPLAINED, RigidModel

SAME = 1e-9
"""Readings that differ by less are one [rad]."""
LEAST = 6
"""The fewest of them that are looked at."""
MOVED = 0.2
"""Travel of the other joints meanwhile from which the arm moved [rad]."""
WIDTH = 1.0
"""Width of the prior of each unknown angle [rad]."""
STEPS = 20
"""Steps of the angles."""
LARGEST_STEP = 0.3
"""The largest of them [rad]."""
ROUNDS = 2
"""Fits of the arm between these."""
ALL_ROUND = (0, 3, 6, 9)
"""Steps before which all angles are tried."""
ANGLES = np.linspace(-np.pi, np.pi, 48, endpoint=False)
"""These angles [rad]."""
FEW_CIRCLES = 4
"""Samples on whose circles a seat is sought of which no sample is as it was read."""
STUCK = kind_of("stuck")


def of_stuck(
    model: RigidModel,
    scene: Scene,
) -> Iterator[Candidate]:
    """Yield candidates: a joint that is stuck in a placement, or in all of them."""
    names = scene.robot.joint_names
    count = len(names) * len(scene.places)
    for joint, name in enumerate(names):
        runs = list(_runs(scene, joint))
        if len(runs) == len(scene.places) > 1:
            runs = [(None, np.concatenate([rows for _, rows in runs]))]
        for placement, rows in runs:
            changed = _freed(model, scene, joint, rows)
            if changed is not None:
                sound = sound_recordings(changed)
                yield sound.as_cause(
                    STUCK, {"joint": name, "samples": len(rows)}, count, placement
                )


def _runs(
    scene: Scene,
    joint: int,
) -> Iterator[tuple[str | None, np.ndarray]]:
    """Yield the placements at whose end a joint reads one angle while others move.

    Each by its name, with the indices of these samples.
    """
    for place, rows in enumerate(scene.places):
        order = rows.start + np.argsort(scene.ranks[place])
        angles = scene.q[order, joint]
        differs = np.abs(angles - angles[-1]) > SAME
        first = len(order) - int(np.argmax(np.append(differs[::-1], True)))
        run = np.sort(order[first:])
        travels = np.ptp(scene.q[run], axis=0)
        if len(run) >= LEAST and float(travels.max()) > MOVED:
            yield scene.measurements[place].name, run


def _freed(
    model: RigidModel,
    scene: Scene,
    joint: int,
    rows: np.ndarray,
) -> Scene | None:
    """Return the scene with a joint's angles unknown in some samples; None where no fit explains.

    The arm begins as its model has it: a fit to such samples is of no use.
    """
    changed, noise = replace(scene, x=np.zeros_like(scene.x)), 0.0
    for _ in range(ROUNDS):
        readings = _readings(model, changed.x, scene, joint, rows)
        changed, noise = model.refitted(replace(scene, readings=readings))
    if noise > UNEXPLAINED:
        return None
    each = np.eye(len(scene.q))[:, rows]
    columns = WIDTH * changed.by_joints[:, :, [joint]] * each[:, None]
    flat = columns.reshape(-1, len(rows))
    unknown_angles = (scene.all_samples, flat, np.zeros(len(flat)))
    return replace(changed, explained=(*scene.explained, unknown_angles))


def _readings(
    model: RigidModel,
    x: np.ndarray,
    scene: Scene,
    joint: int,
    rows: np.ndarray,
) -> np.ndarray:
    """Return positions with the angles of a joint that bring the balls of each seat together.

    Along u_i, the derivative of ball i by the angle, nothing is known of the samples of some rows.
    Angles all round are tried first.
    """
    q = scene.q.copy()
    is_free = np.isin(np.arange(len(q)), rows)
    circles = _circles(model, x, q[rows], joint) - scene.offsets[rows]
    for step in range(STEPS):
        points, _, by_joints = model.linearised(x, q)
        places = points - scene.offsets
        u = by_joints[:, :, joint] * is_free[:, None]
        size = np.sum(u**2, axis=1) + 1e-6
        centres = _centres(scene, places, u, size)
        if step == 0:
            for seat in np.unique(scene.sockets[rows]):
                if is_free[scene.sockets == seat].all():
                    of_seat = scene.sockets[rows] == seat
                    centres[seat] = _meeting(circles[:, of_seat])
        goals = centres[scene.sockets]
        if step in ALL_ROUND:
            distances = np.linalg.norm(circles - goals[rows], axis=2)
            nearest = ANGLES[np.argmin(distances, axis=0)]
            q[rows, joint] = scene.q[rows, joint] + nearest
        else:
            change = -np.sum(u * (places - goals), axis=1) / size
            q[:, joint] += np.clip(change, -LARGEST_STEP, LARGEST_STEP)
    return q


def _centres(
    scene: Scene,
    places: np.ndarray,
    u: np.ndarray,
    size: np.ndarray,
) -> np.ndarray:
    """Return where the samples of each seat meet that are free along u, shape (S, 3) [m].

    With P_i = 1 - u_i u_i^T / |u_i|^2 the seat is at c = (sum P_i)^-1 sum P_i p_i; ``size`` has the
    squares |u_i|^2.
    """
    along = u[:, :, None] * u[:, None]
    P = np.eye(3) - along / size[:, None, None]
    centres = np.zeros_like(scene.centres)
    for seat in np.unique(scene.sockets):
        in_seat = scene.sockets == seat
        total = P[in_seat].sum(axis=0)
        across = np.einsum("nij,nj->i", P[in_seat], places[in_seat])
        centres[seat] = np.linalg.lstsq(total, across, rcond=None)[0]
    return centres


def _circles(
    model: RigidModel,
    x: np.ndarray,
    q: np.ndarray,
    joint: int,
) -> np.ndarray:
    """Return the balls of N samples with a joint at A angles all round, shape (A, N, 3) [m]."""
    of_joint = np.eye(q.shape[1])[joint]
    turned = q + ANGLES[:, None, None] * of_joint
    points = model.points(x, turned.reshape(-1, len(of_joint)))
    return points.reshape(*turned.shape[:2], 3)


def _meeting(circles: np.ndarray) -> np.ndarray:
    """Return the place on the circles of few samples that all circles pass nearest, shape (3,)."""
    places = circles[:, :FEW_CIRCLES].reshape(-1, 3)
    distances = np.linalg.norm(circles[:, :, None] - places, axis=3)
    farness = np.median(distances.min(axis=0), axis=0)
    return places[int(np.argmin(farness))]
