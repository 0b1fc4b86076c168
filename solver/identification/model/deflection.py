"""The effects of an arm beyond its geometry, all together: true joint positions from readings."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..data import Samples
from ..effects import CURVE, EFFECTS, JOINT_OFFSET, KNOTS, Effect


class DesignMatrix(NamedTuple):
    """The turns of axes by p coefficients of effects, in N samples."""

    axes: np.ndarray
    """Index of the axis that each coefficient turns, shape (p,): the m joints, then their tilts."""
    turns: np.ndarray
    """Turn of this axis per unit of the coefficient, shape (N, p) [rad]."""

    def true_positions(self, q: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        """Return the true joint positions, followed by the tilts where there are any."""
        m = q.shape[1]
        tilts = (self.axes >= m).any()
        every_axis = np.eye(3 * m if tilts else m)
        turns = (self.turns * coefficients) @ every_axis[self.axes]
        number = np.result_type(self.turns, q)  # q may be symbols
        true = turns.astype(number)
        true[:, :m] += q
        return true


def design_matrix(effects: Sequence[Effect], samples: Samples) -> DesignMatrix:
    """Return the design matrix of all coefficients of some effects."""
    N, m = map(int, samples.q.shape)
    joints: np.ndarray = np.arange(m)
    axes: list[np.ndarray] = [joints[:0]]
    turns = [np.zeros((N, 0))]
    for effect in effects:
        turned = joints[effect.columns]
        axes += [m * axis + turned for axis in effect.axes.values()]
        turns.append(effect.turns(samples))
    return DesignMatrix(
        axes=np.concatenate(axes),
        turns=np.concatenate(turns, axis=1),
    )


@dataclass(frozen=True)
class Deflection:
    """The effects of an arm beyond its geometry, as calibrated."""

    extensions: tuple[str, ...] = ()
    """Names of the effects, in the order of :data:`.EFFECTS`."""
    coefficients: tuple[np.ndarray, ...] = ()
    """Their coefficients, see :meth:`.Effect.coefficient_names`."""

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects themselves."""
        return tuple(EFFECTS[name] for name in self.extensions)

    @property
    def by_name(self) -> dict[str, np.ndarray]:
        """Coefficients of each effect."""
        pairs = zip(self.extensions, self.coefficients, strict=True)
        return dict(pairs)

    @property
    def joint_offsets(self) -> np.ndarray | None:
        """Corrections of the encoders' readings, shape (m,) [rad]; None if not looked for."""
        return self.by_name.get(JOINT_OFFSET.name)

    @property
    def curves(self) -> np.ndarray | None:
        """Coefficients of the joints' error curves, shape (KNOTS, m) [rad]; None without any."""
        coefficients = self.by_name.get(CURVE.name)
        if coefficients is None:
            return None
        return coefficients.reshape(KNOTS, -1)

    def without(self, *names: str) -> "Deflection":
        """Return all effects but some."""
        by_name = self.by_name
        for name in names:
            by_name.pop(name, None)
        return Deflection(tuple(by_name), tuple(by_name.values()))

    @property
    def beyond_zeros(self) -> "Deflection":
        """The effects that joint origins cannot hold."""
        zeros = [effect.name for effect in self.effects if effect.zeros]
        return self.without(*zeros)

    @property
    def without_curves(self) -> "Deflection":
        """All effects but the error curves."""
        return self.without(CURVE.name)

    @property
    def tilts(self) -> bool:
        """True if joints turn about axes across their own."""
        return any(effect.across for effect in self.effects)

    @property
    def plays(self) -> bool:
        """True if a joint turns steeply where its load changes sign."""
        return any(effect.joint_noise is not None for effect in self.effects)

    def true_positions(self, samples: Samples) -> np.ndarray:
        """Return the true joint positions q', shape (N, m), or with tilts (N, 3 m) [rad]."""
        true = self._by_derivatives(samples)
        q = samples.q
        m = q.shape[1]
        for effect in self.effects:
            if effect.shift is not None:
                coefficients = self.by_name[effect.name]
                true[:, :m] += effect.shift(q, coefficients)
        return true

    def _by_derivatives(self, samples: Samples) -> np.ndarray:
        """Return the true positions by effects that have no shorter way."""
        effects: list[Effect] = []
        coefficients = [np.zeros(0)]
        for effect, c in zip(self.effects, self.coefficients, strict=True):
            if effect.shift is None:
                effects.append(effect)
                coefficients.append(c)
        design = design_matrix(effects, samples)
        return design.true_positions(samples.q, np.concatenate(coefficients))
