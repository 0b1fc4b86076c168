"""Figures by each of the models that a calibration compares."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Generic, Literal, TypeVar

from ..identification.data import Metrics, mean_metrics
from .files import Document

Value = TypeVar("Value")
Other = TypeVar("Other")
ModelName = Literal["nominal", "calibrated", "geometric"]
"""``geometric``: ``calibrated.urdf`` as the user loads it."""
MODELS: tuple[ModelName, ...] = ("nominal", "calibrated", "geometric")


class ByModel(Document, Generic[Value]):
    """The same figure by each model."""

    nominal: Value
    calibrated: Value
    """By the full model."""
    geometric: Value | None = None
    """By ``calibrated.urdf`` alone, where it is not the full model."""

    def of(self, model: ModelName) -> Value:
        """Return the figure of one model."""
        if model == "geometric" and self.geometric is not None:
            return self.geometric
        return self.nominal if model == "nominal" else self.calibrated

    @property
    def loaded(self) -> Value:
        """The figure by ``calibrated.urdf``, which is what a user loads."""
        return self.of("geometric")

    def by_name(self, figure: Callable[[ModelName], Other]) -> "ByModel[Other]":
        """Return another figure of the same models, computed by their names."""
        models = MODELS[: 2 + (self.geometric is not None)]
        return ByModel(**{model: figure(model) for model in models})

    def each(self, figure: Callable[[Value], Other]) -> "ByModel[Other]":
        """Return another figure of the same models, computed from this one."""
        return self.by_name(lambda model: figure(self.of(model)))


def names_of(figures: Iterable[ByModel[Any]]) -> tuple[ModelName, ...]:
    """Return the models to compare where figures of several fits stand together."""
    return MODELS[: 2 + any(row.geometric is not None for row in figures)]


class MetricsByModel(ByModel[Metrics]):
    """Errors by each model."""

    ball_refitted: Metrics | None = None
    """By the nominal model with only the ball's place on the flange fitted."""

    @property
    def before(self) -> Metrics:
        """By the nominal model, its ball refitted where that is known."""
        return self.ball_refitted or self.nominal


def mean_by_model(rows: Sequence[MetricsByModel]) -> dict[str, Metrics | None]:
    """Return the means of some rows by each model that any of them has."""
    means: dict[str, Metrics | None] = dict.fromkeys((*MODELS, "ball_refitted"))
    for name in names_of(rows):
        means[name] = mean_metrics([row.of(name) for row in rows])
    refitted = [row.ball_refitted for row in rows if row.ball_refitted is not None]
    return means | ({"ball_refitted": mean_metrics(refitted)} if refitted else {})
