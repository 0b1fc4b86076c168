"""The physical effects that extend the geometry, one a file; :mod:`.table` lists them."""

from ...._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
