"""The parts that a calibration needs, made from a few parameters and ready to print.

A socket base, and a ball on a mount for the arm. Unlike everywhere else, lengths in here are
millimetres: parts are drawn, printed and measured in them, and their files hold them. The command
line takes and gives metres, but for options that say ``-mm``.
"""

from .anchor import ARMS, AnchoredBase
from .ball import BEND_LIMIT, FORCE, BallPart
from .design_rules import PrintableError
from .formats import FORMATS, encode
from .mounts import MOUNTS, SCREWS, BoltCircle, Grip
from .parts import Part, build_parts, part_names
from .socket_base import SocketBase

__all__ = [
    "ARMS",
    "BEND_LIMIT",
    "FORCE",
    "FORMATS",
    "MOUNTS",
    "SCREWS",
    "AnchoredBase",
    "BallPart",
    "BoltCircle",
    "Grip",
    "Part",
    "PrintableError",
    "SocketBase",
    "build_parts",
    "encode",
    "part_names",
]
