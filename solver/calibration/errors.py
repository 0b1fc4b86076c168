"""Errors of a calibration and of the models compared with it: by placement, role, iteration."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, SupportsIndex, overload

import msgspec
import numpy as np

from ...errors import fixed, millimetres
from .. import results
from ..identification import data
from ..identification.data import Measurement, Metrics, Pose
from .option import UsageError

BALL_REFITTED = "ball_refitted"
HEADS = ("placement", "samples", "mean", "largest", "distance")


class Errors(tuple[results.PlacementErrors, ...]):
    """Errors of the models, placement by placement; prints as a table in mm.

    Those of placements that folds left out come last.
    """

    title = "errors of the ball in mm: before -> by calibrated.urdf"
    """Subject of the table."""

    @overload
    def __getitem__(self, index: SupportsIndex | str) -> results.PlacementErrors: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[results.PlacementErrors, ...]: ...

    def __getitem__(
        self, index: SupportsIndex | str | slice
    ) -> results.PlacementErrors | tuple[results.PlacementErrors, ...]:
        """Return errors by number, or by the placement's name or the last part of it."""
        if not isinstance(index, str):
            return super().__getitem__(index)
        by_name = [(row.name, row) for row in self.placements]
        rows = [row for name, row in by_name if index in (name, name.split("/")[-1])]
        if len(rows) != 1:
            names = ", ".join(name for name, _ in by_name)
            raise UsageError(
                f"no one placement is called {index!r}; there are: {names}"
            )
        return rows[0]

    @property
    def placements(self) -> tuple[results.PlacementErrors, ...]:
        """The rows but those of what was left out."""
        return tuple(row for row in self if row.role != "left_out")

    def left_out(self, name: str) -> results.MetricsByModel | None:
        """Return the mean errors where a placement was left out; None where it never was."""
        rows = [row for row in self if (row.role, row.name) == ("left_out", name)]
        return _summary(rows)

    @cached_property
    def summary(self) -> results.Summaries:
        """The means over the placements trained on, held out, and left out."""
        by_role: dict[str, list[results.PlacementErrors]] = {
            role: [] for role in results.ROLES
        }
        for row in self:
            by_role[row.role].append(row)
        means = {role: _summary(rows) for role, rows in by_role.items()}
        return results.Summaries(**means)

    def as_dict(self) -> dict[str, Any]:
        """Return the errors by name, as the command line's JSON has them [m]."""
        return msgspec.to_builtins(
            {"placements": self.placements, "summary": self.summary}
        )

    def table(self) -> list[tuple[bool, list[str]]]:
        """Return the rows of the table, before -> calibrated [mm]; True marks a summary.

        Where the URDF is not the full model, a row of the full model's errors follows each.
        """
        rows: list[tuple[bool, list[str]]] = []
        for role, title in results.ROLES.items():
            for row in self:
                if row.role == role:
                    rows += _rows(
                        row, f"{row.name}{_kind(row)}", "+".join(map(str, row.samples))
                    )
            summary: results.Summary | None = getattr(self.summary, role)
            if summary is not None:
                removed = fixed(-100 * summary.removed_when_loaded, 0, "+")
                rows += _rows(summary, f"= {title} {removed} %", "")
        return rows

    def __repr__(self) -> str:
        rows = [list(HEADS), *(cells for _, cells in self.table())]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = [self.title]
        for first, *values in rows:
            cells = [first.ljust(widths[0]), *map(str.rjust, values, widths[1:])]
            lines.append("  ".join(cells).rstrip())
        return "\n".join(lines)


def _kind(row: results.PlacementErrors) -> str:
    """Return what the name of a row of poses is followed by."""
    angles = [row.nominal.orientation_error, row.calibrated.orientation_error]
    turned = " -> ".join(f"{1e3 * angle:.3g}" for angle in angles if angle is not None)
    return turned and f" ({turned} mrad)"


def _rows(
    row: results.MetricsByModel, name: str, samples: str
) -> list[tuple[bool, list[str]]]:
    before, loaded, corrected = map(_figures, (row.before, row.loaded, row.calibrated))
    pairs = zip(before, loaded, strict=True)
    cells = [first if first == "-" else f"{first} -> {last}" for first, last in pairs]
    rows = [(isinstance(row, results.Summary), [name, samples, *cells])]
    if row.geometric is not None:
        cells = ["-" if cell == "-" else f"-> {cell}" for cell in corrected]
        rows.append((False, ["  corrected joints", "", *cells]))
    return rows


def _figures(metrics: Metrics) -> list[str]:
    """Return the figures of the columns [mm]."""
    figures = (metrics.mean_absolute_error, metrics.max_error, metrics.distance_error)
    return list(map(millimetres, figures))


def _summary(rows: Sequence[results.PlacementErrors]) -> results.Summary | None:
    """Return the means over some placements; None without any."""
    if not rows:
        return None
    means: dict[str, Any] = results.mean_by_model(rows)
    removed = data.removed_share(means["nominal"], means["calibrated"])
    return results.Summary(**means, removed_error=removed)


def placement_errors(
    calibrated: results.CalibratedRobot,
    ball: results.Place | None,
    trained: Sequence[Measurement],
    placements: Iterable[tuple[results.Role, Measurement]],
    *,
    other_tip: bool = False,
) -> Iterator[results.PlacementErrors]:
    """Yield the errors of placements by a robot's models, and by the nominal one with its ball.

    Args:
        calibrated: The calibrated robot.
        ball: Where the ball sits by the nominal model; None if that is not identified.
        trained: Placements by which each model places the instruments' frames.
        placements: The placements, and their roles.
        other_tip: Of points, see :func:`.target_predictions`.
    """
    models: dict[str, results.CalibratedRobot] = {**calibrated.models}
    nominal = results.with_ball_at(calibrated.robot, ball)
    if nominal is not None:
        models[BALL_REFITTED] = nominal
    frames: dict[str, Mapping[str, Pose]] = {}
    for name, model in models.items():
        frames[name] = data.fit_frames([(model.predict(m), m) for m in trained])
    for role, m in placements:
        predictions = results.target_predictions(models, m, frames, put_on=other_tip)
        metrics: dict[str, Any] = {
            name: prediction.metrics(m) for name, prediction in predictions.items()
        }
        if refitted := metrics.get(BALL_REFITTED):
            metrics[BALL_REFITTED] = replace(refitted, orientation_error=None)
        paired = m if m.kind == "sockets" else None
        yield results.PlacementErrors(
            name=m.name,
            role=role,
            kind=m.kind,
            samples=m.counts,
            distance=paired and paired.distance,
            distance_source=paired and paired.distance_source,
            distance_readings=paired and paired.distance_readings,
            **metrics,
        )


def left_out_errors(folds: Sequence[results.Fold]) -> list[results.PlacementErrors]:
    """Return the errors of what each fold leaves out, by its models."""
    rows: list[results.PlacementErrors] = []
    for fold in folds:
        left_out: list[tuple[results.Role, Measurement]]
        left_out = [("left_out", m) for m in fold.left_out]
        rows += placement_errors(fold.fit.calibrated, fold.ball, fold.trained, left_out)
    return rows


def history(
    iterates: Sequence[results.CalibratedRobot],
    train: Sequence[Measurement],
    test: Sequence[Measurement],
) -> tuple[results.Iteration, ...]:
    """Return the first terms of Eq. (5) after each iteration, the nominal model first."""
    return tuple(
        results.Iteration(
            iteration=i, train=_cost(robot, train), test=_cost(robot, test)
        )
        for i, robot in enumerate(iterates)
    )


def _cost(
    robot: results.CalibratedRobot, placements: Sequence[Measurement]
) -> results.CostTerms | None:
    if not placements:
        return None
    terms = [data.cost_terms(robot.predict(m), m) for m in placements]
    inconsistency, distortion = np.mean(terms, axis=0).tolist()
    return results.CostTerms(inconsistency=inconsistency, distortion=distortion)
