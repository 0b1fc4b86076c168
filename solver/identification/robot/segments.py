"""Poses of a chain's segments in many configurations, as NumPy computes them for all rows at once.

The kinematics are those of :func:`.frames_and_motions`. A segment is all that moves as one: the
first stands with the base, and each motion moves the next one. Derivatives are exact: each motion
is a slide along an axis or a turn about it. Configurations come last in all arrays.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from .chain import Joint
from .kinematics import frames_of, frames_of_origins, joint_motions
from .rotations import cross_matrices

_BASE = np.eye(3, 4)


@dataclass(frozen=True)
class Motions:
    """M motions of what lies beyond them, each in the frame of a segment that carries its axis."""

    segments: np.ndarray
    """Indices of the segments, shape (M,)."""
    axes: np.ndarray
    """Shape (M, 3)."""
    points: np.ndarray
    """On the axes, shape (M, 3) [m]."""
    slides: np.ndarray
    """True for a slide along the axis, false for a turn about it, shape (M,)."""

    @cached_property
    def turns(self) -> np.ndarray:
        """The turns of what they carry along: the axes, or zero for slides, shape (M, 3)."""
        return np.where(self.slides[:, None], 0.0, self.axes)

    @cached_property
    def crosses(self) -> np.ndarray:
        """The matrices K of the turns a, with K v = a x v, shape (M, 3, 3)."""
        return cross_matrices(self.turns)

    def shifts(self, points: np.ndarray) -> np.ndarray:
        """Return the derivatives of points, shape (S, 3, N), as (M, 3, N), seen by the segments."""
        levers = points[self.segments] - self.points[:, :, None]
        by_turns = np.einsum("mij,mjn->min", self.crosses, levers)
        by_slides = self.axes - self.turns
        return by_turns + by_slides[:, :, None]

    def work(self, forces: np.ndarray, moments: np.ndarray) -> np.ndarray:
        """Return the work of forces by a unit of each motion, shape (M, N).

        What a motion carries along feels a force and a moment about the origin of the motion's
        segment, in that segment's frame, both of shape (S, 3, N).
        """
        force = forces[self.segments]
        moment = moments[self.segments] - cross(self.points[:, :, None], force)
        along = np.where(self.slides[:, None, None], force, moment)
        return np.einsum("mi,min->mn", self.axes, along)


class Segments(NamedTuple):
    """Poses of S segments in the base frame in N configurations."""

    R: np.ndarray
    """Their rotations, shape (S, 3, 3, N)."""
    p: np.ndarray
    """Their origins, shape (S, 3, N) [m]."""

    def turned_back(self, vectors: np.ndarray) -> np.ndarray:
        """Return vectors of the base frame, shape (S, 3, N), in each segment."""
        return np.einsum("sjin,sjn->sin", self.R, vectors)

    def by_rows(self, motions: Motions, vectors: np.ndarray) -> np.ndarray:
        """Return a vector of each motion's segment, (M, 3, N) or (M, 3, 1), in the base frame.

        They have the shape (N, 3, M).
        """
        return np.einsum("mijn,mjn->nim", self.R[motions.segments], vectors)


@dataclass(frozen=True, eq=False)
class SegmentChain:
    """A chain's frames in its S segments, for some frames of its joints."""

    layout: "SegmentLayout"
    by_frames: Motions
    """By the free numbers of the joints' frames."""
    steps: np.ndarray
    """Frames [R | p] of the motions in the segments that they leave, shape (S - 1, 3, 4)."""
    links: np.ndarray
    """Frames [R | p] of base and links in their segments, shape (joints + 1, 3, 4)."""

    @cached_property
    def _turns(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Parts of the steps and turns that are fixed, go with cos(q) and with sin(q)."""
        a = self.layout.motions.axes
        along = a[:, :, None] * a[:, None]
        R = self.steps[:, :, :3]
        parts = R @ along, R @ (np.eye(3) - along), R @ cross_matrices(a)
        fixed, by_cosine, by_sine = (part[..., None] for part in parts)
        return fixed, by_cosine, by_sine

    def at(self, q: np.ndarray) -> Segments:
        """Return the segments in configurations, shape (N, columns).

        A turn by q about a is a a^T + cos(q) (I - a a^T) + sin(q) K, where K v is a x v.
        """
        motions = self.layout.motions
        values = q.T[self.layout.columns]
        angles = np.where(motions.slides[:, None], 0.0, values)[:, None, None]
        fixed, by_cosine, by_sine = self._turns
        turns = fixed + by_cosine * np.cos(angles) + by_sine * np.sin(angles)
        R = np.empty((len(turns) + 1, 3, 3, len(q)))
        R[0] = np.eye(3)[:, :, None]
        for k, turn in enumerate(turns):
            np.einsum("ijn,jkn->ikn", R[k], turn, out=R[k + 1])
        p = np.zeros((len(R), 3, len(q)))
        p[1:] = np.einsum("sijn,sj->sin", R[:-1], self.steps[:, :, 3])
        slides = np.flatnonzero(motions.slides)
        if slides.size:
            directions = R[slides + 1], motions.axes[slides]
            p[slides + 1] += np.einsum("sijn,sj,sn->sin", *directions, values[slides])
        return Segments(R, p.cumsum(axis=0))

    def poses(self, segments: Segments) -> np.ndarray:
        """Return the poses [R | p] of base and links in the base frame, (N, joints + 1, 3, 4)."""
        carriers = self.layout.segments
        poses = np.einsum("lijn,ljk->nlik", segments.R[carriers], self.links)
        poses[..., 3] += segments.p[carriers].transpose(2, 0, 1)
        return poses

    def rotation(self, segments: Segments) -> np.ndarray:
        """Return the last link's rotation, shape (N, 3, 3)."""
        return np.einsum("ijn,jk->nik", segments.R[-1], self.links[-1, :, :3])

    def ball(self, segments: Segments) -> np.ndarray:
        """Return the last link's origin in the base frame, shape (3, N) [m]."""
        place = np.einsum("ijn,j->in", segments.R[-1], self.links[-1, :, 3])
        return place + segments.p[-1]

    def ball_seen(self, segments: Segments) -> np.ndarray:
        """Return the same as all segments see it, shape (S, 3, N) [m]."""
        ball = segments.turned_back(self.ball(segments) - segments.p)
        # exactly, so that what does not shift it has no effect at all
        ball[-1] = self.links[-1, :, 3:]
        return ball


class SegmentLayout:
    """Motions and segments of a chain, whatever its joints' frames.

    Args:
        joints: The chain.
        columns: Numbers of a configuration: positions of the joints that move, and their tilts.
        free: Free numbers of the joints' frames, as indices: six for each joint, of its origin and
            of its rotation.
    """

    def __init__(
        self,
        joints: Sequence[Joint],
        columns: int,
        free: Sequence[int] | np.ndarray = (),
    ) -> None:
        motions = joint_motions(joints, columns)
        counts = np.array([len(of_joint) for of_joint in motions], dtype=int)
        self.segments = np.concatenate([[0], counts.cumsum()])
        """Indices of the segments that carry base and links, shape (joints + 1,)."""
        self._moves = counts > 0
        self._free = np.array(free, dtype=int)
        in_order = [motion for of_joint in motions for motion in of_joint]
        self.columns = np.array([motion.column for motion in in_order], dtype=int)
        """Indices of the motions' numbers in a configuration, shape (S - 1,)."""
        axes = np.reshape([motion.axis for motion in in_order], (-1, 3))
        slides = np.array([motion.slides for motion in in_order], dtype=bool)
        points = np.zeros_like(axes)
        carriers = np.arange(len(axes)) + 1
        self.motions = Motions(carriers, axes, points, slides)
        """From base to ball: each moves the next segment."""
        order = self.columns.argsort()
        self.by_q = Motions(carriers[order], axes[order], points, slides[order])
        """By each number of a configuration."""

    def chain(self, frames: np.ndarray) -> SegmentChain:
        """Return the chain for frames [p | R | axes] of its joints, shape (joints, 3, 7)."""
        links = np.stack([_BASE, *frames[:, :, (1, 2, 3, 0)]])
        for i in range(1, len(frames)):
            if not self._moves[i - 1]:
                links[i + 1] = links[i, :, :3] @ links[i + 1]
                links[i + 1, :, 3] += links[i, :, 3]
        joints = links[1:].copy()
        links[1:][self._moves] = _BASE
        steps = np.tile(_BASE, (len(self.columns), 1, 1))
        steps[self.segments[:-1][self._moves]] = joints[self._moves]
        joint, number = np.divmod(self._free, 6)
        R = links[:-1, :, :3]
        axes = np.concatenate([R, R @ frames[:, :, 4:]], axis=2)
        by_frames = Motions(
            segments=self.segments[joint],
            axes=axes[joint, :, number],
            points=joints[joint, :, 3],
            slides=number < 3,
        )
        return SegmentChain(self, by_frames, steps, links)


def link_poses(
    joints: Sequence[Joint],
    q: np.ndarray,
    origins: np.ndarray | None = None,
) -> np.ndarray:
    """Return the poses of the base link and of the joints' child links in the base frame.

    Args:
        joints: The chain.
        q: Positions of the joints that move, shape (N, m) [rad], [m] for a prismatic joint.
        origins: Of all joints, shape (joints, 6); None for those that are written.

    Returns:
        [R | p], shape (N, joints + 1, 3, 4).
    """
    frames = frames_of(joints) if origins is None else frames_of_origins(origins)
    chain = SegmentLayout(joints, q.shape[1]).chain(frames)
    return chain.poses(chain.at(q))


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the cross products of vectors, shape (..., 3, N)."""
    first, second = (1, 2, 0), (2, 0, 1)
    return a[..., first, :] * b[..., second, :] - a[..., second, :] * b[..., first, :]
