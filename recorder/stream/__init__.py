"""The live stream of joint states: read in a thread, checked, watched for a still arm."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
