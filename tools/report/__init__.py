"""The report of a calibration: :mod:`figures` has its numbers, :mod:`plots` draws them."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
