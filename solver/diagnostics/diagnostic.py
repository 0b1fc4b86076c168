"""A diagnostic: one thing that was seen in recordings, in words."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ..data import Measurement

OF_JOINTS = ("sign", "swap", "zero", "model")
"""Codes of mistakes in the meaning of columns, which make the arm's size wrong, too."""
EVERYWHERE = "all placements"
"""Place of a diagnostic that concerns several placements."""


@dataclass(frozen=True)
class Diagnostic:
    """One thing that was seen."""

    level: str
    """``error``: do not train on it as it is; ``warning``: look at it."""
    code: str
    where: str
    text: str
    advice: str

    def as_dict(self) -> dict[str, Any]:
        """Return it by name."""
        return asdict(self)

    def __str__(self) -> str:
        return f"{self.where}: {self.text}; {self.advice}"


def where_of(measurements: Sequence[Measurement]) -> str:
    """Return the name of some placements: the folder where it is one."""
    if len(measurements) > 1:
        return EVERYWHERE
    return str(measurements[0].placement.path or measurements[0].name)


def row_of(measured: Measurement, socket: int, sample: int) -> str:
    """Return file and line of a sample, by its number from 0 in its socket."""
    rows = [s for s in measured.placement.samples if s.socket == socket]
    return rows[sample].where or f"{measured.name} socket {socket} sample {sample + 1}"
