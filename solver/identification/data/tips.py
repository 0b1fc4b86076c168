"""A probe's tip on a flange, refitted to points that an instrument measured."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .frames import IDENTITY, fit_pose

ROUNDS = 8
"""Steps of Gauss-Newton; the tip is linear, and the frame turns hardly once it is fitted."""
HELD = 1e-6
"""Weight of no further shift [m/m]: it holds a tip that never turns, of whose place points tell
nothing."""


SHARE = 0.5
"""Share of the error that targets put on anew leave at most."""


class TipSamples(NamedTuple):
    """N points that an instrument measured in one frame."""

    points: np.ndarray
    """p, the balls by a model, shape (N, 3) [m]."""
    rotations: np.ndarray
    """R, orientations of the ball's link by it, shape (N, 3, 3)."""
    measured: np.ndarray
    """y, as measured, shape (N, 3) [m]."""

    def distances(self, shift: np.ndarray) -> np.ndarray:
        """Return the distances that a shift of the tip leaves, shape (N,) [m]."""
        tips = self.points + self.rotations @ shift
        places = fit_pose(self.measured, tips).apply(self.measured)
        return np.linalg.norm(places - tips, axis=1)


def tip_shift(frames: Sequence[TipSamples]) -> np.ndarray:
    """Return how far a probe's tip sits from the ball, in its link's axes, shape (3,) [m].

    The shift d and the pose T of each frame minimise the sum of

        |p_i + R_i d - T y_i|^2
    """
    shift = np.zeros(3)
    for _ in range(ROUNDS):
        columns = [HELD * np.eye(3)]
        offsets = [np.zeros(3)]
        for points, rotations, measured in frames:
            tips = points + rotations @ shift
            places = fit_pose(measured, tips).apply(measured)
            motions = IDENTITY.slopes(places).reshape(-1, 6)
            by_shift = rotations.reshape(-1, 3)
            explained = motions @ np.linalg.lstsq(motions, by_shift, rcond=None)[0]
            columns.append(by_shift - explained)
            offsets.append((places - tips).ravel())
        shift += np.linalg.lstsq(
            np.concatenate(columns), np.concatenate(offsets), rcond=None
        )[0]
    return shift


def tip_shifts(frames: Sequence[TipSamples]) -> tuple[np.ndarray, float]:
    """Return how far the tip sits from the ball in each frame, shape (F, 3), and the error [m].

    It is the same in all, unless shifts of their own leave less than half of the median error. A
    flange that hardly turns does not tell them, and then they leave about as much.
    """
    anew = np.array([tip_shift([frame]) for frame in frames])
    alike = 0 * anew + tip_shift(frames)
    error, least = _median_distance(frames, alike), _median_distance(frames, anew)
    return (anew, least) if least < SHARE * error else (alike, error)


def _median_distance(frames: Sequence[TipSamples], shifts: np.ndarray) -> float:
    """Return the median distance that shifts of the tip leave, one in each frame [m]."""
    distances = map(TipSamples.distances, frames, shifts)
    return float(np.median(np.concatenate([*distances])))
