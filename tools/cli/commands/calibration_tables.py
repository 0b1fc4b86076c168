"""Tables of a calibration: errors of placements, in short or all, and what else its details are."""

import math
from collections.abc import Sequence
from functools import partial

from ....errors import fixed
from ....solver import assessment, calibration, results
from ....solver.assessment import millimetres, plural, short_names
from ... import cli
from ...report.figures import cross_placement

MOST_ROWS = 6
"""Placements in the short table, the worst ones."""
HEAD = "mean error of the ball, mm"
WIDTHS = {HEAD: "26", "": "10", "samples": ">8", "left out": ">9", "trained on": ">11"}
"""Widths of its columns by their heads."""
LONGEST = 26
"""Letters of a placement's name there."""


def show_errors(
    errors: "calibration.Errors", terminal: cli.Terminal, *, short: bool = False
) -> None:
    """Show the nominal and the calibrated errors of each placement, and the summaries."""
    if short:
        rows = (left_out_rows if errors.summary.left_out else short_rows)(errors)
        terminal.say_rows(rows, partial(_aligned, rows[0]))
        return
    summed, rows = zip(*errors.table(), strict=True)
    bold = [number for number, sums_up in enumerate(summed) if sums_up]
    terminal.tabulate(errors.title, calibration.HEADS, rows, bold=bold, no_wrap=True)


def short_rows(errors: "calibration.Errors") -> list[list[str]]:
    """Return rows with mean errors before, by the URDF, and with corrected joints [mm].

    The heads come first. A row of a single cell tells how many placements are left out.
    """
    names = short_names([row.name for row in errors])
    two = any(row.geometric is not None for row in errors)
    heads = [HEAD, "", "samples", "before", "now"]
    rows = [[*heads, "corrected joints"] if two else heads]
    worst = sorted(errors, key=lambda row: -row.loaded.mean_absolute_error)[:MOST_ROWS]
    for name, row in zip(names, errors, strict=True):
        if row in worst:
            samples = "+".join(map(str, row.samples))
            figures = _figures(row, two=two)
            rows.append([name[-LONGEST:], results.ROLES[row.role], samples, *figures])
    rows += _others(len(errors))
    for role, title in results.ROLES.items():
        summary: results.Summary | None = getattr(errors.summary, role)
        if summary:
            rows.append([_mean(summary), title, "", *_figures(summary, two=two)])
    return rows


def left_out_rows(errors: "calibration.Errors") -> list[list[str]]:
    """Return rows with mean errors before, left out, trained on, and with corrected joints [mm].

    All but those trained on are by the fit that left the placement out.
    """
    trained = [row for row in errors if row.role == "train"]
    two = any(row.geometric is not None for row in errors)
    heads = [HEAD, "samples", "before", "left out", "trained on"]
    rows = [[*heads, "corrected joints"] if two else heads]
    left_out = [errors.left_out(row.name) for row in trained]
    sizes = sorted(row.loaded.mean_absolute_error for row in left_out if row)
    least = sizes[-MOST_ROWS:][0]
    names = short_names([row.name for row in trained])
    for name, row, proof in zip(names, trained, left_out, strict=True):
        if proof is None or proof.loaded.mean_absolute_error >= least:
            samples = "+".join(map(str, row.samples))
            cells = _beside_trained(proof, row, two=two)
            rows.append([name[-LONGEST:], samples, *cells])
    rows += _others(len(trained))
    summary = errors.summary
    assert summary.train and summary.left_out
    cells = _beside_trained(summary.left_out, summary.train, two=two)
    return [*rows, [_mean(summary.left_out), "", *cells]]


def _beside_trained(
    left_out: "results.MetricsByModel | None",
    trained: "results.MetricsByModel",
    *,
    two: bool,
) -> list[str]:
    """Return the cells of a row: before, left out, trained on, and with corrected joints."""
    fitted = millimetres(trained.loaded.mean_absolute_error)
    if left_out is None:
        return ["-", "-", fitted, *["-"] * two]
    before, *cells = _figures(left_out, two=two)
    return [before, cells[0], fitted, *cells[1:]]


def _others(count: int) -> list[list[str]]:
    """Return the row that tells how many of so many placements are not shown."""
    if count <= MOST_ROWS:
        return []
    return [[f"  and {plural(count - MOST_ROWS, 'placement')} with smaller errors"]]


def _mean(summary: "results.Summary") -> str:
    return f"= mean ({fixed(-100 * summary.removed_when_loaded, 1, '+')} %)"


def _aligned(heads: Sequence[str], row: Sequence[str]) -> str:
    """Return a row of the short table as a line."""
    pairs = zip(heads, row, strict=True)
    return " ".join(f"{cell:{WIDTHS.get(head, '>7')}}" for head, cell in pairs)


def _figures(row: "results.MetricsByModel", *, two: bool) -> list[str]:
    models = (row.before, row.loaded, row.calibrated)
    return [millimetres(model.mean_absolute_error) for model in models[: 2 + two]]


def show_details(terminal: cli.Terminal, calibrated: "calibration.Calibration") -> None:
    """Print the figures of one robot."""
    terminal.say(assessment.distance_text(calibrated.document.placements))
    if calibrated.document.scale:
        terminal.say(f"Size: {assessment.scale_text(calibrated.document.scale)}.")
    show_errors(calibrated.errors, terminal)
    _show_matrix(calibrated, terminal)
    if calibrated.document.error_patterns:
        terminal.say(calibrated.document.error_patterns.text)
    _show_parameters(calibrated.result.parameters, terminal)
    terminal.say(*_remarks(calibrated.document))


def _show_matrix(calibrated: "calibration.Calibration", terminal: cli.Terminal) -> None:
    """Show the errors everywhere by fits to each placement alone: the paper's Fig. 6."""
    matrix = cross_placement(calibrated.assessment.predictions)
    if matrix is None:
        return
    names = short_names(matrix.names)
    nothing = [None] * len(names)
    rows: list[list[str]] = []
    for i, (name, errors) in enumerate(zip(names, matrix.matrix, strict=True)):
        cells = [f"{i + 1} {name}", *map(millimetres, errors or nothing)]
        cells[i + 1] = f"({cells[i + 1]})"
        rows.append(cells)
    title = f"MAE in mm by {matrix.method}: trained on the row's placement alone, at the column's"
    terminal.tabulate(title, ["", *map(str, range(1, len(names) + 1))], rows)


def _show_parameters(
    rows: "Sequence[results.ParameterValue]", terminal: cli.Terminal
) -> None:
    """Show the changes of the joint origins in mm and mrad, one line a joint."""
    from ....solver.identification.robot import COMPONENTS

    changes: dict[str, dict[str, str]] = {}
    for row in rows:
        of_joint = changes.setdefault(row.joint, dict.fromkeys(COMPONENTS, "fixed"))
        of_joint[row.component] = fixed(1e3 * row.change, 3, "+")
    cells = [[joint, *words.values()] for joint, words in changes.items()]
    title = "change of the joint origins, in mm and mrad"
    terminal.tabulate(title, ("joint", *COMPONENTS), cells, no_wrap=True)


def _remarks(result: "results.CalibrationDocument") -> list[str]:
    """Return lines on the fit that the tables do not have."""
    time = f"{1e3 * result.solve_seconds:.0f} ms"
    lines = [f"{result.optimizer}: {result.iterations} iterations in {time}."]
    lines += result.choices or ()
    lines += _frame_lines(result.frames or ())
    lines += assessment.intervals_in_words(result.better)
    if result.uncertainty:
        lines += [f"Not observable: {text}." for text in result.uncertainty.cannot_see]
    return lines


def _frame_lines(frames: "Sequence[results.FramePose]") -> list[str]:
    """Pose of each frame and its deviation, a line each."""
    lines: list[str] = []
    for frame in frames:
        error = ""
        if frame.socket_error is not None:
            sockets = f"{frame.sockets} socket{'s are' if frame.sockets > 1 else ' is'}"
            error = f"; its {sockets} {millimetres(frame.socket_error)} mm off (rms)"
        if frame.name == "base":
            lines.append(f"Frame base: the robot's own{error}.")
        elif not frame.turn_known:
            lines.append(
                f"Frame {frame.name}: direction unknown{error}; it needs three places or more that "
                "are not on one line."
            )
        else:
            position = " ".join(fixed(1e3 * v, 2, "+") for v in frame.xyz)
            rotation = " ".join(fixed(math.degrees(v), 3, "+") for v in frame.rpy)
            lines.append(
                f"Frame {frame.name} stands at {position} mm "
                f"(+- {millimetres(max(frame.xyz_deviation))}), turned {rotation} deg "
                f"(+- {math.degrees(max(frame.turn_deviation)):.3f}) in the base{error}."
            )
    return lines
