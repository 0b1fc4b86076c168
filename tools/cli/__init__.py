"""The command line: arguments, console, tables; one verb a file in ``commands``."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
