"""Robots to joint states: drivers that only read, and the contract that they keep."""

from .._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
