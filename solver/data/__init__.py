"""Measurements: checked placements, known distances, frames, and the error metrics."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
