"""Rows on the recordings: what was found in them, how many samples, how far each joint turned.

A few samples, or many alike, leave small errors by any model, so small errors are then no proof.
"""

import math
from collections.abc import Sequence

import numpy as np

from ..data import Measurement
from ..results import Diagnostic
from ..robot import InverseKinematics
from .accuracy import accuracy_rows, size_known_row
from .coverage import Coverage, travels
from .formatting import joined, plural
from .limits import LimitResult, Limits, Status, limit_row
from .predictions import Predictions
from .scale_check import assumed_distances, distance_row, distortion_row, scale_row
from .steady_drift import drift_rows

LEAST_SAMPLES = 10
"""In each of two sockets: with fewer, the sockets' centres and the noise are hardly known."""
LEAST_HELD_OUT = 5
"""In each of two sockets held out: with fewer, the mean lies with the samples."""
LEAST_TRAVEL = math.radians(20)
"""A joint that turned less than this over all that was trained on is hardly seen [rad]."""
FREE = 0.01
"""Share of a joint's motion that the ball in its socket allows; an arm of five joints in a plane
cannot turn its first one."""
BESIDE = ("far", "duplicate", "few", "still", "drift", "moved", "movement")
"""Codes of warnings that do not bear on the model: single samples that hardly count, and amounts
that rows of their own judge; and held-out placements whose base drifted, or moved by little: one
that was trained on has an error there."""


def rows_of_the_fit(
    predictions: Predictions, covered: Coverage, limits: Limits, held_out: Sequence[LimitResult]
) -> list[LimitResult]:
    """Return the rows on the recordings, the arm's size, and how much is known by them."""
    document = predictions.document
    proved = [row.name for row in held_out if "pass" in (row.status, row.full_status)]
    doubted = {"mean_absolute_error", "distance_error"} <= set(proved)
    checks = checks_row(document.checks, drift_doubted=doubted)
    rows = [checks, *drift_rows(predictions), distortion_row(document)]
    rows.append(distance_row(assumed_distances(document)))
    if document.scale is not None:
        rows.append(scale_row(document.scale, document.placements, document.checks))
    tied = bool(document.settings.get("known"))
    trained, tested = (
        [p.measured for p in predictions.placements if p.role == role] for role in ("train", "test")
    )
    rows += [samples_row(trained, tested, tied=tied), travel_row(covered, _held(predictions))]
    if document.uncertainty is None and document.method == "paper":
        return [*rows, size_known_row(document.scale, covered)]
    return [*rows, *accuracy_rows(document.uncertainty, limits.mean_absolute_error, covered)]


def checks_row(checks: Sequence[Diagnostic] | None, *, drift_doubted: bool = False) -> LimitResult:
    """Return the row of the data checks: no PASS beside an error, or what bears on the model.

    Args:
        checks: What was found; None where nobody looked.
        drift_doubted: What was held out is within its limits, so that a drift fails nothing.
    """
    name, title = "data_checks", "data checks"
    if checks is None:
        words = "the calibration holds no checks of the recordings; run mukca check"
        return limit_row(name, title, "not evaluated", words)
    errors, warnings = ([c for c in checks if c.level == level] for level in ("error", "warning"))
    reason = f"{plural(len(errors), 'error')} and {plural(len(warnings), 'warning')}"
    reason += " in the recordings"
    drifts = tuple(one.where for one in errors if one.code == "drift" and drift_doubted)
    if not all(drifts and one.where.startswith(drifts) for one in errors):
        return limit_row(name, title, "fail", reason)
    doubts = [*errors, *(one for one in warnings if one.code not in BESIDE)]
    if not doubts:
        return limit_row(name, title, "pass", reason)
    text = "; ".join(dict.fromkeys(f"{one.text}; {one.advice}" for one in doubts))
    return limit_row(name, title, "not enough", reason, text=text)


def samples_row(
    trained: Sequence[Measurement], held_out: Sequence[Measurement] = (), *, tied: bool
) -> LimitResult:
    """Return whether enough samples lie in each socket.

    Args:
        trained: Placements to train on.
        held_out: Those held out.
        tied: Distances between placements were given to the fit, so that two sockets of any count.
    """
    if all(m.kind == "points" for m in trained):
        return _points_row(trained, held_out)
    counts = [m.counts for m in trained]
    few = _second([tuple(n for own in counts for n in own)] if tied else counts)
    proving = _second([m.counts for m in held_out])
    text = f"{plural(few, 'sample')} or more in each socket trained on"
    enough: Status = "pass"
    if few < LEAST_SAMPLES:
        enough = "not enough"
        text = (
            f"only {plural(few, 'sample')} in a socket trained on; record at least "
            f"{LEAST_SAMPLES} in each, better 30"
        )
    elif held_out and proving < LEAST_HELD_OUT:
        enough = "not enough"
        text = (
            f"only {plural(proving, 'sample')} in a socket held out; record at least "
            f"{LEAST_HELD_OUT} in each, better 30"
        )
    return limit_row("samples", "samples in each socket", enough, text)


def _points_row(trained: Sequence[Measurement], held_out: Sequence[Measurement]) -> LimitResult:
    """Return whether an instrument measured enough points, where no socket was trained on."""
    name, title = "samples", "measured points"
    for placements, part, least in (
        (trained, "trained on", 2 * LEAST_SAMPLES),
        (held_out, "held out", 2 * LEAST_HELD_OUT),
    ):
        count = sum(n for m in placements for n in m.counts)
        if 0 < count < least:
            text = f"only {plural(count, 'measured point')} {part}; measure {least} or more"
            return limit_row(name, title, "not enough", text)
    count = sum(n for m in trained for n in m.counts)
    return limit_row(name, title, "pass", f"{plural(count, 'measured point')} trained on")


def _second(sockets: Sequence[tuple[int, ...]]) -> int:
    """Return how many samples two sockets of some placement have, at the best placement."""
    return max((sorted(counts)[-2] if len(counts) > 1 else 0 for counts in sockets), default=0)


def _held(predictions: Predictions) -> list[str]:
    """Return the joints that a ball in its socket holds, whatever the others do."""
    guide = InverseKinematics(predictions.robot)
    q = [p.measured.positions for p in predictions.placements if p.measured.kind == "sockets"]
    if not q:
        return []
    J = guide.ball_and_neck(np.concatenate(q))[1][:, :3]
    bound = np.einsum("nij,nji->ni", np.linalg.pinv(J, rcond=1e-3), J)
    pairs = zip(predictions.robot.joint_names, 1 - np.median(bound, axis=0), strict=True)
    return [name for name, free in pairs if free < FREE]


def travel_row(coverage: Coverage, held: Sequence[str] = ()) -> LimitResult:
    """Return whether each joint that turns was turned enough while recording.

    Args:
        coverage: How far each joint turned.
        held: Joints that cannot turn while the ball is in a socket.
    """
    turned = {name: travel for name, travel in travels(coverage).items() if name not in held}
    still = [name for name, travel in turned.items() if travel < LEAST_TRAVEL]
    least = math.degrees(min(turned.values(), default=0.0))
    if not still:
        return limit_row(
            "travel", "travel of each joint", "pass", f"each joint turned {least:.0f} deg or more"
        )
    text = (
        f"{joined(still)} turned by {least:.0f} deg or little more; record samples in which each "
        f"joint turns by {math.degrees(LEAST_TRAVEL):.0f} deg at least, better 90"
    )
    return limit_row("travel", "travel of each joint", "not enough", text)
