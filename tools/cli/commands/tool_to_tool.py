"""``mukca validate --tool-to-tool``: the distance of two arms' tools, predicted and measured."""

import shlex
from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import chain, combinations
from pathlib import Path

from ....errors import MukcaError
from ....solver import calibration
from ....solver.assessment import mm, plural
from ....solver.calibration import (
    MultiRobotCalibration,
    SolveOptions,
    Spread,
    ToolToTool,
    UsageError,
)
from ....solver.identification import data
from ... import cli

SWAPPED = 0.2
"""Recordings of two arms look swapped where they have this share of the error once exchanged."""

_Paths = Mapping[str, Sequence[Path]]
"""Recordings of each arm, by its name."""


def compare_tools(
    file: Path, paths: Sequence[Path], settings: SolveOptions, terminal: cli.Terminal
) -> tuple[list[ToolToTool], list[str]]:
    """Return the errors of tool to tool of each two arms, and lines on swapped recordings.

    Raises:
        UsageError: A single robot, or fewer than two arms with placements held out.
    """
    if "" in calibration.calibration_files(file):
        raise UsageError(
            f"{file}: --tool-to-tool needs arms that were calibrated together"
        )
    arms = calibration.load_cell(file)
    by_robot, _, _ = cli.split_by_robot(paths, (), arms)
    by_robot = {name: folders for name, folders in by_robot.items() if folders}
    held_out = _held_out(arms, _measured(arms, by_robot, settings), terminal)
    if len(held_out) < 2:
        raise UsageError(
            "--tool-to-tool: give placements that the calibration was not trained on, of two arms"
        )
    rows = [
        calibration.tool_distances(arms, {name: held_out[name] for name in names})
        for names in combinations(held_out, 2)
    ]
    hints: list[str] = []
    for row in rows:
        exchanged = _exchanged(arms, by_robot, row.robots, settings)
        if exchanged and exchanged.loaded.p95 < SWAPPED * row.loaded.p95:
            within = f": exchanged, 95 % are right within {mm(exchanged.loaded.p95)}"
            hints.append(_swapped_words(by_robot, row.robots, within))
    return rows, hints


def _measured(
    arms: MultiRobotCalibration, by_robot: _Paths, settings: SolveOptions
) -> dict[str, list[data.Measurement]]:
    """Return the placements of each arm, checked; an error says whether arms look swapped."""
    try:
        measured = {n: _of_arm(arms, n, by_robot[n], settings) for n in by_robot}
    except MukcaError as error:
        for names in combinations(by_robot, 2):
            if _exchanged(arms, by_robot, names, settings):
                words = f"{error}. {_swapped_words(by_robot, names)}"
                raise UsageError(words) from None
        raise
    data.check_distinct(list(chain.from_iterable(measured.values())))
    return measured


def _of_arm(
    arms: MultiRobotCalibration,
    name: str,
    paths: Sequence[Path],
    settings: SolveOptions,
) -> list[data.Measurement]:
    arm = arms[name]
    placements = cli.read_data(paths, settings)
    return [
        arm.as_read_now(data.measure(p, arm.robot, settings.distance, sockets=1))
        for p in settings.payloads.carried_by(placements, others=True)
    ]


def _exchanged(
    arms: MultiRobotCalibration,
    by_robot: _Paths,
    names: tuple[str, str],
    settings: SolveOptions,
) -> ToolToTool | None:
    """Return the errors with two arms' recordings exchanged; None where they cannot be so."""
    with suppress(MukcaError):
        pairs = zip(names, reversed(names), strict=True)
        placements = {a: _of_arm(arms, a, by_robot[b], settings) for a, b in pairs}
        return calibration.tool_distances(arms, placements)
    return None


def _swapped_words(by_robot: _Paths, names: tuple[str, str], within: str = "") -> str:
    """Return that two arms' recordings look swapped, and what to type."""
    first, second = names
    words = [f"{first}:{path}" for path in by_robot[second]]
    words += [f"{second}:{path}" for path in by_robot[first]]
    return f"Recordings of {first} and {second} look swapped{within}; type {shlex.join(words)}"


def _held_out(
    arms: MultiRobotCalibration,
    measured: Mapping[str, Sequence[data.Measurement]],
    terminal: cli.Terminal,
) -> dict[str, list[data.Measurement]]:
    """Return the arms' placements that they were not trained on; each other is a warning."""
    held_out: dict[str, list[data.Measurement]] = {}
    for name, placements in measured.items():
        for placement in placements:
            if arms[name].was_trained_on(placement):
                terminal.warn(f"{name}, {placement.name}: trained on, so left out")
            else:
                held_out.setdefault(name, []).append(placement)
    return held_out


def status_of(rows: Sequence[ToolToTool], limit: float | None) -> str:
    """Return ``fail`` if the 95th percentile of the errors by calibrated.urdf is beyond [m]."""
    if limit is None:
        return "not evaluated"
    return "pass" if all(row.loaded.p95 <= limit for row in rows) else "fail"


def lines_of(rows: Sequence[ToolToTool], limit: float | None) -> list[str]:
    """Return the answer in words, then a table."""
    worst = max(rows, key=lambda row: row.loaded.p95)
    between = f"95 % of the distances from tool to tool are right within {mm(worst.loaded.p95)}"
    status = status_of(rows, limit)
    answer = f"{between}."
    if limit is not None:
        answer = f"{status.upper()}: {between} (limit {mm(limit)})."
    heads = "mean error, 95 % below, largest [mm]"
    lines = [answer, f"{'tool to tool':24} {'model':18} {heads:>32}"]
    for row in rows:
        lines.append(_line(" to ".join(row.robots), "calibrated.urdf", row.loaded))
        if row.calibrated != row.loaded:
            lines.append(_line("", "corrected joints", row.calibrated))
    for row in rows:
        counts = zip(row.samples, row.robots, strict=True)
        samples = " and ".join(f"{plural(n, 'sample')} of {name}" for n, name in counts)
        lines.append(
            f"From {samples}, held out at the same places: {row.pairs} distances."
        )
    return lines


def _line(names: str, model: str, spread: Spread) -> str:
    errors = (spread.mean, spread.p95, spread.max)
    numbers = "".join(f"{1e3 * error:11.3f}" for error in errors)
    return f"{names:24} {model:18}{numbers}"


def document_of(
    rows: Sequence[ToolToTool], limit: float | None
) -> Mapping[str, object]:
    """Return the figures for scripts [m]."""
    return {
        "tool_to_tool": [row.as_dict() for row in rows],
        "limit": limit,
        "status": status_of(rows, limit),
    }
