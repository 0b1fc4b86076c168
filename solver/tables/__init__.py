"""Lengths, coordinates and left-out samples, as files and words give them."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
