"""The default method (``--method auto``): MAP estimation with priors set by the evidence.

docs/model.md is its introduction; its equations are the order in which to read ``model``,
``inference``, ``selection`` and ``results``.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
