"""One thing fitted, the calibrated chain held: joint zeros, a tool, a camera, what changed."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
