"""True joint positions of an arm whose encoders read q."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .effects import CURVE, EFFECTS, JOINT_OFFSET, KNOTS, Effect


def design_matrix(
    effects: Sequence[Effect], q: np.ndarray, moments: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the axes that the coefficients of some effects turn, and the turns per unit."""
    m = int(q.shape[1])
    own: np.ndarray = np.arange(m)
    turned = [own[:0], *(m * axis + own for e in effects for axis in e.axes.values())]
    parts = [np.zeros((len(q), 0)), *(effect.derivatives(q, moments) for effect in effects)]
    return np.concatenate(turned), np.concatenate(parts, axis=1)


def deflected(
    q: np.ndarray, turned: np.ndarray, turns: np.ndarray, coefficients: np.ndarray
) -> np.ndarray:
    """Return the true joint positions, followed by the tilts where there are any."""
    m = q.shape[1]
    onto = np.eye(3 * m if (turned >= m).any() else m)[turned]
    true = ((turns * coefficients) @ onto).astype(np.result_type(turns, q))  # q may be symbols
    true[:, :m] += q
    return true


@dataclass(frozen=True)
class Deflection:
    """The effects of an arm beyond its geometry, as calibrated."""

    extensions: tuple[str, ...] = ()
    """Names of the effects, in the order of :data:`.EFFECTS`."""
    coefficients: tuple[np.ndarray, ...] = ()
    """Their coefficients, see :meth:`.Effect.coefficient_names`."""

    @property
    def joint_offsets(self) -> np.ndarray | None:
        """Corrections of the encoders' readings, shape (m,) [rad]; None if not looked for."""
        return dict(zip(self.extensions, self.coefficients, strict=True)).get(JOINT_OFFSET.name)

    @property
    def without_joint_offsets(self) -> "Deflection":
        """The rest, for a geometry that holds the joint offsets in its origins."""
        if JOINT_OFFSET.name not in self.extensions:
            return self
        return Deflection(self.extensions[1:], self.coefficients[1:])

    @property
    def curves(self) -> np.ndarray | None:
        """Coefficients of the joints' error curves, shape (KNOTS, m) [rad]; None without any."""
        if CURVE.name not in self.extensions:
            return None
        return self.coefficients[-1].reshape(KNOTS, -1)

    @property
    def without_curves(self) -> "Deflection":
        """The rest."""
        if CURVE.name not in self.extensions:
            return self
        return Deflection(self.extensions[:-1], self.coefficients[:-1])

    def true_positions(self, q: np.ndarray, moments: np.ndarray) -> np.ndarray:
        """Return the true joint positions q', shape (N, m), or with tilts (N, 3 m) [rad].

        Arguments are those of :func:`design_matrix`.
        """
        own = dict(zip(self.extensions, self.coefficients, strict=True))
        effects = [EFFECTS[name] for name in own if EFFECTS[name].shift is None]
        coefficients = np.concatenate([np.zeros(0), *(own[e.name] for e in effects)])
        true = deflected(q, *design_matrix(effects, q, moments), coefficients)
        for name, values in own.items():
            shift = EFFECTS[name].shift
            if shift is not None:
                true[:, : q.shape[1]] += shift(q, values)
        return true
