"""The paper's method (``--method paper``): Eq. (5), which fits the geometry alone."""

from ...._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
