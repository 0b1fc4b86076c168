"""A recording session without a terminal: its state, its actions, its file, its guidance."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
