"""Recordings set right: a base that moved, samples of another socket, a ball that was elsewhere.

What follows a move stands apart, as a placement of its own: its sockets are as far apart as before.
"""

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, get_args

import numpy as np

from ...recorder import Sample
from ..identification.data import BALL, DRIFT, PART, Apart, Measurement, whole_name
from ..results import Diagnostic
from .hypotheses import Candidate, Seat

Action = Literal["split", "relabel", "merge", "leave out", "set apart", "follow"]
ALL_ACTIONS: tuple[Action, ...] = get_args(Action)
ACTIONS: dict[str, Action] = {
    "base_moved": "split",
    "zero_lost": "split",
    "socket": "relabel",
    "one_socket": "merge",
    "ball_sample": "leave out",
    "ball_bent": "leave out",
    "drift": "follow",
}
OF_SAMPLES: tuple[Action, ...] = ("relabel", "merge", "leave out")
"""Those that change samples one by one."""
SET_RIGHT = "set_right"
"""Code of what was set right."""
AS_RECORDED = "--as-recorded does not"
"""The option that keeps it as it is."""
PLAY_HINT = "; or it is play: for an arm made of servos say --zeros, by --method auto"
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
    apart: Apart | None = None
    """What has unknowns of its own in the placement from now on."""


def correction_of(
    cause: Candidate,
    diagnostic: Diagnostic,
    measured: Measurement,
) -> Correction | None:
    """Return what sets a placement's cause right; None where nothing does, or it hardly counts.

    A zero of the first joint that slipped is a base that turned about its axis. Before and after
    another zero slipped, or the ball bent, the arm is not the same: the smaller part is left out,
    unless the other one lacks a socket, without which nothing says how large the arm is.
    """
    name, p = cause.kind.name, cause.parameters
    if name not in ACTIONS or (
        name == "ball_sample" and diagnostic.code != "elsewhere"
    ):
        return None
    if name == "one_socket":
        socket, *others = measured.sockets
        ranks = tuple(
            np.flatnonzero(np.isin(measured.placement.sockets, others)).tolist()
        )
        return Correction(diagnostic, "merge", ranks, (measured.name, socket))
    seat = (p.get("of") or measured.name, p.get("other", 0))
    correction = Correction(diagnostic, ACTIONS[name], _ranks(cause, measured), seat)
    turned_base = (
        name == "zero_lost" and p["joint"] == cause.scene.robot.actuated[0].name
    )
    if name not in ("drift", "ball_bent", "zero_lost") or turned_base:
        return correction
    if diagnostic.level == "note":
        return None
    if name == "drift":
        return replace(correction, apart=Apart(DRIFT, p["size"], tuple(p["shift"])))
    if p.get("throughout"):
        apart = (
            Apart(BALL, p["size"])
            if name == "ball_bent"
            else Apart(p["joint"], -p["offset"])
        )
        return replace(correction, action="set apart", apart=apart)
    first, count = correction.ranks[0], len(measured.placement.samples)
    smaller = range(first) if first < count / 2 else range(first, count)
    if measured.kind == "sockets" and not _keeps_sockets(measured, smaller):
        return None
    return replace(correction, action="leave out", ranks=tuple(smaller))


def _keeps_sockets(measured: Measurement, ranks: Sequence[int]) -> bool:
    """Tell whether each socket keeps samples where those of some ranks are left out."""
    counts = Counter(np.delete(measured.placement.sockets, ranks).tolist())
    return all(counts[socket] >= LEAST for socket in measured.sockets)


def _ranks(cause: Candidate, measured: Measurement) -> tuple[int, ...]:
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
        minimum: Fewest samples in a socket of a part that is kept.
    """
    if not any(corrections):
        return list(measurements), []
    names = {m.name for m in measurements}
    moving = defaultdict[str, list[Sample]](list)
    parts: list[Measurement] = []
    remarks: list[Diagnostic] = []
    for measured, corrections_here in zip(measurements, corrections, strict=True):
        samples: list[Sample | None] = list(measured.placement.samples)
        cuts, differences = set[int](), list(measured.apart)
        for correction in corrections_here:
            if correction.action in OF_SAMPLES:
                moved = _taken_out(samples, correction, measured.name)
                moving[correction.seat[0]] += moved
            if correction.action == "split":
                cuts.add(correction.ranks[0])
            if correction.apart is not None:
                differences.append(correction.apart)
            remarks.append(_remark(correction, measured, names))
        ends = pairwise([0, *sorted(cuts), len(samples)])
        pieces = [[*filter(None, samples[a:b])] for a, b in ends]
        parts += _parts(replace(measured, apart=tuple(differences)), pieces)
    kept = [_kept(part, moving.pop(part.name, ()), minimum) for part in parts]
    return _named([part for part in kept if part is not None]), remarks


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


def _parts(
    measured: Measurement,
    pieces: Sequence[Sequence[Sample]],
) -> Iterator[Measurement]:
    """Yield a placement's parts, each a placement; the first has its name for now, and alarms.

    Parts after the first of an instrument's points have a frame of their own.
    """
    before = 0
    for number, samples in enumerate(pieces):
        placement = replace(measured.placement, samples=tuple(samples))
        if number:
            placement = replace(placement, name=measured.name + PART, kept_alarms=())
        if number and measured.kind == "points":  # the instrument stands elsewhere
            frame = f"{measured.frame} from point {before + 1} of {measured.name}"
            placement = replace(placement, frame=frame)
        before += len(samples)
        yield replace(measured, placement=placement)


def _kept(
    part: Measurement,
    more: Sequence[Sample],
    minimum: int,
) -> Measurement | None:
    """Return a part with more samples, recorded last, and the sockets that tell something.

    None where no socket does.
    """
    samples = (*part.placement.samples, *more)
    counts = Counter(sample.socket for sample in samples)
    if max(counts.values(), default=0) < minimum:
        return None
    telling = tuple(sample for sample in samples if counts[sample.socket] >= LEAST)
    return replace(part, placement=replace(part.placement, samples=telling))


def _named(parts: Sequence[Measurement]) -> list[Measurement]:
    """Return parts with names of their own: the first of a placement has that of the placement."""
    numbers, unique = Counter[str](), list[Measurement]()
    for part in parts:
        name, place = whole_name(part.name), whole_name(part.placement.place)
        numbers[name] += 1
        number = f"{PART}{numbers[name]}" * (numbers[name] > 1)
        placement = replace(part.placement, name=name + number, place=place + number)
        unique.append(replace(part, placement=placement))
    return unique


def _remark(
    correction: Correction,
    measured: Measurement,
    names: set[str],
) -> Diagnostic:
    """Return what was done, in place of the advice."""
    count = len(correction.ranks)
    samples = f"{count} samples {'before' if correction.ranks[0] == 0 else 'from there on'} are"
    of_frame = ", in a frame of its own" * (measured.kind == "points")
    samples = "the sample is" if count == 1 else samples
    done = {
        "split": "what follows is taken for a placement of its own" + of_frame,
        "relabel": "counted for that socket"
        if correction.seat[0] in names
        else "left out",
        "merge": f"all samples count for socket {correction.seat[1]}",
        "leave out": f"{samples} left out",
        "set apart": "fitted by itself in that placement",
        "follow": "the fit and the errors are without it",
    }[correction.action]
    diagnostic, name = correction.diagnostic, measured.name
    prefix = f"{name}: " * (name not in diagnostic.where)
    hint = PLAY_HINT * (PLAY_HINT in diagnostic.advice)
    advice = f"{prefix}{done}; {AS_RECORDED}{hint}"
    return replace(diagnostic, level="warning", code=SET_RIGHT, advice=advice)
