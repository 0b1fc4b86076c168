"""From recordings to a calibrated robot: what a robot is, what was measured, and two methods."""

from .._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
