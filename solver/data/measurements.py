"""Placements with samples sorted by socket, the load meanwhile, and what an instrument measured.

A measured pose is two samples, place [m] and orientation [rad], which come last.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate
from typing import Literal

import numpy as np

from ...recorder import Placement
from ..robot import STANDARD_GRAVITY, Robot, gravity_moments, rotation_vectors
from .frames import REWEIGHTINGS, FrameError, Pose, robust_weights

ALONG_ONE_AXIS = 1e-3
"""Share of the turns about other axes below which the poses turn about one axis only."""
DOUBTFUL, STRANGE = 5e-3, 0.1
"""Typical angles [rad]: beyond the first other columns are tried, and no arm errs by the second."""
BETTER = 0.25
"""Share of the angle that is left if they turn the other way."""
PART = ", part "
"""Between the name of a placement and the number of its part, where it was split."""
INSTRUMENT = "instrument"
"""Name of an instrument's frame where its recording gives none."""


def rotation_matrices(quaternions: np.ndarray) -> np.ndarray:
    """Return the rotations of unit quaternions x, y, z, w, shape (..., 4), as (..., 3, 3)."""
    x, y, z, w = np.moveaxis(quaternions, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def whole_name(name: str) -> str:
    """Return the name of the recorded placement of which one is all or a part."""
    return name.partition(PART)[0]


@dataclass(frozen=True)
class HandEye:
    """The two unknown poses, and how well they fit."""

    tool: Pose
    """X, what was measured in the link's frame."""
    frame: Pose
    """F, the instrument's frame in the base."""
    angles: np.ndarray
    """Angle that is left of each pose, shape (N,) [rad]."""
    distances: np.ndarray
    """Distance that is left, shape (N,) [m]."""


def hand_eye(
    R: np.ndarray, p: np.ndarray, M: np.ndarray, t: np.ndarray, where: str = "poses"
) -> HandEye:
    """Return where an instrument's frame stands and what the link carries, without any start.

    The link has the poses (R_i, p_i) in the base, and what is fixed to it was measured at (M_i,
    t_i) in the instrument's frame, of shapes (N, 3, 3) and (N, 3) [m]; messages begin with
    ``where``. With F the pose of that frame in the base and X what is fixed,

        F (M_i, t_i) = (R_i, p_i) X

    The rotations follow from the largest singular value of sum M_i (x) R_i (Shah 2013), the places
    from linear least squares, both with weights that fall with the error that is left.
    """
    spread = np.linalg.svd(np.cov(R.reshape(len(R), 9).T), compute_uv=False)
    if spread[3] < ALONG_ONE_AXIS * spread[0]:
        raise FrameError(
            f"{where}: the link turns about one axis only, which leaves open what it carries; turn "
            "it about two axes at least"
        )
    tool, frame, angles = _turns(R, M)
    rows = np.concatenate([R, np.broadcast_to(-np.eye(3), R.shape)], axis=2)
    offset = t @ frame.T - p
    distances, weights = np.zeros(len(R)), np.ones(len(R))
    solution = np.zeros(6)
    for _ in range(REWEIGHTINGS):
        root = np.sqrt(weights)[:, None]
        flat = (rows * root[..., None]).reshape(-1, 6)
        solution = np.linalg.lstsq(flat, (offset * root).ravel(), rcond=1e-6)[0]
        distances, weights = _weighed(rows @ solution - offset)
    return HandEye(Pose(tool, solution[:3]), Pose(frame, solution[3:]), angles, distances)


def _turns(R: np.ndarray, M: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the rotations of the tool and of the frame, and the angles that they leave."""
    K = np.einsum("nbc,nad->abdc", M, R).reshape(9, 9)
    tool = _nearest(np.linalg.svd(K)[2][0].reshape(3, 3))
    frame, weights, angles = tool, np.ones(len(R)), np.zeros(len(R))
    for _ in range(REWEIGHTINGS):
        frame = _nearest(np.einsum("n,nij->ij", weights, R @ tool @ M.swapaxes(1, 2)))
        tool = _nearest(np.einsum("n,nij->ij", weights, R.swapaxes(1, 2) @ frame @ M))
        rotations_left = rotation_vectors(R @ tool @ (frame @ M).swapaxes(1, 2))
        angles, weights = _weighed(rotations_left)
    return tool, frame, angles


def _weighed(errors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the sizes of errors, shape (N, 3), and weights that fall with them."""
    sizes = np.linalg.norm(errors, axis=1)
    return sizes, robust_weights(sizes**2)


def check_orientations(R: np.ndarray, quaternions: np.ndarray, where: str) -> None:
    """See that measured orientations turn as the link does, by its rotations, shape (N, 3, 3).

    Columns swapped, in another order, with a wrong sign, or inverse: all of these quaternions x, y,
    z, w, shape (N, 4), turn the other way, so they are told from right ones, and not from each
    other.
    """
    M = rotation_matrices(quaternions)
    as_is = float(np.median(_turns(R, M)[2]))
    if as_is < DOUBTFUL:
        return
    other_way = float(np.median(_turns(R, M.swapaxes(1, 2))[2])) < BETTER * as_is
    if other_way or as_is > STRANGE:
        words = (
            "they turn the other way: two of the columns qx,qy,qz,qw are swapped, they stand in "
            "another order (qw first?), one has the wrong sign, or the poses are inverse, as a "
            "camera's are"
        )
        if not other_way:
            words = "see the order of the joints, their unit (radians) and the robot's model"
        raise FrameError(
            f"{where}: orientations are {as_is:.2g} rad off those of the robot's flange; {words}"
        )


def _nearest(matrix: np.ndarray) -> np.ndarray:
    """Return the rotation nearest to a matrix or to its opposite, shape (3, 3)."""
    U, _, Vt = np.linalg.svd(matrix * np.sign(np.linalg.det(matrix)))
    return U @ Vt


@dataclass(frozen=True)
class Measurement:
    """A placement with its joints in chain order, and the distance between its sockets."""

    placement: Placement
    """The recording, its joints in the order of the robot's chain."""
    distance: float
    """Between the centres of its first two sockets [m]."""
    distance_source: str = "default"
    """Its source: ``given`` by the user, the ``recording``, nothing but the ``default``, or
    ``located`` by measured coordinates."""
    distance_readings: int = 1
    """Number of readings that agree on it."""
    distance_deviation: float | None = None
    """Its standard deviation [m], where it is not a caliper's."""
    warnings: tuple[str, ...] = field(default=())
    moved: np.ndarray | None = None
    """Movement of the place of each row of :attr:`positions` until then, as a fit found it,
    shape (N, 3) [m]; None for a place that stood still."""

    def at_rest(self, balls: np.ndarray) -> np.ndarray:
        """Return predicted balls as if the place had stood still, shape (N, 3) [m]."""
        return balls if self.moved is None else balls - self.moved

    @property
    def name(self) -> str:
        """The placement's name."""
        return self.placement.name

    @property
    def kind(self) -> Literal["sockets", "points"]:
        """``points`` where an instrument measured each sample's ball, in no socket."""
        return "points" if self.placement.samples[0].point is not None else "sockets"

    @property
    def frame(self) -> str:
        """The name of the instrument's frame."""
        return self.placement.frame or INSTRUMENT

    @cached_property
    def points(self) -> np.ndarray:
        """The measured balls in the instrument's frame, shape (N, 3) [m]."""
        return np.array([sample.point for sample in self.placement.samples], dtype=float)

    @property
    def has_orientations(self) -> bool:
        """True where the instrument measured orientations, too."""
        return self.placement.samples[0].orientation is not None

    @cached_property
    def rotations(self) -> np.ndarray:
        """The measured orientations in the instrument's frame, shape (N, 3, 3)."""
        return rotation_matrices(self.quaternions)

    @cached_property
    def quaternions(self) -> np.ndarray:
        """The same as unit quaternions x, y, z, w, shape (N, 4)."""
        return np.array([sample.orientation for sample in self.placement.samples], dtype=float)

    @cached_property
    def sockets(self) -> tuple[int, ...]:
        """The numbers of the sockets that have samples."""
        return tuple(np.unique(self.placement.sockets).tolist())

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """Number of samples in each socket."""
        return tuple(np.unique(self.placement.sockets, return_counts=True)[1].tolist())

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Rows of :attr:`positions` of each socket's samples."""
        return tuple(
            slice(end - n, end) for n, end in zip(self.counts, accumulate(self.counts), strict=True)
        )

    @cached_property
    def by_socket(self) -> tuple[np.ndarray, ...]:
        """For each socket, the joint positions of its samples, shape (N_k, m) [rad]."""
        return tuple(self.positions[rows] for rows in self.slices)

    @cached_property
    def order(self) -> np.ndarray:
        """Rank in the order of recording of each row of :attr:`positions`, shape (N,)."""
        return np.argsort(self.placement.sockets, kind="stable")

    @cached_property
    def positions(self) -> np.ndarray:
        """Joint positions of all samples, socket after socket, shape (N, m) [rad]."""
        return self.placement.positions[self.order]

    def as_recorded(self, rows: np.ndarray) -> np.ndarray:
        """Return what belongs to rows of :attr:`positions` in the order of recording."""
        return rows[np.argsort(self.order)]

    @cached_property
    def efforts(self) -> np.ndarray | None:
        """Measured joint efforts, row by row as :attr:`positions` [N m]; None without them."""
        efforts = self.placement.efforts
        return None if efforts is None else efforts[self.order]

    def clock(self, name: str) -> np.ndarray:
        """Return the time [s] or temperature of each row of :attr:`positions`, shape (N,).

        Numbered samples that have no time are told apart by their order; NaN where neither is
        known, as of sockets in files of their own.
        """
        samples = self.placement.samples
        t = np.array([getattr(sample, name) for sample in samples], dtype=float)
        if name == "time" and np.isnan(t).any() and all(sample.number for sample in samples):
            t = np.arange(len(samples), dtype=float)
        return t[self.order]

    def only(self, rows: np.ndarray) -> "Measurement":
        """Return the placement with some of its samples, by their :attr:`order`."""
        ranks: list[int] = rows.tolist()
        samples = tuple(self.placement.samples[i] for i in ranks)
        return replace(self, placement=replace(self.placement, samples=samples))

    @property
    def has_distance(self) -> bool:
        """True where two sockets have samples, so that their distance can be compared."""
        return len(self.sockets) > 1


@dataclass(frozen=True)
class Load:
    """Gravity, and a payload at the ball."""

    gravity: tuple[float, float, float]
    """In the base frame [m/s^2]; another direction for an arm on a wall or ceiling."""
    payload: float
    """Mass at the ball, beyond that of the model [kg]."""

    def of(self, placement: Placement) -> "Load":
        """Return the load of a placement, which may state a payload of its own."""
        mass = placement.payload
        return self if mass is None else Load(self.gravity, mass)

    def torques(self, robot: Robot, measured: Measurement) -> np.ndarray:
        """Return the moments that hold the joints in a placement's samples; see :meth:`moments`."""
        load = self.of(measured.placement)
        return load.moments(robot, measured.positions, measured.efforts)

    def by_socket(self, robot: Robot, measured: Measurement) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return joint positions and :meth:`torques` of the samples in each socket."""
        moments = self.torques(robot, measured)
        return [(measured.positions[rows], moments[rows]) for rows in measured.slices]

    def moments(self, robot: Robot, q: np.ndarray, efforts: np.ndarray | None) -> np.ndarray:
        """Return the moments that hold an arm's joints at positions q, shape (N, 3 m) [N m].

        Torques about the joints' own axes, as measured unless ``efforts`` is None, then the moments
        across them, which always follow from the masses.
        """
        moments = gravity_moments(robot, q, self.gravity, self.payload)
        if efforts is not None:
            moments[:, : q.shape[1]] = efforts
        return moments


STANDARD_LOAD = Load(STANDARD_GRAVITY, 0.0)
"""An arm that stands upright and carries nothing beyond its ball."""
