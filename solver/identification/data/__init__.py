"""Measurements: checked placements, known distances, frames, and the error metrics."""

from ...._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
