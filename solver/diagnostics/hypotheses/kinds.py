"""A kind of explanation: its prior and words (``causes.json``), its unknowns as linear columns."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.resources import files as resources
from math import hypot
from string import Formatter
from typing import Any

import numpy as np

from ....errors import fixed as fixed_decimals
from ....recorder import sample_name
from .scene import Scene

Parameters = Mapping[str, Any]
"""Numbers and names in an explanation, by name [m, rad]."""

Values = Callable[[Scene, Parameters, np.ndarray], Parameters]
"""Further parameters, by a candidate's own and the estimate of its unknowns."""
DECADES = 5.0
"""Logarithm of the range over which less noise is as likely."""
UNITS = {
    "mm": 1e3,
    "deg": 180 / np.pi,
    "%": 100.0,
}


@dataclass(frozen=True)
class Block:
    """Candidates that change the same rows of the residuals."""

    rows: slice
    columns: np.ndarray
    """Derivatives of these rows by the k unknowns of each of C candidates, shape (C, R, k)."""
    parameters: Sequence[Parameters]
    widths: Sequence[float] = (1.0,)
    """Standard deviations that the unknowns may have before anything is seen."""
    fixed: bool = False
    """True where the only column is a known shift of the residuals [m], not of an unknown."""
    bonus: float = 0.0
    """Log Bayes factor of evidence other than the residuals, against chance."""

    @property
    def unknowns(self) -> int:
        """Number of unknowns of a candidate."""
        return 0 if self.fixed else self.columns.shape[2]

    def only(self, candidates: Sequence[int]) -> "Block":
        """Return some of the candidates."""
        parameters = [self.parameters[i] for i in candidates]
        return replace(
            self,
            columns=self.columns[list(candidates)],
            parameters=parameters,
        )


def of_samples(
    samples: slice,
    columns: np.ndarray,
    parameters: Sequence[Parameters],
    widths: Sequence[float] = (1.0,),
    *,
    fixed: bool = False,
) -> Block:
    """Return candidates that change the residuals of n samples, by columns (C, n, 3, k)."""
    rows = slice(3 * samples.start, 3 * samples.stop)
    C, k = len(parameters), columns.shape[-1]
    return Block(
        rows,
        columns.reshape(C, -1, k),
        parameters,
        widths,
        fixed,
    )


Blocks = Callable[[Scene], Iterable[Block]]
"""Candidates that a scene may have."""


def without_columns(
    parameters: Parameters,
    bonus: float = 0.0,
) -> Block:
    """Return a candidate that changes no residuals."""
    return Block(
        slice(0, 0),
        np.zeros((1, 0, 0)),
        [parameters],
        bonus=bonus,
    )


@dataclass(frozen=True)
class NoisePrior:
    """Belief on the noise: its logarithm is Gaussian above the centre, and even below it."""

    centre: float
    """[m]."""
    width: float
    below: bool = False
    """True where less noise is as likely."""

    def log_density(self, sigma: np.ndarray) -> np.ndarray:
        """Return the logarithm of the density of ln sigma."""
        away = np.log(sigma / self.centre) / self.width
        if self.below:
            return -0.5 * np.maximum(away, 0) ** 2 - np.log(DECADES)
        volume = 0.5 * np.log(2 * np.pi * self.width**2)
        return -0.5 * away**2 - volume


Noise = Callable[[Scene], NoisePrior]
"""Belief on the noise of a scene."""


def sized(
    scene: Scene,
    parameters: Parameters,
    values: np.ndarray,
) -> Parameters:
    """Return how large a candidate's unknowns are."""
    return {"size": hypot(*values)}


def sample_named(p: Parameters) -> str:
    """Return a sample by its number as recorded, or where there is none by that in its socket.

    A point that an instrument measured has one in its recording.
    """
    if "point" in p and not p.get("number"):
        return f"point {p['point']}"
    place = p.get("place", p["sample"] + 1)
    return sample_name(p.get("number", 0), place, p["socket"])


class _Sentences(Formatter):
    """Sentences with sizes as in {size:.1f mm}, and a word by the sign as in {share:long|short}."""

    def format_field(
        self,
        value: Any,
        format_spec: str,
    ) -> str:
        if "|" in format_spec:
            return format_spec.split("|")[bool(value <= 0)]
        digits, _, unit = format_spec.partition(" ")
        if not unit:
            return format(value, digits)
        sign, decimals = digits.removesuffix("f").split(".")
        size = value if sign else abs(value)
        return f"{fixed_decimals(UNITS[unit] * size, int(decimals), sign)} {unit}"


@dataclass(frozen=True)
class Kind:
    """A kind of explanation; what it says is formatted with its parameters."""

    name: str
    prior: float
    form: str
    advice: str
    tell: str
    """Step that distinguishes it from others."""
    code: str
    blocks: Blocks
    values: Values
    """Further parameters by the estimate of the unknowns."""
    level: str = "error"
    curable: bool = False
    """True where an operator can cure it while recording."""
    rigid: bool = False
    """True where an arm with play and zeros off by degrees would look the same."""
    noise: Noise | None = None
    """Prior of the noise; None for that of sound recordings."""
    sentence: Callable[[Parameters], str] | None = None
    """Function that writes its sentence in place of :attr:`form`."""
    of_points: Mapping[str, str] = field(default_factory=dict[str, str])
    """Its words where an instrument measured the ball, in place of :attr:`form` and others."""
    separate: bool = False
    """True where several candidates may hold at once, each a cause of its own."""
    scene_after: Callable[[Scene, Parameters], Scene] | None = None
    """Function that corrects the scene; None to add its columns to the nuisance parameters."""
    turns: Callable[[np.ndarray], np.ndarray] | None = None
    """Turns of a joint for each unit of its unknown, by its readings, both of shape (N,), where
    they may be too large for linear columns."""
    fault: str = ""
    """Word of the simulated fault that it explains, where that is not its name."""
    unit: str | None = None
    """Unit in which its size is told: mm, deg or %; empty where it has none; None where no fault
    can be told by it."""
    of_size: str = ""
    """Part that it blames for an arm of another size than its model: the numbers of the ``model``,
    which the fit has as unknowns, or a ``distance`` between sockets; empty for neither."""
    at_ball: bool = False
    """True where its size is how far it moves the ball at most, not its unknowns'."""
    weighed: bool = True
    """True where a fit with it and one without it tell how much it matters. None compares typed
    distances, what the fit has as well, samples that tell nothing, or the meaning of columns."""
    of_play: bool = True
    """False where it cannot be confused with play."""

    def text(self, p: Parameters) -> str:
        """Return its sentence."""
        if self.sentence is not None:
            return self.sentence(p)
        named = dict(p)
        if "sample" in p:
            first = sample_named(p)
            since = f"from {first} on"
            if p.get("throughout"):
                since = f"throughout {p.get('placement')}, unlike elsewhere"
            nth = p.get("number") or p.get("place", p["sample"] + 1)
            named |= {"first": first, "nth": nth, "since": since}
        return _Sentences().vformat(self.form, (), named)


_WORDS = json.loads((resources(__package__ or "") / "causes.json").read_bytes())
"""Prior probabilities and words of all explanations, in the order in which they are compared."""


def nothing(_: Scene) -> Iterable[Block]:
    """Return the candidate that changes no residuals, and has no parameters."""
    return (without_columns({}),)


def kind_of(
    key: str,
    blocks: Blocks = nothing,
    values: Values = sized,
    noise: Noise | None = None,
    **more: Any,
) -> Kind:
    """Return the explanation with the words of a key."""
    words: dict[str, Any] = {
        "name": key,
        "code": key,
        **_WORDS[key],
        **more,
    }
    return Kind(
        **words,
        blocks=blocks,
        values=values,
        noise=noise,
    )
