"""Controllers that speak their real bytes on loopback, each a program of its own.

An emulator moves a simulated arm and sends what the real controller sends, at its rate. It
shares no table of the wire format with the adapter that reads it, notes all that it receives,
and misbehaves on demand. What none of them models: the arm's physics, and the network's delay.
"""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
