from .simulated_arms import Base as Base
from .simulated_arms import perturb as perturb
from .simulated_arms import record as record
from .simulated_arms import simulate_recordings as simulate_recordings
from .simulated_worlds import recorded_by_both as recorded_by_both
