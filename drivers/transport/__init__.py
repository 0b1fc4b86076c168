"""Transports: addresses, TCP, UDP, serial lines and CAN buses."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
