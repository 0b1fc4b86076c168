"""Figures of a report: all that follows from a calibration, nothing about its looks."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
