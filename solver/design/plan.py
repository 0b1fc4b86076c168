"""Plans recordings before the first sample: what bases, placements and samples would bring."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..bayes.model import ExtendedModel, PriorGroup, prior_groups
from ..data import CALIPER_DEVIATION, SEAT_DEVIATION, Observations
from .knowledge import ParameterCovariance, Workspace


@dataclass(frozen=True)
class Site:
    """A place for the socket base, and poses that reach its two sockets."""

    centres: np.ndarray
    """Of the sockets, shape (2, 3) [m]."""
    poses: tuple[np.ndarray, np.ndarray]
    """Joint positions for each socket, shape (N, m)."""

    @property
    def along(self) -> np.ndarray:
        """Unit vector from socket 0 to socket 1."""
        offset = self.centres[1] - self.centres[0]
        return offset / np.linalg.norm(offset).clip(1e-9)


def expected_groups(model: ExtendedModel) -> tuple[PriorGroup, ...]:
    """Return what is believed of a rigid arm's geometry before anything is measured."""
    m = len(model.robot.actuated)
    no_rows, no_sockets = np.zeros((0, m)), np.zeros(0, dtype=np.int64)
    return prior_groups(model, Observations(no_rows, np.zeros((0, 2 * m)), no_sockets, (), ()))


def with_site(
    known: ParameterCovariance,
    site: Site,
    where: Workspace,
    samples: int,
    before: Site | None = None,
) -> ParameterCovariance:
    """Return what would be known after recording at another site.

    Args:
        known: What is known.
        site: Where the base would be.
        where: What is to be known.
        samples: How many in each socket; they are chosen greedily among the site's poses.
        before: An earlier site of the same base, whose sockets are the first two of ``known``; its
            distance was measured there. None: it is measured here.
    """
    first = known.sockets
    known = known.with_socket().with_socket()
    u = site.along
    ends = {first: -u, first + 1: u}
    if before is None:
        known = known.with_lengths(ends, CALIPER_DEVIATION)
    else:  # as long as it was there
        ends |= {0: before.along, 1: -before.along}
        known = known.with_lengths(ends, 2**0.5 * SEAT_DEVIATION)
    for i in range(2 * samples):
        socket = i % 2
        poses = site.poses[socket]
        best = best_of(known, poses, first + socket, where)
        known = known.with_samples(poses[best : best + 1], first + socket)
    return known


def best_of(known: ParameterCovariance, poses: np.ndarray, socket: int, where: Workspace) -> int:
    """Return which of some poses would teach most."""
    return int(np.argmax(known.gains(poses, socket, where.shape)))


def between(sites: Sequence[Site]) -> np.ndarray:
    """Return the unit vector from the first socket of one site to that of another."""
    offset = sites[1].centres[0] - sites[0].centres[0]
    return offset / np.linalg.norm(offset).clip(1e-9)
