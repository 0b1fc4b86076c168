"""The report's part on frames: true errors against an instrument, and where each frame stands."""

from ..figures import ReportDocument
from .html import Cell, Element, figure, table, tag

PLUS_MINUS = " \N{PLUS-MINUS SIGN} "
_TRUE = (
    "An instrument measured the ball itself here: these are true errors, distances from the "
    "predicted ball to the measured one. All errors of sockets are self-consistency: how well the "
    "model agrees with itself."
)
_STANDS = (
    "Where the frames stand in which positions were measured, seen from the robot's base: the "
    "origin in mm, the turn about the base's x, y and z axes in degrees, each with one standard "
    "deviation."
)


def frames(report: ReportDocument) -> Element | None:
    """Return true errors and frames; None where nothing was measured in a frame."""
    true, stands = _true_errors(report), _stands(report)
    if true is None and stands is None:
        return None
    return tag(
        "section", tag("h2", "Against what was measured in space"), true, stands, id="frames"
    )


def _true_errors(report: ReportDocument) -> Element | None:
    """Return the errors of points that an instrument measured."""
    rows: list[list[Cell]] = []
    for i, row in enumerate(report.placements):
        if row.kind != "points":
            continue
        path = f"placements.{i}"
        full = [figure(report, f"{path}.calibrated.mean_absolute_error"), " mm"]
        loaded = "geometric" if row.geometric is not None else "calibrated"
        rows.append(
            [
                row.name,
                "trained on" if row.role == "train" else "held out",
                [figure(report, f"{path}.nominal.mean_absolute_error"), " mm"],
                [figure(report, f"{path}.{loaded}.mean_absolute_error"), " mm"],
                full,
                [figure(report, f"{path}.{loaded}.max_error"), " mm"],
            ]
        )
    if not rows:
        return None
    heads = ["points", "role", "nominal", "URDF alone", "joints corrected", "URDF alone, largest"]
    return tag("div", tag("h3", "True error"), tag("p", _TRUE), table(heads, rows, "numbers"))


def _stands(report: ReportDocument) -> Element | None:
    """Return where each frame stands."""
    rows: list[list[Cell]] = []
    degrees = 57.29577951308232
    for i, row in enumerate(report.frames or ()):
        path = f"frames.{i}"
        cells: list[Cell] = [row.name]
        for k in range(3):
            place = figure(report, f"{path}.xyz.{k}", digits=2)
            deviation = figure(report, f"{path}.xyz_deviation.{k}", digits=2)
            cells.append([place, PLUS_MINUS, deviation] if row.turn_known else "unknown")
        for k in range(3):
            turned = figure(report, f"{path}.rpy.{k}", scale=degrees)
            deviation = figure(report, f"{path}.turn_deviation.{k}", scale=degrees)
            cells.append([turned, PLUS_MINUS, deviation] if row.turn_known else "unknown")
        off = figure(report, f"{path}.socket_error")
        cells += [f"{row.sockets} sockets, {row.points} points", off]
        rows.append(cells)
    if not rows:
        return None
    heads = [
        "frame",
        "x",
        "y",
        "z",
        "roll",
        "pitch",
        "yaw",
        "measured in it",
        "its sockets, rms mm",
    ]
    return tag("div", tag("h3", "Frames"), tag("p", _STANDS), table(heads, rows, "numbers"))
