"""Results of a posterior: uncertainty, what is not identified, geometry for a URDF."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
