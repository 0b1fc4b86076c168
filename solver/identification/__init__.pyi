from .robot_fit import JOINT_NOISE as JOINT_NOISE
from .robot_fit import CurveFit as CurveFit
from .robot_fit import FitOptions as FitOptions
from .robot_fit import Prior as Prior
from .robot_fit import Progress as Progress
from .robot_fit import fit as fit
