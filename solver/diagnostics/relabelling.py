"""Samples that lie in another socket than their numbers say: a change was not told."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

from ...recorder import Placement
from ..results import Hypothesis
from .fault import Fault, number_of


class Run(NamedTuple):
    """Samples in a row of a placement, and the socket in which they may truly be."""

    rows: range
    socket: int


@dataclass(frozen=True)
class Relabelling:
    """Placements with some samples in another socket, and the fault that those are."""

    placements: Sequence[Placement]
    fault: Fault


def runs_of(placement: Placement) -> Iterator[Run]:
    """Yield samples at a change of socket that may be numbered wrongly."""
    sockets = [sample.socket for sample in placement.samples]
    changes = [i for i in range(1, len(sockets)) if sockets[i] != sockets[i - 1]]
    for first, end in pairwise([0, *changes, len(sockets)]):
        before = sockets[first - 1] if first else sockets[0] + 1
        for last in range(first + 1, end + 1) if first else ():
            yield Run(range(first, last), before)
        for begin in range(end - 1, first, -1):
            yield Run(range(begin, end), sockets[end] if end < len(sockets) else before)


def relabelled(placement: Placement, run: Run) -> Placement:
    """Return a placement with some samples in another socket."""
    samples = list(placement.samples)
    for i in run.rows:
        samples[i] = replace(samples[i], socket=run.socket)
    return replace(placement, samples=tuple(samples))


def forgotten(placement: Placement, index: int, run: Run, noise: float) -> Fault:
    """Return the fault of a change of socket that was not told."""
    numbers = tuple(number_of(placement, i) for i in run.rows)
    first, last = numbers[0], numbers[-1]
    label = placement.samples[run.rows[0]].socket
    samples = f"samples {first} to {last} lie" if last != first else f"sample {first} lies"
    hypothesis = Hypothesis(
        "socket",
        1.0,
        {"placement": placement.name, "sample": run.rows[0], "socket": label, "noise": noise},
        f"{samples} in socket {run.socket}, not {label}",
        "was a change of socket forgotten?",
        "",
    )
    return Fault(hypothesis, index, numbers, 0.0, run.socket)
