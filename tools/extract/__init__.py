"""From logs of joint states, such as bags, to recordings: one module a kind of log."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
