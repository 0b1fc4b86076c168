"""The paper's experiments, Section IV-B, in MuJoCo: peg insertion and drawing."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
