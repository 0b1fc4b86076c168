"""Inverse kinematics of nominal and calibrated arms."""

from ..._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
