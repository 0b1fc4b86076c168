"""Eq. (5) of the paper, for one placement with sockets 0 and 1, as residuals.

Its value J is the sum of their squares, so that a least-squares optimizer can minimise it:

    J = (N0 tr(S0) + N1 tr(S1)) / (N0 + N1)       inconsistency
      + (|mu1 - mu0| - d)^2                       distortion
      + lambda |Theta - Theta_nominal|^2          regularization

- N_k is the number of samples in socket k, mu_k the mean of their predicted ball centres, and S_k
  their covariance (divided by N_k), whose trace is their mean square distance from mu_k.
- d is the measured distance between the sockets [m].
- Theta is the vector of parameters [m, rad], and lambda the weight that keeps it near nominal.

In words: all balls of a socket should be predicted at one point, the two points should be as far
apart as measured, and the robot should not change without need.

Points come as matrices of shape (3, N), one column a sample. The functions use nothing but
``@``, ``+``, ``-``, ``*``, so they take NumPy arrays and CasADi expressions alike. Those marked
linear also turn derivatives of points, shape (n, 3, N) for n parameters, into their own
derivatives.
"""

from typing import Any

import numpy as np


def mean(points: Any) -> Any:
    """Return the mean of the columns, shape (3, 1): mu. Linear."""
    count = points.shape[-1]
    return points @ np.full((count, 1), 1.0 / count)


def deviations(points: Any) -> Any:
    """Return each column minus the mean of all, shape (3, N). Linear."""
    return points - mean(points) @ np.ones((1, points.shape[-1]))


def inconsistency(points: Any, total: int) -> Any:
    """Return one socket's residuals, whose squares sum to N_k tr(S_k) / total. Linear.

    Args:
        points: Predicted ball centres in the socket, shape (3, N_k) [m].
        total: Number of samples in all sockets of the placement, N0 + N1.
    """
    return deviations(points) * (1.0 / total**0.5)


def distance(points_0: Any, points_1: Any) -> Any:
    """Return |mu1 - mu0|, shape (1, 1) [m]; minus d it is the residual of the distortion."""
    offset = mean(points_1) - mean(points_0)
    return (offset.T @ offset) ** 0.5


def regularization(parameters: Any, nominal: Any, weight: float) -> Any:
    """Return residuals whose squares sum to weight * |Theta - Theta_nominal|^2. Linear."""
    return (parameters - nominal) * weight**0.5
