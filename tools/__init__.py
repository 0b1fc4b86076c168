"""Programs that people run: the command line, reports, printable parts, simulation."""

from .._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
