"""Codes and places of diagnostics, and explanations of recordings with their probabilities."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..data import Measurement
from ..results import Hypothesis
from .hypotheses import Candidate

SECOND = 0.1
"""Probability from which the second explanation is told beside the first."""
LISTED = 1e-3
"""Probability below which an explanation is not listed."""
OF_JOINTS = ("sign", "swap", "zero", "model")
"""Codes of mistakes in the meaning of columns, which make the arm's size wrong, too."""
EVERYWHERE = "all placements"
"""Place of a diagnostic that concerns several placements."""


def shares_of(candidates: Sequence[Candidate]) -> dict[str, float]:
    """Return the probability of each name, by the logarithms of the evidence."""
    logs = np.array([c.log_evidence for c in candidates])
    odds: np.ndarray = np.exp(logs - logs.max())
    shares: dict[str, float] = {}
    for candidate, share in zip(candidates, (odds / odds.sum()).tolist(), strict=True):
        name = candidate.kind.name
        shares[name] = shares.get(name, 0.0) + share
    return shares


def listed_of(
    candidates: Sequence[Candidate], shares: Mapping[str, float]
) -> tuple[Hypothesis, ...]:
    """Return the best explanation of each name, the most probable first."""
    best = {c.kind.name: c for c in sorted(candidates, key=lambda c: c.log_evidence)}
    kept = sorted((n for n in best if shares[n] >= LISTED), key=lambda n: -shares[n])
    return tuple(best[name].hypothesis(shares[name]) for name in kept)


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
