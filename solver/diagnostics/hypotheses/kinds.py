"""A kind of explanation: its prior, its unknowns as columns of a linear model, and its words."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .scene import Scene

Parameters = Mapping[str, Any]
"""Numbers and names that an explanation leaves open, by name [m, rad]."""

DECADES = 5.0
"""Logarithm of the range over which less noise is as likely."""


@dataclass(frozen=True)
class Block:
    """Candidates that change the same rows of the residuals."""

    rows: slice
    columns: np.ndarray
    """Derivatives of these rows by the k unknowns of each of C candidates, shape (C, R, k)."""
    parameters: Sequence[Parameters]
    """Of each candidate."""
    widths: Sequence[float] = (1.0,)
    """Standard deviations that the unknowns may have before anything is seen."""
    shift: np.ndarray | None = None
    """Part of the residuals that a candidate explains with no unknown, shape (C, R) [m]."""
    bonus: float = 0.0
    """Logarithm of the likelihood of what the residuals do not show, beside that of chance."""
    masks: np.ndarray | None = None
    """Samples in which the columns are there, 0 or 1, shape (F, R / 3): each of the C candidates in
    each of them, those of the first mask first."""

    def only(self, candidates: Sequence[int]) -> "Block":
        """Return some of the candidates."""
        chosen = np.array(candidates)
        shift = None if self.shift is None else self.shift[chosen]
        parameters = [self.parameters[i] for i in candidates]
        columns = self.columns[chosen % len(self.columns)]
        if self.masks is not None:
            there = self.masks[chosen // len(self.columns)]
            columns = columns * np.repeat(there, 3, axis=1)[:, :, None]
        return Block(self.rows, columns, parameters, self.widths, shift, self.bonus)


@dataclass(frozen=True)
class NoisePrior:
    """Belief on the noise: its logarithm is Gaussian above the centre, and even below it."""

    centre: float
    """[m]."""
    width: float
    """Of its logarithm."""
    below: bool = True
    """True where less noise is as likely."""

    def log_density(self, sigma: np.ndarray) -> np.ndarray:
        """Return the logarithm of the density of ln sigma."""
        away = np.log(sigma / self.centre) / self.width
        if self.below:
            return -0.5 * np.maximum(away, 0) ** 2 - np.log(DECADES)
        return -0.5 * away**2 - 0.5 * np.log(2 * np.pi * self.width**2)


def no_columns(scene: Scene) -> Iterable[Block]:
    """Return the one candidate that adds nothing."""
    yield Block(slice(0, 0), np.zeros((1, 0, 0)), [{}])


def sized(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return the parameters of a candidate, and how large its unknowns are."""
    return {**parameters, "size": float(np.linalg.norm(values))}


def sample_named(p: Parameters) -> str:
    """Return a sample by its number as recorded, or where there is none by that in its socket."""
    number = p.get("number")
    return f"sample {number}" if number else f"sample {p['sample'] + 1} of socket {p['socket']}"


@dataclass(frozen=True)
class Kind:
    """A kind of explanation; what it says is formatted with its parameters."""

    name: str
    prior: float
    text: Callable[[Parameters], str]
    advice: str
    tell: str = ""
    """Step that tells it from others."""
    code: str = ""
    """Of the diagnostic; empty for its name."""
    blocks: Callable[[Scene], Iterable[Block]] = no_columns
    values: Callable[[Scene, Parameters, np.ndarray], Parameters] = sized
    """Parameters with what was found of the unknowns."""
    noise: Callable[[Scene], NoisePrior] | None = None
    """None for that of sound recordings."""
    several: bool = False
    """True where each of its candidates is told by itself."""
    level: str = "error"
    """Of the diagnostic."""
    changed: Callable[[Scene, Parameters], Scene] | None = None
    """The scene where it is right; None for one with its columns among the nuisances."""
