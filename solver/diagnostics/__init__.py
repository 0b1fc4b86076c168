"""Diagnostics of recordings: one check a file, each with its evidence and its words."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
