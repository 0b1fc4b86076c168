"""Plots of joint error curves: one panel a joint, with its band and the angles of the samples."""

import numpy as np

from ....solver.assessment import Coverage
from ....solver.results import JointCurve
from ..figures import ReportDocument
from .figure import Axis, Panel
from .plot import Plot, plot

_DEGREES, _MRAD = 180 / np.pi, 1e3
LEAST_BLANK = 10.0
"""Angles without samples that are named, all together [degrees]."""


def error_curves(report: ReportDocument) -> Plot | None:
    """Error curve of each joint, with a band of one standard deviation."""
    if report.curves is None or not report.curves.joints:
        return None
    curves = report.curves.joints
    most = max(abs(v) + d for c in curves for v, d in zip(c.values, c.deviations, strict=True))
    y = Axis.around_zero([_MRAD * most], "mrad")
    panels = [_panel(curve, y, _angles(report.coverage, curve.joint)) for curve in curves]
    largest = max((_MRAD * max(map(abs, c.values)), c.joint) for c in curves)
    blank = [f"{degrees:.0f} degrees of {c.joint}" for c in curves if (degrees := _blank(c))]
    return plot("curves", *panels, layout="half", largest=largest, blank=blank)


def _angles(coverage: Coverage, joint: str) -> list[float]:
    """Return the angles of the samples that were trained on, from -180 to 180 degrees."""
    k = [one.name for one in coverage.joints].index(joint)
    angles = [q[k] for s in coverage.sockets if s.role == "train" for q in s.positions]
    return [(_DEGREES * angle + 180) % 360 - 180 for angle in angles]


def _panel(curve: JointCurve, y: Axis, angles: list[float]) -> Panel:
    panel = Panel(f"{curve.joint}, mrad", Axis(-180, 180, "degrees"), y, height=170).grid()
    count = len(curve.values)
    order = np.roll(np.arange(count), count // 2)
    at = 360 / count * ((order + count // 2) % count - count // 2)
    values, band = _MRAD * np.array(curve.values)[order], _MRAD * np.array(curve.deviations)[order]
    edges = [*zip(at, values + band, strict=True)]
    edges += reversed([*zip(at, values - band, strict=True)])
    path = " ".join(f"{panel.x(a):.1f},{panel.y(b):.1f}" for a, b in edges)
    panel.add("polygon", points=path, class_="deviation-area")
    panel.rule("zero", y=0)
    panel.line(zip(at.tolist(), values.tolist(), strict=True), "change")
    marks = "".join(f"M{panel.x(a):.1f} {panel.bottom - 5:.1f}v5" for a in angles)
    panel.add("path", d=marks, class_="tick-train")
    return panel


def _blank(curve: JointCurve) -> float:
    """Return how much of a turn has no sample near, 0 where it is little [degrees]."""
    blank = 360 - sum(_DEGREES * (high - low) for low, high in curve.sampled)
    return blank if blank >= LEAST_BLANK else 0.0
