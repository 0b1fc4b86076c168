"""Explanations of what was recorded, one noun a file, compared by their evidence."""

from ...._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
