"""What ``elasticity.json`` holds: how far joints and links of types of arms give way."""

from .calibration import Coefficient
from .files import Document

FORMAT = "mukca-elasticity-1"


class TypeElasticity(Document, kw_only=True, frozen=True):
    """Of one type: the mean over arms, each weighted by its precision."""

    joint_names: tuple[str, ...]
    """A type is told by its joints' names, in chain order."""
    arms: int
    coefficients: tuple[Coefficient, ...]
    """Compliance and tilt [rad/(N m)]; the deviation is that of the mean."""
    source: str | None = None
    """Where the figures are from, where mukca did not find them."""


class ElasticityDocument(Document, kw_only=True, frozen=True):
    """All of ``elasticity.json``."""

    format: str
    types: tuple[TypeElasticity, ...]
