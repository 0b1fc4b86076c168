"""Errors of a calibration and of the models compared with it: by placement, role, iteration."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, SupportsIndex, overload

import msgspec
import numpy as np

from ...errors import fixed
from .. import results
from ..assessment import millimetres
from ..identification import data
from ..identification.data import Measurement, Metrics, Pose
from .option import UsageError
from .problem import CalibrationProblem

BALL_REFITTED = "ball_refitted"
HEADS = ("placement", "samples", "MAE", "max", "distance")


class Errors(tuple[results.PlacementErrors, ...]):
    """Errors of the models, placement by placement; prints as a table in mm.

    Those of placements that folds left out come last.
    """

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
        names = [row.name for row in self if row.role != "left_out"]
        ends = [
            i for i, name in enumerate(names) if index in (name, name.split("/")[-1])
        ]
        if len(ends) != 1:
            raise UsageError(
                f"no one placement is called {index!r}; there are: {', '.join(names)}"
            )
        return super().__getitem__(ends[0])

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
        means = {
            role: _summary([row for row in self if row.role == role])
            for role in results.ROLES
        }
        return results.Summaries(**means)

    def as_dict(self) -> dict[str, Any]:
        """Return the errors by name, as the command line's JSON has them [m]."""
        return msgspec.to_builtins(
            {"placements": self.placements, "summary": self.summary}
        )

    @property
    def title(self) -> str:
        """Subject of the table."""
        refitted = any(row.ball_refitted is not None for row in self)
        title = f"errors in mm, nominal{', ball refitted' * refitted} > calibrated"
        if any(row.geometric is not None for row in self):
            return f"{title}.urdf; below, with joint positions corrected first"
        return title

    def table(self) -> list[tuple[bool, list[str]]]:
        """Return the rows of the table, before > calibrated [mm]; True marks a summary.

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
                removed = f"{fixed(100 * summary.removed_when_loaded, 1)} % less"
                rows += _rows(summary, f"= {title}", removed)
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
    """Return what a row's name is followed by: points have true errors, poses angles, too."""
    angles = [row.nominal.orientation_error, row.calibrated.orientation_error]
    turned = " > ".join(f"{1e3 * angle:.3g}" for angle in angles if angle is not None)
    turned = turned and f"; {turned} mrad"
    return "" if row.kind == "sockets" else f" (true error{turned})"


def _rows(
    row: results.MetricsByModel, name: str, samples: str
) -> list[tuple[bool, list[str]]]:
    before, loaded, corrected = map(_figures, (row.before, row.loaded, row.calibrated))
    cells = [f"{first} > {last}" for first, last in zip(before, loaded, strict=True)]
    rows = [(isinstance(row, results.Summary), [name, samples, *cells])]
    if row.geometric is not None:
        rows.append(
            (
                False,
                ["  with corrected joints", "", *(f"> {cell}" for cell in corrected)],
            )
        )
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


def compared_models(
    calibrated: results.CalibratedRobot, nominal: results.CalibratedRobot | None
) -> dict[str, results.CalibratedRobot]:
    """Return a robot's models and the nominal one with its ball refitted, if that is identified."""
    beside = {} if nominal is None else {BALL_REFITTED: nominal}
    return {**calibrated.models, **beside}


def placement_errors(
    models: Mapping[str, results.CalibratedRobot],
    role: results.Role,
    measured: Measurement,
    frames: Mapping[str, Mapping[str, Pose]] | None = None,
    *,
    other_tip: bool = False,
) -> results.PlacementErrors:
    """Return the errors of a placement by models, each with its own poses of instruments' frames.

    ``other_tip``: of points, see :func:`.target_predictions`.
    """
    predictions = results.target_predictions(
        models, measured, frames or {}, put_on=other_tip
    )
    metrics: dict[str, Any] = {
        name: prediction.metrics(measured) for name, prediction in predictions.items()
    }
    if refitted := metrics.get(BALL_REFITTED):
        metrics[BALL_REFITTED] = replace(refitted, orientation_error=None)
    paired = measured if measured.kind == "sockets" else None
    return results.PlacementErrors(
        name=measured.name,
        role=role,
        kind=measured.kind,
        samples=measured.counts,
        distance=paired and paired.distance,
        distance_source=paired and paired.distance_source,
        distance_readings=paired and paired.distance_readings,
        **metrics,
    )


def errors_of(
    problem: CalibrationProblem,
    fit: results.Fit,
    before: results.CalibratedRobot | None,
) -> Errors:
    """Return the errors of all placements.

    ``before`` is the nominal robot with its ball refitted, if that is identified.
    """
    models = compared_models(fit.calibrated, before)
    frames = _frames_by(models, problem.measurements)
    rows: list[results.PlacementErrors] = []
    for role, m in problem.placements:
        row = placement_errors(models, role, m, frames)
        rows.append(row)
    return Errors(rows)


def left_out_errors(folds: Sequence[results.Fold]) -> list[results.PlacementErrors]:
    """Return the errors of what each fold leaves out, by its models."""
    rows: list[results.PlacementErrors] = []
    for fold in folds:
        models = compared_models(fold.fit.calibrated, fold.ball)
        frames = _frames_by(models, fold.trained)
        for measured in fold.left_out:
            rows.append(placement_errors(models, "left_out", measured, frames))
    return rows


def _frames_by(
    models: Mapping[str, results.CalibratedRobot], trained: Sequence[Measurement]
) -> dict[str, Mapping[str, Pose]]:
    """Return the poses of instruments' frames by each model, as the samples trained on say."""
    points = [m for m in trained if m.kind == "points"]
    frames: dict[str, Mapping[str, Pose]] = {}
    for name, model in models.items():
        frames[name] = data.fit_frames([(model.predict(m), m) for m in points])
    return frames


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
