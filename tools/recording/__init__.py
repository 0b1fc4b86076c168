"""``mukca record``: setup of a session, guidance of the operator, and the page beside the arm."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
