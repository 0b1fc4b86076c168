"""Support of ``mukca record``: set-up of the session, pose guidance, outlier checks."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
