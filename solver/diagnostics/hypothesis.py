"""Codes and places of diagnostics, and explanations of recordings with their probabilities."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ..data import Measurement
from ..results import Hypothesis
from .hypotheses import Scene, probabilities

SECOND = 0.1
"""Probability from which the second explanation is told beside the first."""
LISTED = 1e-3
"""Probability below which an explanation is not listed."""
OF_JOINTS = ("sign", "swap", "zero", "model")
"""Codes of mistakes in the meaning of columns, which make the arm's size wrong, too."""
EVERYWHERE = "all placements"
"""Place of a diagnostic that concerns several placements."""


@dataclass(frozen=True)
class Finding:
    """A cause that was found, with all that its kind says of it."""

    hypothesis: Hypothesis
    code: str
    level: str


@dataclass(frozen=True)
class Option:
    """One explanation among all, and what follows where it is right."""

    name: str
    log: float
    """Logarithm of prior probability and likelihood."""
    residuals: set[str]
    """Of ``samples`` or of ``distances``, or both, that it changes."""
    finding: Callable[[float], Finding]
    """From its probability."""
    after: Callable[[], Scene]


def shares_of(options: Sequence[Option]) -> dict[str, float]:
    """Return the probability of each name."""
    shares: dict[str, float] = {}
    for option, share in zip(options, probabilities([o.log for o in options]), strict=True):
        shares[option.name] = shares.get(option.name, 0.0) + float(share)
    return shares


def listed_of(options: Sequence[Option], shares: Mapping[str, float]) -> tuple[Hypothesis, ...]:
    """Return the best explanation of each name, the most probable first."""
    best = {o.name: o for o in sorted(options, key=lambda o: o.log)}
    kept = sorted((n for n in best if shares[n] >= LISTED), key=lambda n: -shares[n])
    return tuple(best[name].finding(shares[name]).hypothesis for name in kept)


def cause(hypotheses: Sequence[Hypothesis]) -> str:
    """Return the first cause in words, and the second where it may be that; empty for none."""
    if not hypotheses or hypotheses[0].name == "sound":
        return ""
    first, *others = hypotheses
    words = f"most probable cause ({_percent(first.probability)}): {first.text}; {first.advice}"
    words += f" (docs: causes/{first.name})"
    second = next((h for h in others if h.probability > SECOND and h.name != "sound"), None)
    if second is None:
        return words
    tell = first.tell or second.tell
    return (
        f"{words}. It cannot be told from this ({_percent(second.probability)}): {second.text}; to "
        f"tell them, {tell}"
    )


def _percent(share: float) -> str:
    return f"{100 * min(share, 0.999):.3g} %"


def where_of(measurements: Sequence[Measurement]) -> str:
    """Return the name of some placements: the folder where it is one."""
    if len(measurements) > 1:
        return EVERYWHERE
    return str(measurements[0].placement.path or measurements[0].name)


def row_of(measured: Measurement, socket: int, sample: int) -> str:
    """Return file and line of a sample, by its number from 0 in its socket."""
    rows = [s for s in measured.placement.samples if s.socket == socket]
    return rows[sample].where or f"{measured.name} socket {socket} sample {sample + 1}"
