"""What a calibration will be worth, as ``calibration.json`` and ``report.json`` hold it."""

from ..design import ErrorMap, JointEffect
from .files import Document


class Forecast(Document, kw_only=True, frozen=True):
    """What another placement would bring, if it were trained on too."""

    placement: str | None
    """Its name; None for one that is not recorded yet, with 2 x 30 varied samples far from all."""
    distance_deviation: float
    """The predicted error of distances in the workspace would then be this [m]."""


class Outlook(Document, kw_only=True, frozen=True):
    """What a calibration will be worth."""

    joints: tuple[JointEffect, ...]
    """Which joint matters."""
    map: ErrorMap | None = None
    """None by the paper's method, which does not say."""
    forecasts: tuple[Forecast, ...] = ()
