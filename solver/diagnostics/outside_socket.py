"""Check for segments of a recording that lie outside their socket.

Successive samples that lie in another socket have a wrong number, or are another placement's. If
they lie in none, the base moved.
"""

from ..data import Measurement
from .diagnostic import Diagnostic, row_of
from .evidence import Displacement, Evidence


def outside_socket(evidence: Evidence, measured: Measurement) -> list[Diagnostic]:
    """Return moves of a placement's base, and samples in another socket."""
    return [
        _moved(evidence, measured, one)
        if one.other is None
        else _in_other(measured, one, one.other)
        for one in evidence.displacements(measured)
    ]


def _moved(evidence: Evidence, measured: Measurement, one: Displacement) -> Diagnostic:
    change = one.change
    advice = "record it again, or keep both parts by --split-moved"
    if evidence.explained_by_backlash(change):
        advice += "; or it is play: for an arm made of servos say --zeros, by --method auto"
    return Diagnostic(
        "error",
        "moved",
        row_of(measured, change.socket, change.sample),
        f"the base moved by {1e3 * change.jump:.1f} mm before sample {change.sample + 1} of "
        f"socket {change.socket}",
        advice,
    )


def _in_other(measured: Measurement, one: Displacement, label: tuple[str, int]) -> Diagnostic:
    name, number = label
    here = name == measured.name
    return Diagnostic(
        "error",
        "mislabelled",
        row_of(measured, one.socket, one.segment.begin),
        f"samples {one.segment.begin + 1} to {one.segment.end} of socket {one.socket} lie in "
        f"socket {number}{'' if here else f' of {name}'}, {1e3 * one.change.jump:.1f} mm from the "
        "others",
        "a wrong socket number: mend it, or delete them"
        if here
        else "they were recorded with the base there: move them, or delete them",
    )
