"""``mukca record``: setup of a session, guidance of the operator, and the page beside the arm."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
