from .map_estimate import estimate as estimate
from .posterior import JointPosterior as JointPosterior
from .posterior import Posterior as Posterior
