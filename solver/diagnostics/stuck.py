"""A joint that reads one and the same angle although it moved: an encoder or a topic that is stuck.

The angle of each such sample is unknown then: it is sought together with the places of the seats.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from .hypotheses import Candidate, Parameters, Scene, kind_of, sound_recordings
from .robust_fit import UNEXPLAINED, RigidModel

SAME, LEAST = 1e-9, 6
"""Readings that differ by less are one [rad], and the fewest of them that are looked at."""
MOVED = 0.2
"""Travel of the other joints meanwhile from which the arm moved [rad]."""
WIDTH = 1.0
"""Width of the prior of each unknown angle [rad]."""
STEPS, LARGEST_STEP, ROUNDS = 20, 0.3, 2
"""Steps of the angles, the largest of them [rad], and fits of the arm between them."""
ALL_ROUND, ANGLES = (0, 3, 6, 9), np.linspace(-np.pi, np.pi, 48, endpoint=False)
"""Steps before which all angles are tried, and these [rad]."""
FEW_CIRCLES = 4
"""Samples on whose circles a seat is sought of which no sample is as it was read."""
STUCK = kind_of("stuck")


def of_stuck(model: RigidModel, scene: Scene) -> list[Candidate]:
    """Return candidates: a joint that is stuck in a placement, or in all of them."""
    candidates = list[Candidate]()
    for joint in range(scene.q.shape[1]):
        runs = dict(_runs(scene, joint))
        tried = [(rows, scene.named(place)) for place, rows in runs.items()]
        if len(runs) == len(scene.places) > 1:
            tried = [(np.concatenate([*runs.values()]), dict[str, str]())]
        for rows, names in tried:
            changed = _freed(model, scene, joint, rows)
            if changed is not None:
                candidates.append(_candidate(changed, joint, rows, names))
    return candidates


def _runs(scene: Scene, joint: int) -> Iterator[tuple[int, np.ndarray]]:
    """Yield placements at whose end a joint reads one angle while others move, and these samples.

    Samples are indices of rows.
    """
    for place, rows in enumerate(scene.places):
        order = rows.start + np.argsort(scene.times[place])
        angles = scene.q[order, joint]
        elsewhere = np.flatnonzero(np.abs(angles - angles[-1]) > SAME)
        first = int(elsewhere[-1]) + 1 if len(elsewhere) else 0
        run = order[first:]
        travels = np.ptp(scene.q[run], axis=0)
        if len(run) >= LEAST and float(travels.max()) > MOVED:
            yield place, np.sort(run)


def _freed(
    model: RigidModel, scene: Scene, joint: int, rows: np.ndarray
) -> Scene | None:
    """Return the scene with a joint's angles unknown in some samples; None where no fit explains.

    The arm begins as its model has it: a fit to such samples is of no use.
    """
    changed, noise = replace(scene, x=np.zeros_like(scene.x)), 0.0
    for _ in range(ROUNDS):
        angles = _angles(model, changed.x, scene, joint, rows)
        changed, noise = model.refitted(replace(scene, readings=angles))
    if noise > UNEXPLAINED:
        return None
    each = np.eye(len(scene.q))[:, rows]
    columns = WIDTH * changed.by_joints[:, :, [joint]] * each[:, None]
    flat = columns.reshape(-1, len(rows))
    unknown_angles = (scene.all_samples, flat, np.zeros(len(flat)))
    return replace(changed, explained=(*scene.explained, unknown_angles))


def _angles(
    model: RigidModel, x: np.ndarray, scene: Scene, joint: int, rows: np.ndarray
) -> np.ndarray:
    """Return positions with the angles of a joint that bring the balls of each seat together.

    Along u_i, the derivative of ball i by the angle, nothing is known of the samples in ``rows``:
    with P_i = 1 - u_i u_i^T / |u_i|^2, and 1 for all others, the seat is at
    c = (sum P_i)^-1 sum P_i p_i. Angles all round are tried first.
    """
    q, seats = scene.q.copy(), scene.sockets
    is_free = np.isin(np.arange(len(q)), rows)
    circles = _circles(model, x, q[rows], joint) - scene.offsets[rows]
    for step in range(STEPS):
        points, _, by_joints = model.linearised(x, q)
        p, u = points - scene.offsets, by_joints[:, :, joint] * is_free[:, None]
        size = np.sum(u**2, axis=1) + 1e-6
        P = np.eye(3) - u[:, :, None] * u[:, None] / size[:, None, None]
        centres = np.zeros_like(scene.centres)
        for seat in np.unique(seats):
            in_seat = seats == seat
            across = np.einsum("nij,nj->i", P[in_seat], p[in_seat])
            centres[seat] = np.linalg.lstsq(P[in_seat].sum(axis=0), across, rcond=None)[
                0
            ]
            if step == 0 and is_free[in_seat].all():
                centres[seat] = _meeting(circles[:, seats[rows] == seat])
        goal = centres[seats]
        if step in ALL_ROUND:
            distances = np.linalg.norm(circles - goal[rows], axis=2)
            q[rows, joint] = scene.q[rows, joint] + ANGLES[np.argmin(distances, axis=0)]
        else:
            change = -np.sum(u * (p - goal), axis=1) / size
            q[:, joint] += np.clip(change, -LARGEST_STEP, LARGEST_STEP)
    return q


def _circles(model: RigidModel, x: np.ndarray, q: np.ndarray, joint: int) -> np.ndarray:
    """Return the balls of N samples with a joint at A angles all round, shape (A, N, 3) [m]."""
    turned = np.repeat(q[None], len(ANGLES), axis=0)
    turned[:, :, joint] += ANGLES[:, None]
    flat = turned.reshape(-1, q.shape[1])
    points = model.points(x, flat)
    return points.reshape(len(ANGLES), len(q), 3)


def _meeting(circles: np.ndarray) -> np.ndarray:
    """Return the place on the circles of few samples that all circles pass nearest, shape (3,)."""
    places = circles[:, :FEW_CIRCLES].reshape(-1, 3)
    distances = np.linalg.norm(circles[:, :, None] - places, axis=3)
    nearest = distances.min(axis=0)
    farness = np.median(nearest, axis=0)
    return places[int(np.argmin(farness))]


def _candidate(
    changed: Scene, joint: int, rows: np.ndarray, names: dict[str, str]
) -> Candidate:
    """Return the candidate of a scene in which a joint's angles are free."""
    parameters: Parameters = {
        "joint": changed.robot.joint_names[joint],
        "samples": len(rows),
        **names,
    }
    prior = float(np.log(STUCK.prior / changed.q.shape[1] / len(changed.places)))
    return sound_recordings(changed).as_cause(STUCK, parameters, prior)
