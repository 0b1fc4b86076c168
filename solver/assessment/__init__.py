"""The one judge: prediction errors, limits, what a verdict rests on, and the verdict."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
