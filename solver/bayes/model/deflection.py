"""The effects of an arm beyond its geometry, all together: true joint positions from readings."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .effects import CURVE, EFFECTS, JOINT_OFFSET, KNOTS, Effect, Readings


def design_matrix(
    effects: Sequence[Effect], readings: Readings
) -> tuple[np.ndarray, np.ndarray]:
    """Return the axes that the coefficients of some effects turn, and the turns per unit."""
    m = int(readings.q.shape[1])
    columns: np.ndarray = np.arange(m)
    turned: list[np.ndarray] = [columns[:0]]
    turns: list[np.ndarray] = [np.zeros((len(readings.q), 0))]
    for effect in effects:
        turned += [m * axis + columns[effect.columns] for axis in effect.axes.values()]
        turns.append(effect.turns(readings))
    return np.concatenate(turned), np.concatenate(turns, axis=1)


def deflected(
    q: np.ndarray, turned: np.ndarray, turns: np.ndarray, coefficients: np.ndarray
) -> np.ndarray:
    """Return the true joint positions, followed by the tilts where there are any."""
    m = q.shape[1]
    onto = np.eye(3 * m if (turned >= m).any() else m)[turned]
    # q may be symbols.
    true = ((turns * coefficients) @ onto).astype(np.result_type(turns, q))
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
    def effects(self) -> tuple[Effect, ...]:
        """The effects themselves."""
        return tuple(EFFECTS[name] for name in self.extensions)

    @property
    def by_name(self) -> dict[str, np.ndarray]:
        """Coefficients of each effect."""
        return dict(zip(self.extensions, self.coefficients, strict=True))

    @property
    def joint_offsets(self) -> np.ndarray | None:
        """Corrections of the encoders' readings, shape (m,) [rad]; None if not looked for."""
        return self.by_name.get(JOINT_OFFSET.name)

    @property
    def curves(self) -> np.ndarray | None:
        """Coefficients of the joints' error curves, shape (KNOTS, m) [rad]; None without any."""
        coefficients = self.by_name.get(CURVE.name)
        return None if coefficients is None else coefficients.reshape(KNOTS, -1)

    def without(self, *names: str) -> "Deflection":
        """Return all effects but some."""
        coefficients = {
            name: c for name, c in self.by_name.items() if name not in names
        }
        return Deflection(tuple(coefficients), tuple(coefficients.values()))

    @property
    def beyond_zeros(self) -> "Deflection":
        """The effects that joint origins cannot hold."""
        return self.without(*(effect.name for effect in self.effects if effect.zeros))

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

    def true_positions(
        self, q: np.ndarray, moments: np.ndarray, clocks: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the true joint positions q', shape (N, m), or with tilts (N, 3 m) [rad].

        Arguments are those of :class:`.Readings`.
        """
        by_name = self.by_name
        effects = [effect for effect in self.effects if effect.shift is None]
        coefficients = np.concatenate(
            [np.zeros(0), *(by_name[e.name] for e in effects)]
        )
        readings = Readings(q, moments, clocks)
        true = deflected(q, *design_matrix(effects, readings), coefficients)
        for effect in self.effects:
            if effect.shift is not None:
                true[:, : q.shape[1]] += effect.shift(q, by_name[effect.name])
        return true
