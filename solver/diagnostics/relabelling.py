"""Samples that lie in another socket than their numbers say: a change was not told."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

from ...recorder import Placement
from .fault import number_of
from .hypotheses import Candidate, kind_of

FORGOTTEN = kind_of(
    "socket",
    form="{samples} in socket {other}, not {socket}",
    advice="was a change of socket forgotten?",
)


class Run(NamedTuple):
    """Samples in a row of a placement, and the socket in which they may truly be."""

    rows: range
    socket: int


def runs_of(placement: Placement) -> Iterator[Run]:
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


def relabelled(placement: Placement, run: Run) -> Placement:
    """Return a placement with some samples in another socket."""
    samples = list(placement.samples)
    for i in run.rows:
        samples[i] = replace(samples[i], socket=run.socket)
    return replace(placement, samples=tuple(samples))


def forgotten(
    sound: Candidate,
    placement: Placement,
    run: Run,
    log_prior: float,
) -> Candidate:
    """Return a change of socket that was not told, by the scene of relabelled samples."""
    numbers = [number_of(placement, i) for i in run.rows]
    samples = f"samples {numbers[0]} to {numbers[-1]} lie"
    parameters = {
        "placement": placement.name,
        "rows": run.rows,
        "numbers": tuple(numbers),
        "socket": placement.samples[run.rows[0]].socket,
        "other": run.socket,
        "samples": samples if len(numbers) > 1 else f"sample {numbers[0]} lies",
    }
    return sound.as_cause(FORGOTTEN, parameters, log_prior)
