"""Steps to do where the verdict is not PASS, the most useful first, each with a command."""

import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import cast

import numpy as np

from ....recorder import DEFAULT_DISTANCE
from ....solver.assessment import (
    Assessment,
    PlacementReport,
    area,
    joined,
    joints_wrong,
    mm,
    most_readings,
    short_mm,
)
from ....solver.diagnostics import farthest_place
from ....solver.identification.data import (
    AGREEING,
    CALIPER_DEVIATION,
    SAMPLES_ADVISED,
    as_point,
    readings_of,
)
from ....solver.results import CalibrationDocument, Role
from .answers import farthest_held_out
from .command_lines import record_command, solve_command
from .mending import (
    UnusedPlacement,
    mending_steps,
    steps_where_something_moved,
    unused_placements,
)
from .types import Step

DOUBTED_SIZE = 3e-3
"""Share from which an arm that came out longer or shorter asks for another reading of its base:
that of eight real arms in ten is smaller."""
EXPLAINED = 0.5
"""Share of the difference of two distances from which an error of distances is explained by it."""
_SPAN = 0.5
"""A distance in the workspace [m]."""
BESIDE = 0.2
"""A place is no new one if it is nearer to a placement than this [m]."""


def steps(result: Assessment) -> list[Step]:
    """Return the next step for a calibration; of a PASS, at most another reading of its base.

    A step that is expected to make the error larger is none.
    """
    for step in _steps(result):
        if step.before is None or step.after is None or step.after < step.before:
            return [step]
    return []


def _steps(result: Assessment) -> Iterator[Step]:
    """Yield steps, the most useful first."""
    verdict = result.verdict
    placements = result.placements
    document = result.predictions.document
    status = verdict.status_of
    passes = verdict.status == "pass"
    if not passes:
        yield from _measure_one_base(result)
    if status("data_checks") not in ("pass", "warning") and not passes:
        yield from mending_steps(result)
        return
    if status("drift") == "not enough" and not passes:
        yield from steps_where_something_moved(result)
    size = {status("scale"), status("distance_given")}
    if not size <= {"pass", "warning"} or _is_to_be_read_again(result):
        yield from _measure(document, placements)
    if passes:
        return
    if not verdict.use:
        yield from steps_where_something_moved(result)
    unused = unused_placements(result)
    rows = (*verdict.limits, *verdict.reasons)
    # Something that was not trained on has an error.
    is_proved = any(
        r.name == "mean_absolute_error" and r.found is not None for r in rows
    )
    missed = any(row.status in ("fail", "not enough") for row in rows)
    is_lacking = is_proved and (missed or not verdict.use)
    if not is_proved:
        yield from _leave_each_out(document, unused)
    if is_lacking:
        yield from _train_on_held_out(result)
    yield from _corrected_joints(result)
    if is_lacking and unused:
        yield _train_on_unused(document, unused[0])
    by_instrument = all(row.kind == "points" for row in placements)
    is_usable = by_instrument or (is_proved and bool(verdict.use))
    if result.limits.repeatability is None and is_usable:
        yield _repeatability(document)
    if by_instrument:
        text = "Measure more points, in poses as varied as can be"
        command = solve_command(document, added={"more_points": "train"})
        yield Step(text, command, "a smaller error, as far as postures differ")
        return
    text = f"Record another placement {_place_in_words(result)}, all varied, {SAMPLES_ADVISED}"
    if document.arms:
        text += ", with each of the arms, into folders of one name"
    text += ", and train on it too"
    if not is_proved:
        text += ": each place is then left out once, which proves the fit"
    yield _forecast(document, None, text, record_command(document))


def _is_to_be_read_again(result: Assessment) -> bool:
    """Tell whether the arm came out so long or short that its base is read a second time."""
    document = result.predictions.document
    if not document.scale or result.verdict.status_of("scale") == "warning":
        return False  # the URDF explains it
    is_doubted = abs(document.scale.value) >= DOUBTED_SIZE
    return is_doubted and most_readings(document.placements) == 1


def _train_on_held_out(result: Assessment) -> Iterator[Step]:
    """Yield the step to train on one of several held-out placements too, where any is sound."""
    document = result.predictions.document
    several = sum(row.role == "test" for row in result.placements) > 1
    farthest = farthest_held_out(result) if several else None
    if not farthest:
        return
    index, gap = farthest
    name = result.placements[index].name
    short = result.predictions.names[index]
    text = f"Train on {short} too: recorded already, {gap:.2f} m from the nearest trained on"
    command = solve_command(document, moves={name: "train"})
    yield _forecast(document, name, text, command)


def _train_on_unused(document: CalibrationDocument, unused: UnusedPlacement) -> Step:
    """Return the step to train on a placement that the calibration did not use."""
    text = f"Train on {unused.name} too: it lies beside the others, {unused.gap:.2f} m from the "
    text += "nearest trained on"
    command = solve_command(document, added={unused.folder: "train"})
    return Step(text, command, "a smaller error, since more places are known")


def _leave_each_out(
    document: CalibrationDocument, unused: Sequence[UnusedPlacement]
) -> Iterator[Step]:
    """Yield the steps that prove a fit by what is recorded already, where nothing was left out."""
    words = "each place is left out once, which proves the fit: errors, and a verdict"
    if document.settings.get("no_proof"):
        command = solve_command(document, settings_given={"no_proof": False})
        yield Step("Leave each place out once: drop --no-proof", command, words)
    elif unused:
        names = joined([placement.name for placement in unused])
        text = f"Train on {names} too, recorded already beside the others"
        added: dict[str, Role] = {placement.folder: "train" for placement in unused}
        yield Step(text, solve_command(document, added=added), words)


def _place_in_words(result: Assessment) -> str:
    """Return where another placement serves best: as far from all others as can be.

    Several arms look at one place from two sides, so no side is named.
    """
    places = np.array([row.position for row in result.placements])
    place = farthest_place(places)
    gap = float(np.linalg.norm(places - place, axis=1).min())
    if gap < BESIDE:
        return "higher or lower than the others, which lie all round"
    if result.predictions.document.arms:
        return "far from the others"
    return f"about {area(as_point(place))}, {gap:.2f} m from the others"


def _corrected_joints(result: Assessment) -> Iterator[Step]:
    """Yield the step to correct joint positions, where the full model keeps all limits."""
    verdict = result.verdict
    missed = [row for row in verdict.limits if row.status in ("fail", "not enough")]
    if not (verdict.use and missed) or any(r.full_status != "pass" for r in missed):
        return
    first, *_ = missed
    before = cast("float", first.found)
    after = cast("float", first.full)
    text = "Command corrected joints (poses.csv: x,y,z,qx,qy,qz,qw); no URDF alone keeps this limit"
    words = f"{first.title}: {mm(after, 3)} in place of {mm(before, 3)}"
    file = result.predictions.document.outputs.get(
        "calibration", "DIR/calibration.json"
    )
    folder = shlex.quote(str(Path(file).parent))
    command = f"mukca command {folder} poses.csv --out joints.csv"
    yield Step(text, command, words, before, after)


def _repeatability(document: CalibrationDocument) -> Step:
    """Return the step that says how well the arm repeats, without which there are no limits."""
    text = "Say how well the arm repeats, from its data sheet"
    command = solve_command(document, settings_given={"repeatability_mm": "MM"})
    return Step(text, command, "a limit to hold the errors against; they do not change")


def _measure(
    document: CalibrationDocument, placements: Sequence[PlacementReport]
) -> Iterator[Step]:
    """Yield the step to measure the sockets' distance, unless joints come before it."""
    scale = document.scale
    if not any(row.distance for row in placements) or joints_wrong(document.checks):
        return
    readings = readings_of(document.settings.get("distance")) or _recorded_once(
        placements
    )
    times = " a second time" * bool(readings)
    text = (
        f"Measure the sockets' distance{times}, and type it for MEASURED, as in 50.1mm"
    )
    given = [*readings, "MEASURED"]
    command = solve_command(document, settings_given={"distance": given})
    if scale is None:
        yield Step(text, command, "an arm of the right size")
        return
    deviation = scale.deviation or CALIPER_DEVIATION / DEFAULT_DISTANCE
    before = abs(scale.value) * _SPAN
    after = deviation * _SPAN
    words = f"a length of {_SPAN:g} m in the arm is then known to {mm(after)}"
    if before <= after:
        yield Step(text, command, words)
        return
    yield Step(text, command, f"{words} instead of {mm(before)}", before, after)


def _measure_one_base(result: Assessment) -> Iterator[Step]:
    """Yield the step to measure a base where its placements differ as errors of distances do."""
    document = result.predictions.document
    pairs = zip(result.predictions.names, result.placements, strict=True)
    stated = [(row.distance, name) for name, row in pairs if row.distance]
    shortest, longest = min(stated, default=(0.0, "")), max(stated, default=(0.0, ""))
    difference = longest[0] - shortest[0]
    errors = [abs(row.calibrated.distance_error or 0.0) for row in result.placements]
    if difference <= AGREEING or max(errors) < EXPLAINED * difference:
        return
    words = " and ".join(
        f"{name} says {mm(length, 1)}" for length, name in (longest, shortest)
    )
    text = f"Measure the sockets' distance, for all placements of one base: {words}"
    folders = dict.fromkeys(row.folder for row in document.data)
    command = shlex.join(["mukca", "info", *folders, "--set-distance", "MEASURED"])
    yield Step(text, command, "the same command again, without that error")


def _recorded_once(placements: Sequence[PlacementReport]) -> tuple[float, ...]:
    """Return the distance that placement.json has, if it is one of all placements [m]."""
    rows = [row for row in placements if row.distance_source == "recording"]
    distances = {row.distance for row in rows if row.distance is not None}
    return tuple(distances) * (len(distances) == 1)


def _forecast(
    document: CalibrationDocument, name: str | None, text: str, command: str
) -> Step:
    """Return a step with what the posterior forecasts of it, where it does."""
    rows = document.outlook.forecasts if document.outlook else ()
    forecasts = {row.placement: row.share for row in rows if row.share is not None}
    if document.better is None or name not in forecasts:
        why = "only --method auto makes one"
        if document.method == "auto":
            why = "none of the places that were tried for it is within the arm's reach"
        return Step(text, command, f"no forecast: {why}")
    before = document.better.workspace.now.value
    after = before * forecasts[name]
    # several arms have a workspace each
    owner = f"{document.arm_name}'s own" if document.arm_name else "the"
    words = (
        f"a distance in {owner} workspace is wrong by about {short_mm(after)} mm in place of "
        f"{short_mm(before)}"
    )
    return Step(text, command, words, before, after)
