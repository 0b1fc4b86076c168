"""From recordings to a calibrated robot: what a robot is, what was measured, and two methods."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
