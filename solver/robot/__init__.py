"""What a robot is: its chain of joints as a URDF describes it, its kinematics, its parameters."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
