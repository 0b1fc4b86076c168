"""Independent work spread over processes or a Dask cluster."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
