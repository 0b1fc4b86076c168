from .model_selection import JOINT_NOISE as JOINT_NOISE
from .model_selection import Prior as Prior
from .model_selection import Selected as Selected
from .model_selection import select_models as select_models
