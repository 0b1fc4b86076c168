"""The parts that a calibration needs, made from a few parameters and ready to print.

A socket base, and a ball on a mount for the arm. Unlike everywhere else, lengths in here are
millimetres: parts are drawn, printed and measured in them, and their files hold them. The command
line takes and gives metres, but for options that say ``-mm``.
"""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
