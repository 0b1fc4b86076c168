"""A cause as a fault of a recording session: its samples, and its rivals."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from typing import NamedTuple

import numpy as np

from ...recorder import Placement
from ..results import Hypothesis
from .hypotheses import (
    Candidate,
    Parameters,
    Scene,
    SeatSamples,
    kind_of,
    sound_recordings,
)
from .ranking import Ranking
from .robust_fit import ABOUT, FEW, RigidModel

EVIDENCE = 2.5
"""Log Bayes factor of all faults against sound samples from which the first is told."""
SHARE = 1.0
"""Share of the errors that counts as independent: with less, few samples take a fault for noise."""
RIVAL = 3.0
"""Log Bayes factor up to which a fault of another kind counts as nearly as probable."""
FORGOTTEN = kind_of(
    "socket",
    form="{samples} in socket {other}, not {socket}",
    advice="was a change of socket forgotten?",
)
DOUBT = -2.0
"""Log Bayes factor of any other cause from which samples in other sockets are considered."""
SMALL = 0.015
"""Size of a cause that is no other socket [m]."""
CLEAN = 2.0
"""Noise that such a cause may leave, as a multiple of the usual."""
STEPS = 6
"""Steps of a fit to samples in other sockets."""
TIMES = 2.0
"""Those that leave up to so many times the least error are looked at closely."""
CLOSE = 16
"""So many of them are, at most."""
LITTLE = 1e-3
"""All that leave at most this are looked at closely [m]."""
MANY = 1000
"""More sockets than a base has."""


@dataclass(frozen=True)
class Fault:
    """A fault of a session, with the samples that it concerns."""

    hypothesis: Hypothesis
    placement: int
    samples: tuple[int, ...]
    """Numbers of the samples that are affected, as they were recorded."""
    evidence: float
    """Logarithm of its probability beside that of sound samples."""
    socket: int | None = None
    """Socket in which the ball truly was, where it was in another."""
    rivals: tuple["Fault", ...] = ()
    """Other kinds of fault that are nearly as probable, the most probable first."""


def first_fault(
    ranking: Ranking,
    cause: Candidate,
) -> Fault:
    """Return a cause as a fault, with the best of each other kind that is nearly as probable."""
    factor = ranking.factor(cause)
    rivals = dict[str, Fault]()
    for rival in sorted(ranking.candidates[1:], key=ranking.factor, reverse=True):
        name, evidence = rival.kind.name, ranking.factor(rival)
        if factor - evidence < RIVAL and name not in (cause.kind.name, *rivals):
            rivals[name] = fault_of(rival, evidence)
    return replace(fault_of(cause, factor), rivals=tuple(rivals.values()))


def fault_of(
    candidate: Candidate,
    evidence: float,
) -> Fault:
    """Return a candidate as a fault, with the samples from its first one on."""
    scene, p = candidate.scene, candidate.parameters
    names = [m.name for m in scene.measurements]
    place = names.index(p.get("placement", names[-1]))
    placement = scene.measurements[place].placement
    numbers = p.get("numbers")
    if not numbers:
        first, end = _first_row(scene, place, p), len(placement.samples)
        if candidate.kind.name == "ball_sample":
            end = first + 1
        elif candidate.kind.name == "base_tipped":
            end = first + p["samples"]
        numbers = tuple(number_of(placement, row) for row in range(first, end))
    hypothesis = candidate.hypothesis()
    if "offset" in p and "size" not in p:
        # how far the ball moved by the offset of a joint, on average [m]
        joint = scene.robot.joint_names.index(p["joint"])
        slopes = scene.by_joints[scene.places[place], :, joint]
        levers = np.linalg.norm(slopes, axis=1)
        size = abs(p["offset"]) * float(levers.mean())
        sized = {**hypothesis.parameters, "size": size}
        hypothesis = replace(hypothesis, parameters=sized)
    return Fault(hypothesis, place, numbers, evidence, p.get("other"))


def _first_row(
    scene: Scene,
    place: int,
    p: Parameters,
) -> int:
    """Return the first sample that an explanation concerns, by its rank in the recording."""
    if "sample" not in p:
        return 0
    rows = scene.places[place]
    seat = scene.labels.index((p["placement"], p["socket"]))
    is_first = (scene.sockets[rows] == seat) & (scene.numbers[rows] == p["sample"])
    return int(scene.ranks[place][np.argmax(is_first)])


def number_of(
    placement: Placement,
    row: int,
) -> int:
    """Return a sample's number as it was recorded, or its place from 1 on."""
    return placement.samples[row].number or row + 1


class Run(NamedTuple):
    """Samples in a row of a placement, and the socket in which they may truly be."""

    rows: range
    socket: int


def _runs(placement: Placement) -> Iterator[Run]:
    """Yield samples at a change of socket that may be numbered wrongly."""
    sockets = [sample.socket for sample in placement.samples]
    changes = [i for i in range(1, len(sockets)) if sockets[i] != sockets[i - 1]]
    for first, end in pairwise([0, *changes, len(sockets)]):
        before = sockets[first - 1] if first else sockets[0] + 1
        after = sockets[end] if end < len(sockets) else before
        if first:
            for last in range(first + 1, end + 1):
                yield Run(range(first, last), before)
        for begin in range(end - 1, first, -1):
            yield Run(range(begin, end), after)


def _relabelled(
    placement: Placement,
    run: Run,
) -> Placement:
    """Return a placement with some samples in another socket."""
    samples = list(placement.samples)
    for i in run.rows:
        samples[i] = replace(samples[i], socket=run.socket)
    return replace(placement, samples=tuple(samples))


def of_sockets(
    model: RigidModel,
    fitted: Callable[[Sequence[Placement], np.ndarray], Scene],
    placements: Sequence[Placement],
    ranking: Ranking,
    before: Sequence[Candidate],
) -> Iterator[Candidate]:
    """Yield samples of the last placement that may be of another socket, as causes.

    None are looked for where one small fault leaves nothing more, nor beside another fault, which
    only both together would explain. ``fitted`` is a scene of placements from some unknowns on.
    """
    arm = ranking.sound.scene
    if arm.explained or ranking.total_factor <= DOUBT:
        return
    best = ranking.best
    is_small = best.parameters.get("size", math.inf) < SMALL
    leaves_nothing = best.sigma < CLEAN * arm.noise
    is_told = ranking.factor(best) > EVIDENCE
    if is_small and leaves_nothing and is_told:
        return
    *others, placement = placements
    for cause in before:
        placement = _relabelled(placement, cause.parameters["run"])
    runs = list(_runs(placement))
    for run in _promising(model, [*others, placement], arm.x, runs):
        scene = fitted([*others, _relabelled(placement, run)], arm.x)
        sound = sound_recordings(replace(scene, play=arm.play, wide=arm.wide), SHARE)
        # the parameters of samples that lie in another socket
        numbers = [number_of(placement, i) for i in run.rows]
        samples = f"samples {numbers[0]} to {numbers[-1]} lie"
        yield sound.as_cause(
            FORGOTTEN,
            {
                "placement": placement.name,
                "run": run,
                "numbers": tuple(numbers),
                "socket": placement.samples[run.rows[0]].socket,
                "other": run.socket,
                "samples": samples if len(numbers) > 1 else f"sample {numbers[0]} lies",
            },
            len(runs),
        )


def _promising(
    model: RigidModel,
    placements: Sequence[Placement],
    x: np.ndarray,
    runs: Sequence[Run],
) -> list[Run]:
    """Return the runs with which a linear fit leaves little, or near the least."""
    *before, placement = placements
    count = max(ABOUT // len(placements), FEW)
    parts = [p.samples[:: max(len(p.samples) // count, 1)] for p in before]
    start = sum(map(len, parts))
    parts.append(placement.samples)
    q = np.array([sample.position for sample in chain(*parts)])
    sockets = np.array([sample.socket for sample in chain(*parts)])
    seats = MANY * np.repeat(range(len(parts)), [*map(len, parts)]) + sockets
    last = MANY * len(before)
    no_points = np.zeros((len(q), 3))
    linear = model.linearised(x, q)
    errors: list[float] = []
    for rows, socket in runs:
        of_run = seats.copy()
        of_run[start + np.array(rows)] = last + socket
        _, indices = np.unique(of_run, return_inverse=True)
        fit = model.fit(SeatSamples(q, indices, no_points), STEPS, x, linear)
        errors.append(float(fit.errors.mean()))
    limits = [TIMES * min(errors, default=0.0), *sorted(errors)[CLOSE : CLOSE + 1]]
    largest = max(LITTLE, min(limits))
    return [run for run, error in zip(runs, errors, strict=True) if error <= largest]
