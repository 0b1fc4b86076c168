"""Joint states as they come: read by a thread, checked, averaged where the arm is still."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
