"""Figures of a report: all that follows from a calibration, nothing about its looks."""

from ...._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
