from .map_estimate import estimate as estimate
from .map_estimate import estimate_all as estimate_all
from .posterior import JointPosterior as JointPosterior
from .posterior import Posterior as Posterior
