"""Content of ``elasticity.json``: what arms of one type have in common."""

from typing import Literal

from . import estimates
from .files import Document

ELASTICITY_FORMAT = "mukca-elasticity-1"


class TypeElasticity(Document):
    """Of one type: the mean over arms, each weighted by its precision."""

    joint_names: tuple[str, ...]
    """A type is told by its joints' names, in chain order."""
    arms: int
    coefficients: tuple[estimates.Coefficient, ...]
    """Compliance and tilt [rad/(N m)]; the deviation is that of the mean."""
    source: str | None = None
    """Source of the figures, if mukca did not find them."""
    tilt_axes: Literal["frame", "link"] = "frame"
    """Axes of the tilts: those of the joints' frames, as in files of 1.0, or of the links."""


class ElasticityDocument(Document):
    """All of ``elasticity.json``."""

    format: str
    types: tuple[TypeElasticity, ...]
