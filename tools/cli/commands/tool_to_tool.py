"""``mukca validate --tool-to-tool``: the distance of two arms' tools, predicted and measured."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path

from ....solver import calibration, data
from ....solver.assessment import mm, plural
from ....solver.calibration import (
    MultiRobotCalibration,
    SolveOptions,
    Spread,
    ToolToTool,
    UsageError,
)
from ... import cli


def compare_tools(
    file: Path, paths: Sequence[Path], settings: SolveOptions, terminal: cli.Terminal
) -> list[ToolToTool]:
    """Return the errors of tool to tool of each two arms that have placements held out.

    Raises:
        UsageError: A single robot, or fewer than two arms with placements held out.
    """
    arms = calibration.load_calibration(file)
    if not isinstance(arms, MultiRobotCalibration):
        raise UsageError(f"{file}: --tool-to-tool needs arms that were calibrated together")
    by_robot, _, _ = cli.split_by_robot(paths, (), arms)
    held_out: dict[str, list[data.Measurement]] = {}
    for name, folders in by_robot.items():
        measured = _held_out(arms, name, folders, settings, terminal) if folders else []
        if measured:
            held_out[name] = measured
    if len(held_out) < 2:
        raise UsageError(
            "--tool-to-tool: give placements that the calibration was not trained on, of two arms"
        )
    return [
        calibration.tool_distances(arms, {name: held_out[name] for name in names})
        for names in combinations(held_out, 2)
    ]


def _held_out(
    arms: MultiRobotCalibration,
    name: str,
    paths: Sequence[Path],
    settings: SolveOptions,
    terminal: cli.Terminal,
) -> list[data.Measurement]:
    """Return the placements of a robot that it was not trained on; each other is a warning."""
    arm, held_out = arms[name], list[data.Measurement]()
    for placement in settings.carrying(cli.read_data(paths, settings), others=True):
        measured = data.measure(placement, arm.robot, settings.distance, sockets=1)
        if arm.was_trained_on(measured):
            terminal.warn(f"{name}, {measured.name}: trained on, so left out")
        else:
            held_out.append(arm.as_read_now(measured))
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
    answer = f"{between}." if limit is None else f"{status.upper()}: {between} (limit {mm(limit)})."
    heads = "mean error, 95 % below, largest [mm]"
    lines = [answer, f"{'tool to tool':24} {'model':18} {heads:>32}"]
    for row in rows:
        names = " to ".join(row.robots)
        lines.append(_line(names, "calibrated.urdf", row.loaded))
        if row.calibrated != row.loaded:
            lines.append(_line("", "corrected joints", row.calibrated))
    for row in rows:
        counts = zip(row.samples, row.robots, strict=True)
        samples = " and ".join(f"{plural(n, 'sample')} of {name}" for n, name in counts)
        lines.append(f"From {samples}, held out at the same places: {row.pairs} distances.")
    return lines


def _line(names: str, model: str, spread: Spread) -> str:
    numbers = "".join(f"{1e3 * error:11.3f}" for error in (spread.mean, spread.p95, spread.max))
    return f"{names:24} {model:18}{numbers}"


def document_of(rows: Sequence[ToolToTool], limit: float | None) -> Mapping[str, object]:
    """Return the figures for scripts [m]."""
    return {
        "tool_to_tool": [row.as_dict() for row in rows],
        "limit": limit,
        "status": status_of(rows, limit),
    }
