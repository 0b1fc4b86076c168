"""Eq. (5) of the paper, one placement with sockets 0 and 1, as residuals to be squared and summed.

    J = (N0 tr(S0) + N1 tr(S1)) / (N0 + N1)       inconsistency
      + (|mu1 - mu0| - d)^2                       distortion
      + lambda |Theta - Theta_nominal|^2          regularisation

S_k is the covariance (1/N) of the predicted ball centres in socket k, mu_k their mean.

Points come as matrices of shape (3, N), one column a sample. The functions use nothing but
``@``, ``+``, ``-``, ``*``, so they take NumPy arrays and CasADi expressions alike; and those that
are linear take derivatives of points too, with the parameters as a leading axis.
"""

from typing import Any

import numpy as np

__all__ = ["deviations", "distance", "inconsistency", "mean", "regularisation"]


def mean(points: Any) -> Any:
    """Return the mean of the columns, shape (3, 1): mu. Linear."""
    count = points.shape[-1]
    return points @ np.full((count, 1), 1.0 / count)


def deviations(points: Any) -> Any:
    """Return each column less the mean, shape (3, N). Linear."""
    return points - mean(points) @ np.ones((1, points.shape[-1]))


def inconsistency(points: Any, total: int) -> Any:
    """Return one socket's residuals, whose squares sum to N_k tr(S_k) / total. Linear.

    Args:
        points: Predicted ball centres in the socket, shape (3, N_k) [m].
        total: Number of samples in all sockets of the placement, N0 + N1.
    """
    return deviations(points) * (1.0 / total**0.5)


def distance(points_0: Any, points_1: Any) -> Any:
    """Return |mu1 - mu0|, shape (1, 1) [m]; less d it is the distortion's residual."""
    offset = mean(points_1) - mean(points_0)
    return (offset.T @ offset) ** 0.5


def regularisation(parameters: Any, nominal: Any, weight: float) -> Any:
    """Return the residuals whose squares sum to weight |Theta - Theta_nominal|^2. Linear."""
    return (parameters - nominal) * weight**0.5
