"""The report of a calibration: :mod:`figures` works out the numbers, :mod:`page` shows them."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
