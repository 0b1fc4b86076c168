"""Many arms at once: one folder an arm, each calibrated by its own recordings."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
