"""The types of ``calibration.json``, and reading and writing files."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
