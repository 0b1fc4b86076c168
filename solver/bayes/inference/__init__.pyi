from .given_curves import restored_covariance as restored_covariance
from .joint_curves import with_joint_curves as with_joint_curves
from .linear_samples import movement_gain as movement_gain
from .map_estimate import estimate as estimate
from .posterior import JointPosterior as JointPosterior
from .posterior import Posterior as Posterior
