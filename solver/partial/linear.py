"""A task made linear: errors of its samples, and their derivatives by all unknowns.

The two ways to a place differ by

    t_i = p(F U L) - p(V R)      r_i = log(rot(F U L) rot(V R)^T)

in the base's axes, and derivatives are by small turns about the axes of flange (U) and base (V).
"""

import numpy as np

from ..identification.robot import rotation_vectors
from .prior import Flanges
from .system import System
from .task import State, Task


def linear(task: Task, state: State) -> System:
    """Return a task, linear about a state."""
    prior, rows, x = task.prior, task.rows, state.x
    flanges = prior.flanges(x, rows)
    left, right = rows.resized(float(x[task.scale].sum()))
    turns = state.places[rows.places]
    tools = flanges.R @ state.tool
    arms = np.einsum("nij,nj->ni", tools, left[:, :3, 3])
    levers = arms + flanges.R @ prior.tip(x)
    reaches = np.einsum("nij,nj->ni", turns, right[:, :3, 3])
    place_errors = flanges.p + levers - x[task.places[rows.places, :3]] - reaches
    measured = tools @ left[:, :3, :3]
    seen = turns @ right[:, :3, :3]
    turn_errors = rotation_vectors(measured @ seen.transpose(0, 2, 1))
    errors = np.hstack([place_errors, turn_errors])[:, : rows.axes]

    G = _slopes(task, flanges, levers, arms, reaches)[:, : rows.axes]
    lengths, by_lengths = _distances(task, x)
    slopes = np.vstack([G.reshape(-1, task.size), by_lengths])
    all_errors = np.concatenate([errors.ravel(), lengths])
    at_mean = all_errors - slopes @ (x - task.mean(x))
    by_joints = _at_end(flanges.by_joints, levers)[:, : rows.axes]
    return System(task, state, at_mean, slopes, by_joints)


def _slopes(
    task: Task,
    flanges: Flanges,
    levers: np.ndarray,
    arms: np.ndarray,
    reaches: np.ndarray,
) -> np.ndarray:
    """Return derivatives of the errors of samples by all unknowns, shape (N, 6, size).

    Args:
        task: The samples and unknowns.
        flanges: The flange's poses, and their derivatives.
        levers: From the flange to the end of U L, shape (N, 3) [m].
        arms: From the tip to the same, shape (N, 3) [m].
        reaches: From the place to the end of V R, shape (N, 3) [m].
    """
    prior, rows, R = task.prior, task.rows, flanges.R
    N = len(R)
    G = np.zeros((N, 6, task.size))
    G[:, :, : prior.model.size] = _at_end(flanges.by_unknowns, levers)
    G[:, :3, prior.ball] = R
    if rows.turns:
        by_turns = np.hstack([0 * R, R])
        G[:, :, task.tool_turn] = _at_end(by_turns, arms)
        G[:, :3, task.scale.start] = arms - reaches
    moved_back = np.tile(-np.eye(6), (N, 1, 1))
    by_place = _at_end(moved_back, reaches)[:, :, : rows.place_axes]
    samples = np.arange(N)[:, None]
    G[samples, :, task.places[rows.places]] = by_place.transpose(0, 2, 1)
    return G


def _at_end(slopes: np.ndarray, levers: np.ndarray) -> np.ndarray:
    """Return derivatives of places and turns at the end of levers, shape (N, 6, n).

    A turn w of a lever moves its end by w x lever.

    Args:
        slopes: Those at the beginning, shape (N, 6, n).
        levers: Shape (N, 3) [m].
    """
    moved = slopes.copy()
    moved[:, :3] += np.cross(slopes[:, 3:], levers[:, :, None], axis=1)
    return moved


def _distances(task: Task, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return errors of known distances, shape (D,) [m], and their derivatives, (D, size)."""
    count = len(task.distances)
    slopes = np.zeros((count, task.size))
    errors = np.zeros(count)
    for row, (a, b, distance) in enumerate(task.distances):
        first, second = task.places[[a, b], :3]
        offset = x[second] - x[first]
        length = float(np.linalg.norm(offset))
        direction = offset / length
        slopes[row, second] = direction
        slopes[row, first] = -direction
        errors[row] = length - distance
    return errors, slopes
