"""The paper's method (``--method paper``): Eq. (5), which fits the geometry alone."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
