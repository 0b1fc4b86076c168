"""Plots of a report, one kind a file: data in, figure out."""

from ...._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
