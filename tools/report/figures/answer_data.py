"""The answer about the data: checks, lone fits, farthest samples; and placements by soundness."""

from collections.abc import Mapping, Sequence

import numpy as np

from ....solver.assessment import (
    PlacementReport,
    SampleErrors,
    joined,
    mm,
    norms,
    plural,
    short_names,
)
from ....solver.diagnostics import EVERYWHERE, Diagnostic, standing_out
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
    texts = [_checks_text(placements, checks)]
    if alone:
        words = _floors_text(list(alone), list(alone.values()))
        texts.append(words if texts[0].endswith(":") else words[0].upper() + words[1:])
    if any(row.ratio > FAR for row in worst):
        first = worst[0]
        texts.append(
            f"Look at {first.where}: it is {mm(first.error)} from its socket, "
            f"{first.ratio:.1f} times its placement's mean error."
        )
    return DataAnswer(
        text=" ".join(texts),
        worst=tuple(worst[:5]),
        floors=tuple(
            LoneFit(name=name, mean_absolute_error=floor) for name, floor in alone.items()
        ),
    )


def _checks_text(placements: Sequence[PlacementReport], checks: Sequence[Diagnostic] | None) -> str:
    if checks is None:
        return (
            "Not known: the recordings were not checked one by one, which mukca check does. What "
            "the fits show:"
        )
    errors = sum(check.level == "error" for check in checks)
    warnings = sum(check.level == "warning" for check in checks)
    if not errors and not warnings:
        return "Yes: the checks of the recordings found nothing wrong."
    if not errors:
        return f"Yes, but look at {plural(warnings, 'warning')} below."
    text = f"No: {plural(errors, 'error')} below; mend or record anew, then calibrate again."
    names = short_names([row.name for row in placements])
    wrong = placements_with_errors(placements, checks)
    trained = [names[i] for i in wrong if placements[i].role == "train"]
    if trained:
        text += f" All figures here rest on {joined(trained)}, trained on."
    return text


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


def _floors_text(names: Sequence[str], floors: Sequence[float]) -> str:
    if len(floors) == 1:
        return f"fitted alone it leaves {mm(floors[0], 3)}."
    text = f"fitted alone, the placements leave {mm(min(floors), 3)} to {mm(max(floors), 3)}"
    odd = [n for n, typical in zip(names, standing_out(floors), strict=True) if typical is not None]
    if odd:
        return f"{text}: {joined(odd)} stands out, so record it anew."
    return f"{text}: none stands out."


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
