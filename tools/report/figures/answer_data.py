"""Are my recordings all right? The answer: checks, lone fits, and the farthest samples."""

from collections.abc import Mapping, Sequence

from ....solver.assessment import PlacementReport, SampleErrors, joined, mm, plural, short_names
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
    """Return the answer whether the recordings look sound.

    Args:
        placements: All of them.
        samples: The samples that are drawn.
        floors: What each placement with sockets leaves when fitted alone, by its name, as
            ``mukca check`` says it [m].
        checks: What was found in the recordings; None where they were not checked.
    """
    worst = worst_samples(placements, samples)
    names = short_names([row.name for row in placements])
    alone = {
        name: floors[row.name]
        for name, row in zip(names, placements, strict=True)
        if row.name in floors
    }
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
    wrong = placements_with_errors(placements, checks)
    trained = [name for name, role in wrong.items() if role == "train"]
    if trained:
        text += f" All figures here rest on {joined(trained)}, trained on."
    return text


def placements_with_errors(
    placements: Sequence[PlacementReport], checks: Sequence[Diagnostic] | None
) -> dict[str, str]:
    """Return short names and roles of the placements in which the checks found errors."""
    wheres = [check.where for check in checks or () if check.level == "error"]
    places = [f"/{where}/" for where in wheres]
    names = short_names([row.name for row in placements])
    return {
        name: row.role
        for name, row in zip(names, placements, strict=True)
        if EVERYWHERE in wheres or any(f"/{row.name}/" in place for place in places)
    }


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
