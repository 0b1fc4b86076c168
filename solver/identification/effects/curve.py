"""Error curve: each joint errs by a smooth function of its own angle, q' = q + delta(q)."""

import math
from typing import TYPE_CHECKING, Any

from ..data import Samples
from .effect import OWN, Effect

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
    second = 3 * t**3 - 6 * t**2 + 4
    third = 3 * s**3 - 6 * s**2 + 4
    weights = np.stack([s**3, second, third, t**3], axis=-1) / 6
    knots = cell.astype(np.int64)[..., None] + np.arange(-1, 3)
    return knots % KNOTS, weights


def curve_values(q: "np.ndarray", coefficients: "np.ndarray") -> "np.ndarray":
    """Return delta_i(q_i) of all joints, (N, m) [rad], by coefficients knot after knot."""
    import numpy as np

    table = coefficients.reshape(KNOTS, -1)
    if q.dtype == object:
        return _values_of_symbols(q, table)
    knots, weights = splines(q)
    joints = np.arange(len(table[0]))[:, None]
    return (table[knots, joints] * weights).sum(axis=2)


def _values_of_symbols(q: "np.ndarray", table: "np.ndarray") -> "np.ndarray":
    """Return the same by all splines: symbols choose no entries of a table."""
    import casadi as ca
    import numpy as np

    places = ca.repmat(ca.vertcat(*q.ravel()) / SPACING, 1, KNOTS)
    knots = ca.repmat(ca.DM(range(KNOTS)).T, q.size, 1)
    distance: Any = places - knots
    distance = ca.fabs(distance - KNOTS * ca.floor(distance / KNOTS + 0.5))
    outer = (2.0 - distance + ca.fabs(2.0 - distance)) / 2
    inner = (1.0 - distance + ca.fabs(1.0 - distance)) / 2
    by_knot = ca.DM(np.tile(table.T, (len(q), 1)))
    splined = by_knot * (outer**3 - 4 * inner**3)
    return np.array((ca.sum2(splined) / 6).elements()).reshape(q.shape)


def kernel(distance: "np.ndarray", length: float) -> "tuple[np.ndarray, np.ndarray]":
    """Return the covariance k of two angles for an amplitude of 1, and its derivative by log l.

    Their distance is 2 sin(d / 2), of any shape.
    """
    import numpy as np

    r = 5**0.5 / length * np.abs(distance)
    decay = np.exp(-r)
    k = (1 + r + r**2 / 3) * decay
    by_log_length = r**2 * (1 + r) / 3 * decay
    return k, by_log_length


def spectrum(length: float) -> "np.ndarray":
    """Return the eigenvalues of the prior covariance of a joint's coefficients, shape (KNOTS,).

    That covariance is circulant, for an amplitude of 1: its eigenvalues are the Fourier transform
    of its first row. A curve at its knots is the coefficients filtered by (1, 4, 1) / 6.
    """
    import numpy as np

    turn = SPACING * np.arange(KNOTS)
    first_row, _ = kernel(2 * np.sin(turn / 2), length)
    values = np.fft.fft(first_row).real
    filtered = (2 + np.cos(turn)) / 3
    return (values / filtered**2).clip(min=1e-9)


def circulant(eigenvalues: "np.ndarray") -> "np.ndarray":
    """Return the symmetric circulant matrix with such eigenvalues, shape (KNOTS, KNOTS)."""
    import numpy as np

    first_row = np.fft.ifft(eigenvalues).real
    k = np.arange(KNOTS)
    return first_row[k - k[:, None]]


def random_curves(joints: int, generator: "np.random.Generator") -> "np.ndarray":
    """Return coefficients of curves drawn at random, of amplitude 1, shape (KNOTS joints,)."""
    import numpy as np

    numbers = generator.standard_normal((KNOTS, joints))
    white = np.fft.fft(numbers, axis=0)
    amplitudes = np.sqrt(spectrum(TYPICAL_LENGTH))
    drawn = np.fft.ifft(amplitudes[:, None] * white, axis=0)
    return np.array(drawn.real).ravel()


def _derivatives(samples: Samples) -> "np.ndarray":
    import numpy as np

    N, m = samples.q.shape
    knots, weights = splines(samples.q)
    slopes = np.zeros((N, KNOTS, m))
    rows = np.arange(N, dtype=np.int64)[:, None, None]
    joints = np.arange(m, dtype=np.int64)[:, None]
    slopes[rows, knots, joints] = weights
    return slopes.reshape(N, KNOTS * m)


TYPICAL_LENGTH = 0.07
"""Of arms under laser trackers [rad]; their typical amplitude is the effect's shift."""

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
