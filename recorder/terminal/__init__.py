"""A recording session in the terminal: loop, keys, key scripts and screen."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
