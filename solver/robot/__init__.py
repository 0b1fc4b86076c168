"""Robots: the kinematic chain of a URDF, its kinematics and its free parameters."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
