"""Joint states to recordings: the session at the robot, and the files it writes."""

from .._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
