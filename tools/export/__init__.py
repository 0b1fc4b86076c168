"""Exports of a calibration for other programs, one format a file."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
