"""Robots: the kinematic chain of a URDF, its kinematics and its free parameters."""

from ...._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)
