"""Coordinate frames: poses, the best rigid motion between points, and first poses of frames.

The first robot's base is the *world*; where trackers, tables and other bases stand in it follows
from what they share: a socket, or a ball that was measured.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import compress

import numpy as np

from ....errors import MukcaError, NotConverged
from ..robot import Origin, cross_matrices, matrix_rpy, rpy_of, turn

MAX_ERROR = 0.25
"""A point cannot be this far from its place by the nominal model [m]: no arm deviates so, nor does
a guessed ball."""
UNLIKE = 20.0
"""Coordinates whose spread is this many times that of the ball are not in metres."""
SAME = 1e-6
"""Coordinates whose spread is less than this share of the ball's are no measurements."""
STANDS_OUT = 8.0
"""A line is wrong that is so many times as far off as the median; where all are, the model is."""
MIRRORED = 0.2
"""Coordinates fit much better mirrored, if that leaves less than this share of the error."""
REWEIGHTINGS = 20


class FrameError(MukcaError):
    """Coordinates that cannot be, or a frame that nothing ties to the robot."""


@dataclass(frozen=True)
class Pose:
    """Pose of a frame in another: p_outer = rotation @ p_inner + translation."""

    rotation: np.ndarray
    """Shape (3, 3)."""
    translation: np.ndarray
    """Shape (3,) [m]."""

    @staticmethod
    def of(origin: Origin) -> "Pose":
        """Return the pose that a joint's origin says."""
        return Pose(matrix_rpy(origin.rpy), np.array(origin.xyz))

    @property
    def origin(self) -> Origin:
        """The pose as a joint's origin, with R = Rz(yaw) Ry(pitch) Rx(roll)."""
        return Origin.of([*self.translation, *rpy_of(self.rotation)])

    @property
    def matrix(self) -> np.ndarray:
        """The pose as a matrix [R p; 0 0 0 1], shape (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation
        matrix[:3, 3] = self.translation
        return matrix

    def __matmul__(self, inner: "Pose") -> "Pose":
        """Return a pose of the outer frame that is given in the inner one."""
        return Pose(self.rotation @ inner.rotation, self.apply(inner.translation))

    def apply(self, points: np.ndarray) -> np.ndarray:
        """Return points of the inner frame in the outer one, shape (N, 3) [m]."""
        return points @ self.rotation.T + self.translation

    def inverse(self) -> "Pose":
        """Return the pose of the outer frame in the inner one."""
        return Pose(self.rotation.T, -self.rotation.T @ self.translation)

    def moved(self, change: np.ndarray) -> "Pose":
        """Return the pose after a turn about the outer axes [rad], then a shift [m], shape (6,)."""
        rotation = turn(change[:3]) @ self.rotation
        return Pose(rotation, self.translation + change[3:])

    def slopes(self, points: np.ndarray) -> np.ndarray:
        """Return the derivatives of :meth:`apply` by the numbers of :meth:`moved`, (N, 3, 6).

        d(turn x p) = -[p]x d(turn), with p = rotation @ point.
        """
        slopes = np.zeros((len(points), 3, 6))
        slopes[:, :, :3] = -cross_matrices(points @ self.rotation.T)
        slopes[:, :, 3:] = np.eye(3)
        return slopes


def as_point(vector: np.ndarray) -> tuple[float, float, float]:
    """Return a vector of three as numbers."""
    x, y, z = vector.tolist()
    return x, y, z


IDENTITY = Pose(np.eye(3), np.zeros(3))


def nearest_rotation(matrix: np.ndarray, *, mirrored: bool = False) -> np.ndarray:
    """Return the rotation nearest to a matrix, or the reflection, shape (3, 3)."""
    U, _, Vt = np.linalg.svd(matrix)
    U[:, 2] *= np.sign(np.linalg.det(U @ Vt)) * (-1 if mirrored else 1)
    return U @ Vt


def kabsch_rotation(
    inner: np.ndarray,
    outer: np.ndarray,
    weights: np.ndarray | float,
    *,
    mirrored: bool = False,
) -> np.ndarray:
    """Return the rotation that turns vectors closest to others, shape (3, 3) (Kabsch, 1976).

    ``inner`` is turned into ``outer``, both of shape (N, 3), with weights of shape (N,);
    ``mirrored`` asks for the best reflection instead, which no rigid motion can be.
    """
    return nearest_rotation((outer.T * weights) @ inner, mirrored=mirrored)


def kabsch(
    inner: np.ndarray,
    outer: np.ndarray,
    weights: np.ndarray | float = 1.0,
    *,
    mirrored: bool = False,
) -> Pose:
    """Return the pose that brings points closest to others; see :func:`kabsch_rotation`."""
    weights = np.broadcast_to(weights, len(inner))
    share = weights / weights.sum()
    middle = share @ inner
    target = share @ outer
    R = kabsch_rotation(inner - middle, outer - target, share, mirrored=mirrored)
    return Pose(R, target - R @ middle)


def robust_weights(squares: np.ndarray) -> np.ndarray:
    """Return weights that fall with squared errors, shape (N,)."""
    typical = max(float(np.median(squares)), 1e-24)
    return 1 / (1 + squares / (5 * typical))


def fit_pose(inner: np.ndarray, outer: np.ndarray, *, mirrored: bool = False) -> Pose:
    """Return the pose that brings points closest to others, robustly.

    Each round is :func:`kabsch`, with weights that fall with the distance left: a point that is far
    off hardly counts. Points have shape (N, 3) [m].
    """
    pose = kabsch(inner, outer, mirrored=mirrored)
    for _ in range(REWEIGHTINGS - 1):
        errors = pose.apply(inner) - outer
        weights = robust_weights(np.sum(errors**2, axis=1))
        pose = kabsch(inner, outer, weights, mirrored=mirrored)
    return pose


@dataclass(frozen=True)
class FrameObservations:
    """Positions that are known in one frame; equal numbers are one place."""

    name: str
    """Name of the frame, for messages."""
    numbers: np.ndarray
    """Indices of the places, shape (L,)."""
    points: np.ndarray
    """Their coordinates in the frame, shape (L, 3) [m]."""
    wheres: Sequence[str]
    """File and line of each, for messages."""

    def joined(self, frame: "FrameObservations") -> "FrameObservations":
        """Return these and further positions of the same frame."""
        return FrameObservations(
            self.name,
            np.concatenate([self.numbers, frame.numbers]),
            np.concatenate([self.points, frame.points]),
            [*self.wheres, *frame.wheres],
        )


def place_frames(frames: Sequence[FrameObservations]) -> list[Pose]:
    """Return first poses of frames in the first one, from the places that they have in common.

    Frame after frame is placed, the one that shares most with those placed already first.
    """
    world = _places_of(frames[0], frames)
    poses = {0: IDENTITY}
    # nothing depends on a frame without places
    poses |= {i: IDENTITY for i, frame in enumerate(frames) if not len(frame.numbers)}
    while waiting := [i for i in range(len(frames)) if i not in poses]:
        known = {i: ~np.isnan(world[frames[i].numbers, 0]) for i in waiting}
        best = max(waiting, key=lambda i: int(known[i].sum()))
        frame = frames[best]
        if not known[best].any():
            raise FrameError(
                f"frame {frame.name!r}: nothing ties it to the robot; no socket of it was visited "
                "by an arm whose place is known, nor a ball of such an arm measured in it"
            )
        poses[best] = _placed(frame, world)
        new = ~known[best]
        world[frame.numbers[new]] = poses[best].apply(frame.points[new])
    return [poses[i] for i in range(len(frames))]


def _places_of(
    frame: FrameObservations, frames: Sequence[FrameObservations]
) -> np.ndarray:
    """Return a frame's places by the numbers of several frames, shape (L, 3) [m], or NaN."""
    count = 1 + max(int(frame.numbers.max(initial=-1)) for frame in frames)
    places = np.full((count, 3), np.nan)
    places[frame.numbers] = frame.points
    return places


def _placed(frame: FrameObservations, world: np.ndarray) -> Pose:
    """Return the pose of a frame by those of its places that are known, after checks."""
    known = ~np.isnan(world[frame.numbers, 0])
    inner = frame.points[known]
    outer = world[frame.numbers[known]]
    wheres = list(compress(frame.wheres, known))
    ratio = _spread(inner) / max(_spread(outer), 1e-9)
    if len(inner) > 1 and ratio < SAME:
        raise FrameError(
            f"{wheres[0]}: coordinates of frame {frame.name!r} are all the same, and those of the "
            "ball by the model are not; measure each place anew"
        )
    if len(inner) > 1 and not 1 / UNLIKE < ratio < UNLIKE:
        units = ("millimetres", "metres") if ratio > 1 else ("metres", "millimetres")
        raise FrameError(
            f"{wheres[0]}: coordinates of frame {frame.name!r} are {ratio:.3g} times as far apart "
            f"as the ball is by the model; are they {units[0]} where {units[1]} are expected?"
        )
    pose = fit_pose(inner, outer)
    misfit = np.linalg.norm(pose.apply(inner) - outer, axis=1)
    what = f"{wheres[0]}: coordinates of frame {frame.name!r}"
    is_off = misfit > MAX_ERROR
    if len(inner) > 3:
        check_handedness(inner, outer, what)
        if is_off.mean() > 0.5:
            raise NotConverged(
                f"{what} are more than {MAX_ERROR:g} m from where the nominal model has the ball, "
                f"{is_off.sum()} of {len(inner)}. Is a joint's zero or sign other than the "
                "model's, are columns exchanged, or is it another frame? mukca check shows it"
            )
        is_off &= misfit > STANDS_OUT * np.median(misfit)
    words = f"by the other places of frame {frame.name!r}; a wrong line, unit or frame"
    _check_near(is_off * misfit, wheres, f", {words}")
    return pose


def check_handedness(inner: np.ndarray, outer: np.ndarray, what: str) -> None:
    """Refuse points that fit others far better mirrored, both of shape (N, 3) [m]."""
    poses = fit_pose(inner, outer), fit_pose(inner, outer, mirrored=True)
    errors = [np.linalg.norm(pose.apply(inner) - outer, axis=1) for pose in poses]
    typical, of_mirror = np.median(errors, axis=1)
    if typical > max(0.01, of_mirror / MIRRORED):
        raise FrameError(
            f"{what} are mirrored (left-handed): swap two axes, or change the sign of one"
        )


def _check_near(misfit: np.ndarray, wheres: Sequence[str], words: str) -> None:
    """Refuse places that are far from the nominal model's balls [m]; ``words`` end the message."""
    worst = int(np.argmax(misfit))
    if misfit[worst] > MAX_ERROR:
        raise FrameError(
            f"{wheres[worst]}: {misfit[worst]:.3g} m from where the nominal model has the ball "
            f"({np.sum(misfit > MAX_ERROR)} such){words}"
        )


def check_base(measured: FrameObservations, visited: FrameObservations) -> None:
    """See that sockets measured in a robot's own base are near where the nominal robot was."""
    if not np.isin(measured.numbers, visited.numbers).any():
        return
    world = _places_of(visited, [visited, measured])
    _placed(replace(measured, name=visited.name), world)
    distances = np.linalg.norm(measured.points - world[measured.numbers], axis=1)
    axes = "coordinates in the base frame have its origin and axes as the URDF's base link does"
    _check_near(np.nan_to_num(distances), measured.wheres, f"; {axes}")


def _spread(points: np.ndarray) -> float:
    """Return the typical distance of points from their middle [m]."""
    arms = points - np.median(points, axis=0)
    return float(np.median(np.linalg.norm(arms, axis=1)))
