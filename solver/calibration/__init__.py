"""The library's face: options, ``calibrate``, ``Calibration``, saving and loading."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
