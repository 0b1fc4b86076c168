"""Tables that ``mukca solve --details`` shows of a calibration, beside its answer."""

import math
from collections.abc import Sequence

from ....errors import fixed
from ....solver import assessment, calibration, results
from ....solver.assessment import millimetres
from ...report import figures
from .. import Terminal
from .placement_errors import show_errors


def show_details(terminal: Terminal, calibrated: "calibration.Calibration") -> None:
    """Print the figures of one robot."""
    terminal.say(assessment.distance_text(calibrated.document.placements))
    if calibrated.document.scale is not None:
        terminal.say(f"Size: {assessment.scale_text(calibrated.document.scale)}.")
    show_errors(calibrated.errors, terminal)
    _show_matrix(calibrated, terminal)
    if calibrated.document.error_patterns is not None:
        terminal.say(calibrated.document.error_patterns.text)
    _show_parameters(calibrated.result.parameters, terminal)
    terminal.say(*_remarks(calibrated.document))


def _show_matrix(calibrated: "calibration.Calibration", terminal: Terminal) -> None:
    """Show the errors everywhere by fits to each placement alone: the paper's Fig. 6."""
    matrix = figures.cross_placement(calibrated.assessment.predictions)
    if matrix is None:
        return
    names = assessment.short_names(matrix.names)
    nothing = [None] * len(names)
    rows: list[list[str]] = []
    for i, (name, errors) in enumerate(zip(names, matrix.matrix, strict=True)):
        cells = [f"{i + 1} {name}", *map(millimetres, errors or nothing)]
        cells[i + 1] = f"({cells[i + 1]})"
        rows.append(cells)
    title = f"MAE in mm by {matrix.method}: trained on the row's placement alone, at the column's"
    terminal.tabulate(title, ["", *map(str, range(1, len(names) + 1))], rows)


def _show_parameters(
    rows: "Sequence[results.ParameterValue]", terminal: Terminal
) -> None:
    """Show the changes of the joint origins in mm and mrad, one line a joint."""
    from ....solver.identification.robot import COMPONENTS

    changes = {
        (row.joint, row.component): fixed(1e3 * row.change, 3, "+") for row in rows
    }
    joints = dict.fromkeys(row.joint for row in rows)
    cells = [
        [joint, *(changes.get((joint, c), "fixed") for c in COMPONENTS)]
        for joint in joints
    ]
    title = "change of the joint origins, in mm and mrad"
    terminal.tabulate(title, ("joint", *COMPONENTS), cells, no_wrap=True)


def _remarks(result: "results.CalibrationDocument") -> list[str]:
    """Return lines on the fit that the tables do not have."""
    lines = [
        f"{result.optimizer}: {result.iterations} iterations in "
        f"{1e3 * result.solve_seconds:.0f} ms."
    ]
    lines += result.choices or ()
    lines += _frame_lines(result.frames or ())
    lines += assessment.intervals_in_words(result.better)
    if result.uncertainty is not None:
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
