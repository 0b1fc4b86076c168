"""Error curve: each joint errs by a smooth function of its own angle, q' = q + delta(q)."""

import math
from typing import TYPE_CHECKING, Any

from .effect import OWN, Effect, Readings

if TYPE_CHECKING:
    import numpy as np

KNOTS = 360
"""Number of knots in a turn."""
SPACING = 2 * math.pi / KNOTS


def splines(q: "np.ndarray") -> "tuple[np.ndarray, np.ndarray]":
    """Return which coefficients of a joint a curve depends on at q, and their weights, (..., 4)."""
    import numpy as np  # the command line reads the names of effects without it

    place = q / SPACING
    cell = np.floor(place)
    t = place - cell
    s = 1 - t
    weights = [s**3, 3 * t**3 - 6 * t**2 + 4, 3 * s**3 - 6 * s**2 + 4, t**3]
    first = cell.astype(np.int64)[..., None] + np.arange(-1, 3)
    return first % KNOTS, np.stack(weights, axis=-1) / 6


def curve_values(q: "np.ndarray", coefficients: "np.ndarray") -> "np.ndarray":
    """Return delta_i(q_i) of all joints, (N, m) [rad], by coefficients knot after knot."""
    import numpy as np

    m = q.shape[1]
    table = coefficients.reshape(KNOTS, m)
    # Symbols choose no entries of a table, so all splines are summed.
    if q.dtype == object:
        import casadi as ca

        places = ca.repmat(ca.vertcat(*q.ravel()) / SPACING, 1, KNOTS)
        distance: Any = places - ca.repmat(ca.DM(range(KNOTS)).T, q.size, 1)
        distance = ca.fabs(distance - KNOTS * ca.floor(distance / KNOTS + 0.5))
        outer = (2.0 - distance + ca.fabs(2.0 - distance)) / 2
        inner = (1.0 - distance + ca.fabs(1.0 - distance)) / 2
        splined = ca.DM(np.tile(table.T, (len(q), 1))) * (outer**3 - 4 * inner**3)
        return np.array((ca.sum2(splined) / 6).elements()).reshape(q.shape)
    index, weights = splines(q)
    return (table[index, [[k] for k in range(m)]] * weights).sum(axis=2)


def kernel(distance: "np.ndarray", length: float) -> "tuple[np.ndarray, np.ndarray]":
    """Return the covariance k of two angles for an amplitude of 1, and its derivative by log l.

    Their distance is 2 sin(d / 2), of any shape.
    """
    import numpy as np

    r = 5**0.5 / length * np.abs(distance)
    decay = np.exp(-r)
    return (1 + r + r**2 / 3) * decay, r**2 * (1 + r) / 3 * decay


def spectrum(length: float) -> "np.ndarray":
    """Return the eigenvalues of the prior covariance of a joint's coefficients, shape (KNOTS,).

    That covariance is circulant, for an amplitude of 1: its eigenvalues are the Fourier transform
    of its first row. A curve at its knots is the coefficients filtered by (1, 4, 1) / 6.
    """
    import numpy as np

    turn = SPACING * np.arange(KNOTS)
    values = np.fft.fft(kernel(2 * np.sin(turn / 2), length)[0]).real
    return (values / ((2 + np.cos(turn)) / 3) ** 2).clip(min=1e-9)


def circulant(eigenvalues: "np.ndarray") -> "np.ndarray":
    """Return the symmetric circulant matrix with such eigenvalues, shape (KNOTS, KNOTS)."""
    import numpy as np

    row, k = np.fft.ifft(eigenvalues).real, np.arange(KNOTS)
    return row[k - k[:, None]]


def random_curves(joints: int, generator: "np.random.Generator") -> "np.ndarray":
    """Return coefficients of curves drawn at random, of amplitude 1, shape (KNOTS joints,)."""
    import numpy as np

    white = np.fft.fft(generator.standard_normal((KNOTS, joints)), axis=0)
    drawn = np.fft.ifft(np.sqrt(spectrum(TYPICAL_LENGTH))[:, None] * white, axis=0)
    return np.array(drawn.real).ravel()


def _derivatives(readings: Readings) -> "np.ndarray":
    import numpy as np

    (n, m), (index, weights) = readings.q.shape, splines(readings.q)
    slopes = np.zeros((n, KNOTS, m))
    rows = np.arange(n, dtype=np.int64)[:, None, None]
    columns = np.arange(m, dtype=np.int64)[:, None]
    slopes[rows, index, columns] = weights
    return slopes.reshape(n, KNOTS * m)


TYPES_WITH_CURVES = ("ur5", "ur10")
"""Types of which every measured arm had such curves (a UR5, a UR10)."""
TYPICAL_LENGTH = 0.07
"""Of these [rad]; their typical amplitude is the effect's shift."""

CURVE = Effect(
    name="curve",
    extension="curves",
    unit="rad",
    axes={f"curve{k}": OWN for k in range(KNOTS)},
    derivatives=_derivatives,
    typical_shift=3e-4,
    shift=curve_values,
    random=random_curves,
)
