"""Experimental design: how much each further sample or placement would teach."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
