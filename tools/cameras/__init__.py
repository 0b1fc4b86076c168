"""Views of a board: from images, and from poses of the flange, to joint positions."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
