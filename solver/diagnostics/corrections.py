"""Decisions on recordings: samples of another socket, and of a ball that was elsewhere.

All else that differs is an unknown of the fit; nothing is cut.
"""

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...recorder import Sample
from ..identification.data import Measurement
from ..results import Diagnostic
from .hypotheses import Candidate, Seat

Action = Literal["relabel", "merge", "leave out"]
ACTIONS: dict[str, Action] = {
    "socket": "relabel",
    "one_socket": "merge",
    "ball_sample": "leave out",
}
SET_RIGHT = "set_right"
"""Code of what was set right."""
AS_RECORDED = "--as-recorded does not"
"""The option that keeps it as it is."""
PLAY_HINT = "; or, if the arm has hobby servos, it is their play: add --zeros"
"""Added to the advice on what play may look like."""
LEAST = 2
"""Fewest samples of a socket that tell anything."""


@dataclass(frozen=True)
class Correction:
    """Action that sets a cause right."""

    diagnostic: Diagnostic
    action: Action
    ranks: tuple[int, ...]
    """The samples that the cause concerns, by their rank in the recording."""
    seat: Seat
    """Socket in which the ball lay, for samples to relabel."""


def correction_of(
    cause: Candidate,
    diagnostic: Diagnostic,
    measured: Measurement,
) -> Correction | None:
    """Return what sets a placement's cause right; None where nothing does."""
    name, p = cause.kind.name, cause.parameters
    if name not in ACTIONS or (
        name == "ball_sample" and diagnostic.code != "elsewhere"
    ):
        return None
    if name == "one_socket":
        socket, *others = measured.sockets
        ranks = np.flatnonzero(np.isin(measured.placement.sockets, others)).tolist()
        return Correction(diagnostic, "merge", tuple(ranks), (measured.name, socket))
    seat = (p.get("of") or measured.name, p.get("other", 0))
    return Correction(diagnostic, ACTIONS[name], _ranks(cause, measured), seat)


def _ranks(
    cause: Candidate,
    measured: Measurement,
) -> tuple[int, ...]:
    """Return the samples whose residuals a cause changes, by their rank in the recording."""
    scene = cause.scene
    rows = scene.places[[m.name for m in scene.measurements].index(measured.name)]
    changed = cause.block.columns.reshape(rows.stop - rows.start, -1).any(axis=1)
    ranks: list[int] = []
    for row in np.flatnonzero(changed) + rows.start:
        socket = scene.labels[scene.sockets[row]][1]
        seat = 0 if measured.kind == "points" else measured.sockets.index(socket)
        index = measured.slices[seat].start + scene.numbers[row]
        ranks.append(int(measured.order[index]))
    return tuple(sorted(ranks))


def corrected(
    measurements: Sequence[Measurement],
    corrections: Sequence[Sequence[Correction]],
    minimum: int,
) -> tuple[list[Measurement], list[Diagnostic]]:
    """Return placements set right, and what was done.

    Args:
        measurements: The placements.
        corrections: Those of each placement.
        minimum: Fewest samples in a socket of a placement that is kept.
    """
    if not any(corrections):
        return list(measurements), []
    names = {m.name for m in measurements}
    moving = defaultdict[str, list[Sample]](list)
    samples_of: list[list[Sample | None]] = []
    remarks: list[Diagnostic] = []
    for measured, corrections_here in zip(measurements, corrections, strict=True):
        samples: list[Sample | None] = list(measured.placement.samples)
        for correction in corrections_here:
            moving[correction.seat[0]] += _taken_out(samples, correction, measured.name)
            remarks.append(_remark(correction, measured, names))
        samples_of.append(samples)
    kept: list[Measurement] = []
    for measured, samples in zip(measurements, samples_of, strict=True):
        others = [*filter(None, samples), *moving[measured.name]]
        counts = Counter(sample.socket for sample in others)
        if max(counts.values(), default=0) < minimum:
            continue
        telling = tuple(s for s in others if counts[s.socket] >= LEAST)
        kept.append(
            replace(measured, placement=replace(measured.placement, samples=telling))
        )
    return kept, remarks


def _taken_out(
    samples: list[Sample | None],
    correction: Correction,
    name: str,
) -> list[Sample]:
    """Take samples out of a placement, and return those that lie in a socket of another."""
    true_placement, socket = correction.seat
    elsewhere: list[Sample] = []
    for rank in correction.ranks:
        sample, samples[rank] = samples[rank], None
        if sample is None or correction.action == "leave out":
            continue
        relabelled = replace(sample, socket=socket)
        if true_placement == name:
            samples[rank] = relabelled
        else:
            elsewhere.append(relabelled)
    return elsewhere


def _remark(
    correction: Correction,
    measured: Measurement,
    names: set[str],
) -> Diagnostic:
    """Return what was done, in place of the advice."""
    count = len(correction.ranks)
    samples = "the sample is" if count == 1 else f"{count} samples are"
    done = {
        "relabel": "counted for that socket"
        if correction.seat[0] in names
        else "left out",
        "merge": f"all samples count for socket {correction.seat[1]}",
        "leave out": f"{samples} left out",
    }[correction.action]
    diagnostic, name = correction.diagnostic, measured.name
    prefix = f"{name}: " * (name not in diagnostic.where)
    hint = PLAY_HINT * (PLAY_HINT in diagnostic.advice)
    advice = f"{prefix}{done}; {AS_RECORDED}{hint}"
    return replace(diagnostic, level="warning", code=SET_RIGHT, advice=advice)
