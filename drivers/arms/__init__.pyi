from .simulated import Mock as Mock
from .simulated import arm_at as arm_at
from .simulated_arm import Fault as Fault
from .simulated_arm import Motion as Motion
from .simulated_arm import SimulatedArm as SimulatedArm
