"""The model: geometry, effects beyond it, noise and priors."""

from ...._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
