"""The physical effects that extend the geometry, one a file; :mod:`.table` lists them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
