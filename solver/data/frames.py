"""Coordinate frames: poses, the best rigid motion between points, and first poses of frames.

The first robot's base is the *world*; where trackers, tables and other bases stand in it follows
from what they share: a socket, or a ball that was measured.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...errors import MukcaError
from ..robot import Origin, matrix_rpy, rpy_of, turn

MAX_ERROR = 0.25
"""A point cannot be this far from its place by the nominal model [m]: no arm deviates so, nor does
a guessed ball."""
UNLIKE = 20.0
"""Coordinates whose spread is this many times that of the ball are not in metres."""
SAME = 1e-6
"""Coordinates whose spread is less than this share of the ball's are no measurements."""
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
        return np.block([[self.rotation, self.translation[:, None]], [np.eye(4)[3:]]])

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
        return Pose(turn(change[:3]) @ self.rotation, self.translation + change[3:])

    def slopes(self, points: np.ndarray) -> np.ndarray:
        """Return the derivatives of :meth:`apply` by the numbers of :meth:`moved`, (N, 3, 6).

        d(turn x p) = -[p]x d(turn), with p = rotation @ point.
        """
        x, y, z = (points @ self.rotation.T).T
        slopes = np.zeros((len(points), 3, 6))
        slopes[:, 0, 1], slopes[:, 0, 2] = z, -y
        slopes[:, 1, 0], slopes[:, 1, 2] = -z, x
        slopes[:, 2, 0], slopes[:, 2, 1] = y, -x
        slopes[:, :, 3:] = np.eye(3)
        return slopes


def as_point(vector: np.ndarray) -> tuple[float, float, float]:
    """Return a vector of three as numbers."""
    x, y, z = vector.tolist()
    return x, y, z


IDENTITY = Pose(np.eye(3), np.zeros(3))


def kabsch_rotation(
    inner: np.ndarray,
    outer: np.ndarray,
    weights: np.ndarray | None = None,
    *,
    mirrored: bool = False,
) -> np.ndarray:
    """Return the rotation that turns vectors closest to others, shape (3, 3) (Kabsch, 1976).

    ``inner`` is turned into ``outer``, both of shape (N, 3), with weights of shape (N,);
    ``mirrored`` asks for the best reflection instead, which no rigid motion can be.
    """
    w = np.ones(len(inner)) if weights is None else weights
    U, _, Vt = np.linalg.svd((w[:, None] * inner).T @ outer)
    sign = np.sign(np.linalg.det(U) * np.linalg.det(Vt)) * (-1 if mirrored else 1)
    return Vt.T @ np.diag([1.0, 1.0, sign]) @ U.T


def kabsch(
    inner: np.ndarray,
    outer: np.ndarray,
    weights: np.ndarray | None = None,
    *,
    mirrored: bool = False,
) -> Pose:
    """Return the pose that brings points closest to others; see :func:`kabsch_rotation`."""
    share = np.full(len(inner), 1 / len(inner)) if weights is None else weights / weights.sum()
    middle = share @ inner
    target = share @ outer
    R = kabsch_rotation(inner - middle, outer - target, share, mirrored=mirrored)
    return Pose(R, target - R @ middle)


def robust_weights(squares: np.ndarray) -> np.ndarray:
    """Return weights that fall with squared errors, shape (N,)."""
    return 1 / (1 + squares / (5 * max(float(np.median(squares)), 1e-24)))


def fit_pose(inner: np.ndarray, outer: np.ndarray, *, mirrored: bool = False) -> Pose:
    """Return the pose that brings points closest to others, robustly.

    Each round is :func:`kabsch`, with weights that fall with the distance left: a point that is far
    off hardly counts. Points have shape (N, 3) [m].
    """
    weights = np.ones(len(inner))
    pose = IDENTITY
    for _ in range(REWEIGHTINGS):
        pose = kabsch(inner, outer, weights, mirrored=mirrored)
        weights = robust_weights(np.sum((pose.apply(inner) - outer) ** 2, axis=1))
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
    count = 1 + max(int(frame.numbers.max(initial=-1)) for frame in frames)
    world = np.full((count, 3), np.nan)
    poses: list[Pose | None] = [IDENTITY, *([None] * (len(frames) - 1))]
    world[frames[0].numbers] = frames[0].points
    for i, frame in enumerate(frames):
        poses[i] = poses[i] if len(frame.numbers) else IDENTITY  # nothing depends on it
    while waiting := [i for i, pose in enumerate(poses) if pose is None]:
        shared = {i: ~np.isnan(world[frames[i].numbers, 0]) for i in waiting}
        best = max(waiting, key=lambda i: int(shared[i].sum()))
        frame = frames[best]
        visited_twice = shared[best]
        if not visited_twice.any():
            raise FrameError(
                f"frame {frame.name!r}: nothing ties it to the robot; no socket of it was visited "
                "by an arm whose place is known, nor a ball of such an arm measured in it"
            )
        pose = _placed(frame, visited_twice, world[frame.numbers])
        poses[best] = pose
        new = frame.numbers[~visited_twice]
        world[new] = pose.apply(frame.points[~visited_twice])
    return [pose for pose in poses if pose is not None]


def _placed(frame: FrameObservations, shared: np.ndarray, world: np.ndarray) -> Pose:
    """Return the pose of a frame by those of its places that are known, after checks."""
    inner = frame.points[shared]
    outer = world[shared]
    wheres = [where for where, is_shared in zip(frame.wheres, shared, strict=True) if is_shared]
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
    if len(inner) > 3:
        mirror = fit_pose(inner, outer, mirrored=True)
        misfit_of_mirror = np.linalg.norm(mirror.apply(inner) - outer, axis=1)
        if np.median(misfit) > 0.01 and np.median(misfit_of_mirror) < MIRRORED * np.median(misfit):
            raise FrameError(
                f"{wheres[0]}: coordinates of frame {frame.name!r} are mirrored (left-handed): "
                "swap two axes, or change the sign of one"
            )
    worst = int(np.argmax(misfit))
    if misfit[worst] > MAX_ERROR:
        raise FrameError(
            f"{wheres[worst]}: {misfit[worst]:.3g} m from where the nominal model has the ball, by "
            f"the other places of frame {frame.name!r}; a wrong line, unit or frame"
        )
    return pose


def check_base(measured: FrameObservations, visited: FrameObservations) -> None:
    """See that sockets measured in a robot's own base are near where the nominal robot was."""
    visited_again = np.isin(measured.numbers, visited.numbers)
    if not visited_again.any():
        return
    places = dict(zip(visited.numbers.tolist(), visited.points, strict=True))
    world = np.full(measured.points.shape, np.nan)
    world[visited_again] = [places[number] for number in measured.numbers[visited_again].tolist()]
    _placed(replace(measured, name=visited.name), visited_again, world)
    distances = np.linalg.norm(measured.points - world, axis=1)
    worst = int(np.nanargmax(distances))
    if distances[worst] > MAX_ERROR:
        raise FrameError(
            f"{measured.wheres[worst]}: {distances[worst]:.3g} m from where the nominal model "
            "has the ball; coordinates in the base frame have its origin and axes as the URDF's "
            "base link does"
        )


def _spread(points: np.ndarray) -> float:
    """Return the typical distance of points from their middle [m]."""
    return float(np.median(np.linalg.norm(points - np.median(points, axis=0), axis=1)))
