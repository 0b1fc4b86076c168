"""What to do where the verdict is not PASS: steps, the most useful first, each with a command."""

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np

from ...documents.calibration import CalibrationDocument, Role
from ...documents.report_errors import PlacementReport
from ...documents.report_verdict import Step, Verdict
from ..words import short_names
from .predictions import norms
from .size import likely_distance

__all__ = ["solve_command", "steps"]


def steps(
    document: CalibrationDocument, placements: Sequence[PlacementReport], verdict: Verdict
) -> tuple[Step, ...]:
    """Return what to do next, best first; nothing where the verdict is PASS.

    Args:
        document: The calibration.
        placements: All of them.
        verdict: On the calibration.
    """
    if verdict.status == "pass":
        return ()
    status = {row.name: row.status for row in verdict.limits}
    found: list[Step] = []
    if status["data_checks"] != "pass":
        text = "See what is wrong in the recordings; record anew, or leave out, what it names"
        words = ["mukca", "check", *_folders(document), "--robot", document.robot]
        found.append(Step(text=text, command=shlex.join(words)))
    if document.scale is not None and status.get("scale") == "fail":
        likely = f"{likely_distance(document.scale, placements):.5f}"
        text = "Measure the sockets' distance, and give it; this one would fit the arm"
        found.append(Step(text=text, command=solve_command(document, given={"distance": likely})))
    if "fail" in status.values() or "not enough" in status.values():
        found += _train_more(document, placements)
    if any(row.status == "not evaluated" and row.found is not None for row in verdict.limits[:2]):
        text = "Say how well the arm repeats, from its data sheet"
        again = solve_command(document, given={"repeatability_mm": "MM"})
        found.append(Step(text=text, command=again))
    words = ["mukca", "record", "--robot", document.robot, "--driver", "NAME:ADDRESS"]
    held_out = any(row.role == "test" for row in placements)
    text = "Record another placement far from the others, 30 samples in each socket, all varied"
    if not held_out:
        text += ", and hold it out by --test"
    found.append(Step(text=text, command=shlex.join([*words, "--out", "recordings/another"])))
    return tuple(found)


def _train_more(document: CalibrationDocument, placements: Sequence[PlacementReport]) -> list[Step]:
    """Return the step to train on what is held out and farthest, where another stays held out."""
    positions = np.array([row.position for row in placements])
    trained = np.array([row.role == "train" for row in placements])
    if np.sum(~trained) < 2 or not trained.any():
        return []
    gaps = norms(positions[:, None] - positions[trained]).min(axis=1)
    best = int(np.argmax(np.where(trained, -1.0, gaps)))
    name = short_names([row.name for row in placements])[best]
    text = (
        f"Train on {name} too: recorded already, {gaps[best]:.2f} m from the nearest trained on; "
        "a second placement is what lowers the errors most"
    )
    return [Step(text=text, command=solve_command(document, also=placements[best].name))]


def _folders(document: CalibrationDocument, role: Role | None = None) -> list[str]:
    return [
        str(Path(row.files[0]).parent) if row.files else "?"
        for row in document.data
        if role in (None, row.role)
    ]


def solve_command(
    document: CalibrationDocument, *, also: str | None = None, given: dict[str, str] | None = None
) -> str:
    """Return the command that makes the calibration again, or a better one.

    Args:
        document: The calibration.
        also: A placement held out that is to be trained on as well.
        given: Settings that replace those of the calibration.
    """
    folders = {role: _folders(document, role) for role in ("train", "test")}
    for row, folder in zip(document.data, _folders(document), strict=True):
        if row.name == also:
            folders["test"].remove(folder)
            folders["train"].append(folder)
    words = ["mukca", "solve", *folders["train"]]
    if folders["test"]:
        words += ["--test", *folders["test"]]
    words += ["--robot", document.robot, "--method", document.method]
    for key, value in {**document.settings, **(given or {})}.items():
        if value not in (None, [], False):
            values = cast("list[Any]", value) if isinstance(value, list) else [value]
            words += [f"--{key.replace('_', '-')}", *([] if value is True else values)]
    if also or given:
        words += ["--out", "calibrated-again"]
    return shlex.join(map(str, words))
