"""Recordings set right: a base that moved, samples of another socket, a ball that was elsewhere.

What follows a move stands apart, as a placement of its own: its sockets are as far apart as before.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Literal, get_args

import numpy as np

from ...recorder import Sample
from ..data import BALL, DRIFT, PART, Apart, Measurement
from ..results import Diagnostic
from .hypotheses import Candidate

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
SET_RIGHT, AS_RECORDED = "set_right", "--as-recorded does not"
"""Code of what was set right, and the option that keeps it as it is."""
PLAY_HINT = "; or it is play: for an arm made of servos say --zeros, by --method auto"
"""Added to the advice on what play may look like."""
LEAST = 2
"""Fewest samples of a socket that tell anything."""
Seat = tuple[str, int]
"""Placement and socket."""


@dataclass(frozen=True)
class Correction:
    """Action that sets a finding right."""

    diagnostic: Diagnostic
    action: Action
    ranks: tuple[int, ...]
    """The samples that the finding concerns, by their rank in the recording."""
    seat: Seat
    """Socket in which the ball lay, for samples to relabel."""
    of_points: bool = False
    """True where an instrument measured the samples."""
    apart: Apart | None = None
    """What has unknowns of its own in the placement from now on."""


def correction_of(
    finding: Candidate, diagnostic: Diagnostic, measured: Measurement
) -> Correction | None:
    """Return what sets a placement's finding right; None where nothing does, or it hardly counts.

    A zero of the first joint that slipped is a base that turned about its axis. Before and after
    another zero slipped, or the ball bent, the arm is not the same: the smaller part is left out,
    unless the other one lacks a socket, without which nothing says how large the arm is.
    """
    name, p = finding.kind.name, finding.parameters
    if name not in ACTIONS or (name == "ball_sample" and diagnostic.code != "elsewhere"):
        return None
    seat = p.get("of") or measured.name, p.get("other", 0)
    if name == "one_socket":
        socket, *others = measured.sockets
        samples = enumerate(measured.placement.samples)
        ranks = tuple(i for i, sample in samples if sample.socket in others)
        return Correction(diagnostic, "merge", ranks, (measured.name, socket))
    action, ranks = ACTIONS[name], _ranks(finding, measured)
    if name == "drift":
        drift = Apart(DRIFT, p["size"], tuple(p["shift"]))
        slight = diagnostic.level == "note"
        return None if slight else Correction(diagnostic, action, ranks, seat, apart=drift)
    turned = name == "zero_lost" and p["joint"] == finding.scene.robot.actuated[0].name
    if name == "ball_bent" or (name == "zero_lost" and not turned):
        if diagnostic.level == "note":
            return None
        if p.get("throughout"):
            part = BALL if name == "ball_bent" else p["joint"]
            size = p["size"] if name == "ball_bent" else p["offset"]
            return Correction(diagnostic, "set apart", ranks, seat, apart=Apart(part, size))
        action, count = "leave out", len(measured.placement.samples)
        before = range(ranks[0])
        ranks = (*before,) if len(before) < count / 2 else (*range(ranks[0], count),)
        if measured.kind == "sockets" and not _keeps_sockets(measured, ranks):
            return None
    return Correction(diagnostic, action, ranks, seat, measured.kind == "points")


def _keeps_sockets(measured: Measurement, ranks: Sequence[int]) -> bool:
    """Tell whether each socket keeps samples where those of some ranks are left out."""
    samples = measured.placement.samples
    counts = Counter(sample.socket for i, sample in enumerate(samples) if i not in set(ranks))
    return all(counts[socket] >= LEAST for socket in measured.sockets)


def _ranks(finding: Candidate, measured: Measurement) -> tuple[int, ...]:
    """Return the samples whose residuals a finding changes, by their rank in the recording."""
    scene = finding.scene
    names = [m.name for m in scene.measurements]
    rows = scene.places[names.index(measured.name)]
    columns = finding.block.columns[0]
    changed = columns.reshape(rows.stop - rows.start, -1).any(axis=1)
    ranks: list[int] = []
    of_arm: list[int] = (rows.start + np.flatnonzero(changed)).tolist()
    for row in of_arm:
        _, socket = scene.labels[int(scene.sockets[row])]
        seat = 0 if measured.kind == "points" else measured.sockets.index(socket)
        ranks_in_seat = measured.order[measured.slices[seat]]
        ranks.append(int(ranks_in_seat[int(scene.numbers[row])]))
    return tuple(sorted(ranks))


def corrected(
    measurements: Sequence[Measurement], corrections: Sequence[Sequence[Correction]], minimum: int
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
    moving: dict[str, list[Sample]] = {name: [] for name in names}
    parts: list[list[Measurement]] = []
    remarks: list[Diagnostic] = []
    for measured, corrections_here in zip(measurements, corrections, strict=True):
        samples: list[Sample | None] = list(measured.placement.samples)
        for correction in corrections_here:
            name, socket = correction.seat
            for rank in correction.ranks if correction.action in OF_SAMPLES else ():
                sample = samples[rank]
                samples[rank] = None
                relabels = correction.action in ("relabel", "merge")
                if relabels and name in names and sample is not None:
                    relabelled = replace(sample, socket=socket)
                    if name == measured.name:
                        samples[rank] = relabelled
                    else:
                        moving[name].append(relabelled)
            remarks.append(_remark(correction, measured.name, names))
        cuts = sorted(
            {correction.ranks[0] for correction in corrections_here if correction.action == "split"}
        )
        ends = zip([0, *cuts], [*cuts, len(samples)], strict=True)
        pieces = [list(filter(None, samples[a:b])) for a, b in ends]
        differences = [
            correction.apart for correction in corrections_here if correction.apart is not None
        ]
        parts.append(_parts(replace(measured, apart=(*measured.apart, *differences)), pieces))
    merged = [_with(part, moving.pop(part.name, [])) for part in chain(*parts)]
    remaining = [_told(part, minimum) for part in merged]
    return _named([part for part in remaining if part is not None]), remarks


def _parts(measured: Measurement, pieces: Sequence[Sequence[Sample]]) -> list[Measurement]:
    """Return a placement's parts, each a placement; the first has its name for now, and alarms.

    Parts after the first of an instrument's points have a frame of their own.
    """
    parts: list[Measurement] = []
    before = 0
    for number, samples in enumerate(pieces):
        name = measured.name + PART * min(number, 1)
        alarms = () if number else measured.placement.kept_alarms
        frame = measured.placement.frame
        if number and measured.kind == "points":  # the instrument stands elsewhere
            frame = f"{measured.frame} from point {before + 1} of {measured.name}"
        before += len(samples)
        part = replace(measured.placement, name=name, samples=tuple(samples))
        placement = replace(part, kept_alarms=alarms, frame=frame)
        parts.append(replace(measured, placement=placement))
    return parts


def _named(parts: Sequence[Measurement]) -> list[Measurement]:
    """Return parts with names of their own: the first of a placement has that of the placement."""
    numbers, unique = Counter[str](), list[Measurement]()
    for part in parts:
        name = part.name.partition(PART)[0]
        place = part.placement.place.partition(PART)[0]
        numbers[name] += 1
        number = f"{PART}{numbers[name]}" * (numbers[name] > 1)
        placement = replace(part.placement, name=name + number, place=place + number)
        unique.append(replace(part, placement=placement))
    return unique


def _with(measured: Measurement, samples: Sequence[Sample]) -> Measurement:
    """Return a placement with more samples, which were recorded last."""
    placement = measured.placement
    return replace(measured, placement=replace(placement, samples=(*placement.samples, *samples)))


def _told(measured: Measurement, minimum: int) -> Measurement | None:
    """Return a placement with the sockets that tell something; None where there is none."""
    placement = measured.placement
    counts = Counter(sample.socket for sample in placement.samples)
    samples = tuple(s for s in placement.samples if counts[s.socket] >= LEAST)
    enough = any(count >= minimum for count in counts.values())
    return replace(measured, placement=replace(placement, samples=samples)) if enough else None


def _remark(correction: Correction, name: str, names: set[str]) -> Diagnostic:
    """Return what was done, in place of the advice."""
    count = len(correction.ranks)
    samples = f"{count} samples {'before' if correction.ranks[0] == 0 else 'from there on'} are"
    of_frame = ", in a frame of its own" * correction.of_points
    samples = "the sample is" if count == 1 else samples
    done = {
        "split": "what follows is taken for a placement of its own" + of_frame,
        "relabel": "counted for that socket" if correction.seat[0] in names else "left out",
        "merge": f"all samples count for socket {correction.seat[1]}",
        "leave out": f"{samples} left out",
        "set apart": "fitted by itself in that placement",
        "follow": "the fit and the errors are without it",
    }[correction.action]
    prefix = f"{name}: " * (name not in correction.diagnostic.where)
    hint = PLAY_HINT if PLAY_HINT in correction.diagnostic.advice else ""
    advice = f"{prefix}{done}; {AS_RECORDED}{hint}"
    return replace(correction.diagnostic, level="warning", code=SET_RIGHT, advice=advice)
