from .curve_posterior import restored_covariance as restored_covariance
from .joint_curves import with_joint_curves as with_joint_curves
