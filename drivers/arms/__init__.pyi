from .hand_guided_motion import Motion as Motion
from .simulated import SimulatedArm as SimulatedArm
