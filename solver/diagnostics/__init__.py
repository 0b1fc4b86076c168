"""Diagnostics of recordings: one check a file, each with its evidence and its words."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
