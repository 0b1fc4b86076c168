"""The core: what the fit of one robot to its measurements needs, and nothing else."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
