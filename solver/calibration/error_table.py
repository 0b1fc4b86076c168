"""Errors of the models at each placement, their means, and both as a table in millimetres."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any, SupportsIndex, overload

import msgspec

from ..assessment import millimetres
from ..data import Metrics, mean_metrics, removed_share
from ..results import PlacementErrors, Summaries, Summary
from .option import UsageError

HEADS = ("placement", "samples", "MAE", "max", "distance")


class Errors(tuple[PlacementErrors, ...]):
    """Errors of the models, placement by placement; prints as a table in mm."""

    @overload
    def __getitem__(self, index: SupportsIndex | str) -> PlacementErrors: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[PlacementErrors, ...]: ...

    def __getitem__(
        self, index: SupportsIndex | str | slice
    ) -> PlacementErrors | tuple[PlacementErrors, ...]:
        """Return errors by number, or by the placement's name or the last part of it."""
        if not isinstance(index, str):
            return super().__getitem__(index)
        names = [one.name for one in self]
        ends = [i for i, name in enumerate(names) if index in (name, name.split("/")[-1])]
        if len(ends) != 1:
            raise UsageError(f"no one placement is called {index!r}; there are: {', '.join(names)}")
        return super().__getitem__(ends[0])

    @property
    def placements(self) -> tuple[PlacementErrors, ...]:
        """The rows, without more."""
        return tuple(self)

    @cached_property
    def summary(self) -> Summaries:
        """The means over the placements trained on, and over those held out."""
        train, test = ([row for row in self if row.role == role] for role in ("train", "test"))
        return Summaries(train=_summary(train), test=_summary(test))

    def as_dict(self) -> dict[str, Any]:
        """Return the errors by name, as the command line's JSON has them [m]."""
        return msgspec.to_builtins({"placements": self.placements, "summary": self.summary})

    @property
    def title(self) -> str:
        """Subject of the table."""
        if any(row.geometric is not None for row in self):
            return (
                "errors in mm, nominal > calibrated.urdf; below, with joint positions corrected "
                "first"
            )
        return "errors in mm, nominal > calibrated"

    def table(self) -> list[tuple[bool, list[str]]]:
        """Return the rows of the table, nominal > calibrated [mm]; True marks a summary.

        Where the URDF is not the full model, a row of the full model's errors follows each.
        """
        rows: list[tuple[bool, list[str]]] = []
        parts = (
            (self.summary.train, "train", "trained on"),
            (self.summary.test, "test", "held out"),
        )
        for summary, role, title in parts:
            for row in self:
                if row.role == role:
                    name = f"{row.name}{_kind(row)}"
                    rows += _rows(row, name, "+".join(map(str, row.samples)))
            if summary is not None:
                removed = f"{100 * removed_share(summary.nominal, summary.loaded):.1f} % less"
                rows += _rows(summary, f"= {title}", removed)
        return rows

    def __repr__(self) -> str:
        rows = [list(HEADS), *(cells for _, cells in self.table())]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = [self.title]
        for first, *others in rows:
            cells = [first.ljust(widths[0]), *map(str.rjust, others, widths[1:])]
            lines.append("  ".join(cells).rstrip())
        return "\n".join(lines)


def _kind(row: PlacementErrors) -> str:
    """Return what a row's name is followed by: points have true errors, poses angles, too."""
    angles = [row.nominal.orientation_error, row.calibrated.orientation_error]
    turned = " > ".join(f"{1e3 * angle:.3g}" for angle in angles if angle is not None)
    turned = turned and f"; {turned} mrad"
    return "" if row.kind == "sockets" else f" (true error{turned})"


def _rows(row: PlacementErrors | Summary, name: str, samples: str) -> list[tuple[bool, list[str]]]:
    nominal, loaded, full = map(_figures, (row.nominal, row.loaded, row.calibrated))
    cells = [f"{before} > {after}" for before, after in zip(nominal, loaded, strict=True)]
    rows = [(isinstance(row, Summary), [name, samples, *cells])]
    if row.geometric is not None:
        rows.append((False, ["  with corrected joints", "", *(f"> {cell}" for cell in full)]))
    return rows


def _figures(metrics: Metrics) -> list[str]:
    """Return the figures of the columns [mm]."""
    figures = (metrics.mean_absolute_error, metrics.max_error, metrics.distance_error)
    return list(map(millimetres, figures))


def _summary(rows: Sequence[PlacementErrors]) -> Summary | None:
    """Return the means over some placements; None without any."""
    if not rows:
        return None
    means: dict[str, Any] = {}
    for name in ("nominal", "calibrated", "geometric", "ball_refitted"):
        there = [metrics for row in rows if (metrics := getattr(row, name)) is not None]
        means[name] = mean_metrics(there) if there else None
    return Summary(**means, removed_error=removed_share(means["nominal"], means["calibrated"]))
