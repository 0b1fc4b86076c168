"""The evidence of further unknowns of residuals that are linear in them, in closed form."""

import numpy as np


def log_bayes_factor(information: np.ndarray, pull: np.ndarray) -> np.ndarray:
    """Return ln N(r; 0, C + A A^T) - ln N(r; 0, C) = (g^T (1 + M)^-1 g - ln|1 + M|) / 2.

    Args:
        information: M = A^T C^-1 A, shape (..., k, k), for unknowns in units of their priors'
            standard deviations, by which residuals r change by A.
        pull: g = A^T C^-1 r, shape (..., k).

    Returns:
        Shape (...).
    """
    N = np.eye(pull.shape[-1]) + information
    mean = np.linalg.solve(N, pull[..., None])[..., 0]
    squares: np.ndarray = np.sum(pull * mean, axis=-1)
    return 0.5 * (squares - np.linalg.slogdet(N)[1])
