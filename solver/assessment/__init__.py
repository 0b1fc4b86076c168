"""The one judge: prediction errors, limits, what a verdict rests on, and the verdict."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
