"""Kinova's arms: polled actuators over RS-485 and CAN, and Gen3 over Kortex."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
