"""Samples far off that hide each other: causes of their own, weighed together.

One sample at a time explains nothing while others are off, too, so noise, or no single cause, looks
more probable. A robust fit shows all of them at once. With the marginal likelihood Z of the scene
whose outliers i are free, and the prior p of a sample that is off among N, their evidence is::

    ln E = ln Z + k ln(p / N)
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .hypotheses import (
    KINDS,
    Candidate,
    Scene,
    nearest_sockets,
    sound_recordings,
)
from .ranking import Ranking

OUTLIER = next(kind for kind in KINDS if kind.name == "ball_sample")
HIDDEN = "hidden"
"""Parameter of samples that hide each other, which no robust fit needs: they are left out."""
FAR = 20.0
"""Multiple of the typical error from which a sample is looked at."""
LEAST = 3e-3
"""Error below which it is not [m]."""
MOST = 0.25
"""Share of the samples beyond which they are no outliers."""


def outliers(scene: Scene, ranking: Ranking) -> list[Candidate]:
    """Return samples that are off, if several together are more probable than all single causes.

    Args:
        scene: The recordings about a robust fit.
        ranking: All causes by themselves.
    """
    errors = _errors(scene)
    rows = _standing_out(scene, errors)
    if not 2 <= len(rows) <= MOST * len(scene.q):
        return []
    causes = [_cause(ranking.sound, row, errors[row]) for row in rows]
    sound = sound_recordings(_without(causes))
    log_prior = len(rows) * math.log(OUTLIER.prior / len(scene.q))
    together = replace(sound, log_evidence=sound.log_evidence + log_prior)
    if ranking.factor(together) < max(ranking.total_factor, 0.0):
        return []
    told: list[Candidate] = []
    for cause in causes:
        # its size follows beside all others
        others = [other for other in causes if other is not cause]
        evidence = sound_recordings(_without(others)).evidence
        told.append(
            replace(
                cause,
                evidence=evidence,
                sigma=sound.sigma,
                log_evidence=together.log_evidence,
            )
        )
    return told


def _without(causes: Sequence[Candidate]) -> Scene:
    """Return the scene in which some causes are right."""
    first, *others = causes
    scene = first.after()
    explained = [cause.after().explained[-1] for cause in others]
    return replace(scene, explained=(*scene.explained, *explained))


def _errors(scene: Scene) -> np.ndarray:
    """Return the distance of each sample from the place of its seat, shape (N,) [m]."""
    arms = scene.seats - scene.centres[scene.sockets]
    return np.linalg.norm(arms, axis=1)


def _standing_out(scene: Scene, errors: np.ndarray) -> list[int]:
    """Return the samples that are far from the place of their seat, the farthest first.

    Those that lie in another socket have a cause of their own.
    """
    _, elsewhere = nearest_sockets(scene)
    limit = max(LEAST, FAR * float(np.median(errors)))
    farthest = np.argsort(-errors)
    is_off = (errors > limit) & ~elsewhere
    return farthest[is_off[farthest]].tolist()


def _cause(sound: Candidate, row: int, error: float) -> Candidate:
    """Return the cause that a sample is off, typically by its error [m], among sound recordings."""
    scene = sound.scene
    place = next(i for i, rows in enumerate(scene.places) if row < rows.stop)
    block = list(OUTLIER.blocks(scene))[place]
    only = block.only([row - scene.places[place].start])
    parameters = [{**only.parameters[0], HIDDEN: True}]
    of_size = replace(only, parameters=parameters, widths=(float(error),))
    return replace(sound, kind=OUTLIER, block=of_size)
