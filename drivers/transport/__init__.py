"""Transports: addresses, TCP, UDP, serial lines and CAN buses."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
