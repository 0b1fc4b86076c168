"""Poses that tell the zeros of a calibrated arm's joints best, for :func:`plan_poses` to choose."""

from collections.abc import Mapping

import numpy as np

from ..calibration import Calibration
from ..design import ParameterCovariance, Workspace
from ..robot import Robot
from .evidence import ZERO
from .prior import prior_of

POOLED = 40
"""Poses of each socket by which it is seen which zeros such samples tell at all."""
TOLD = 1e-3
"""Standard deviation by so many samples beyond which a zero is not planned for [rad], [m]."""


def zero_covariance(arm: Calibration | Robot, sockets: int = 2) -> ParameterCovariance:
    """Return what is known of an arm whose zeros are lost, before the first sample in a socket."""
    prior = prior_of(arm)
    size = prior.model.size
    covariance = prior.covariance[:size, :size].copy()
    covariance.ravel()[:: size + 1][prior.zeros] += ZERO**2
    known = ParameterCovariance(prior.model, prior.mean[:size], prior.noise, covariance)
    for _ in range(sockets):
        known = known.with_socket()
    return known


def zeros_told(known: ParameterCovariance, pools: Mapping[int, np.ndarray]) -> Workspace:
    """Return the zeros that samples in sockets tell, in place of distances in the workspace.

    Args:
        known: What is known before the samples.
        pools: For each socket, poses that reach it, shape (N, m).
    """
    zeros: np.ndarray = np.eye(known.model.size)[known.model.slices[0]]
    for k, q in pools.items():
        known = known.with_samples(q[:POOLED], k)
    told = known.deviations(Workspace(zeros, np.zeros(len(zeros)))) < TOLD
    return Workspace(zeros[told], np.zeros(int(told.sum())))
