"""The answer about the data: checks, lone fits, farthest samples; and placements by soundness."""

from collections.abc import Mapping, Sequence

import numpy as np

from ....solver.assessment import (
    PlacementReport,
    SampleErrors,
    norms,
    short_names,
)
from ....solver.diagnostics import EVERYWHERE, Diagnostic, standing_out
from .texts import text
from .types import DataAnswer, LoneFit, WorstSample

FAR = 3.0
"""A sample this many times its placement's mean error from its socket deserves a look."""


def data_answer(
    placements: Sequence[PlacementReport],
    samples: Sequence[SampleErrors],
    floors: Mapping[str, float],
    checks: Sequence[Diagnostic] | None,
) -> DataAnswer:
    """Return the answer whether the recordings look sound; ``floors`` by placement's name [m]."""
    worst = worst_samples(placements, samples)
    names = short_names([row.name for row in placements])
    rows = zip(names, placements, strict=True)
    alone = {name: floors[row.name] for name, row in rows if row.name in floors}
    left = list(alone.values())
    typical = standing_out(left) if len(left) > 1 else left
    wrong = placements_with_errors(placements, checks)
    words = text(
        "answers.txt.j2",
        "data",
        checked=checks is not None,
        errors=sum(check.level == "error" for check in checks or ()),
        warnings=sum(check.level == "warning" for check in checks or ()),
        trained=[names[i] for i in wrong if placements[i].role == "train"],
        floors=left,
        odd=[name for name, usual in zip(alone, typical, strict=True) if usual is not None],
        worst=worst[0],
        far=FAR,
    )
    fits = [LoneFit(name=name, mean_absolute_error=floor) for name, floor in alone.items()]
    return DataAnswer(text=words, worst=tuple(worst[:5]), floors=tuple(fits))


def placements_with_errors(
    placements: Sequence[PlacementReport], checks: Sequence[Diagnostic] | None
) -> list[int]:
    """Return the indices of the placements in which the checks found errors."""
    wheres = [check.where for check in checks or () if check.level == "error"]
    return [
        i
        for i, row in enumerate(placements)
        if EVERYWHERE in wheres or any(f"/{row.name}/" in f"/{where}/" for where in wheres)
    ]


def farthest_held_out(
    placements: Sequence[PlacementReport], wrong: Sequence[int]
) -> tuple[int, float] | None:
    """Return the sound placement farthest from those trained on, and its distance to them [m]."""
    positions = np.array([row.position for row in placements])
    trained = np.array([row.role == "train" for row in placements])
    free = [i for i in np.flatnonzero(~trained).tolist() if i not in wrong]
    if not free or not trained.any():
        return None
    gaps = norms(positions[free][:, None] - positions[trained]).min(axis=1)
    best = int(np.argmax(gaps))
    return free[best], float(gaps[best])


def worst_samples(
    placements: Sequence[PlacementReport], samples: Sequence[SampleErrors]
) -> list[WorstSample]:
    """Return the samples by falling calibrated error."""
    rows: list[WorstSample] = []
    for sample in samples:
        placement = placements[sample.placement]
        error = sample.error()
        mean = placement.calibrated.mean_absolute_error
        rows.append(
            WorstSample(
                where=sample.where or f"{placement.name}, sample {sample.number}",
                name=placement.name,
                socket=sample.socket,
                number=sample.number,
                weight=sample.weight,
                error=error,
                ratio=error / mean if mean > 0 else 0.0,
            )
        )
    return sorted(rows, key=lambda row: -row.error)
