"""Joint states as they come: read by a thread, checked, averaged where the arm is still."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
