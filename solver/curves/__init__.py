"""Error curves of the joints: their prior, their fit, and whether the data support them."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
