"""Codes of diagnostics, and the places that they name."""

from collections.abc import Sequence

from ..data import Measurement

OF_JOINTS = ("sign", "swap", "zero", "model")
"""Codes of mistakes in the meaning of columns, which make the arm's size wrong, too."""
EVERYWHERE = "all placements"
"""Place of a diagnostic that concerns several placements."""


def where_of(measurements: Sequence[Measurement]) -> str:
    """Return the name of some placements: the folder where it is one."""
    if len(measurements) > 1:
        return EVERYWHERE
    return str(measurements[0].placement.path or measurements[0].name)


def row_of(measured: Measurement, socket: int, sample: int) -> str:
    """Return file and line of a sample, by its number from 0 in its socket."""
    rows = [s for s in measured.placement.samples if s.socket == socket]
    return rows[sample].where or f"{measured.name} socket {socket} sample {sample + 1}"
