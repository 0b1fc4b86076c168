# keep: Base, Imperfection, NOISE, TRANSLATION, TURN, measured_points, perturb, random_pose
# keep: reachable_bases, realistic_flaws, record, recorded_by_both, sockets_seen
from .demo import DEMO_SEED as DEMO_SEED
from .demo import SEAT_NOISE as SEAT_NOISE
from .demo import demo_arm as demo_arm
from .demo import demo_bases as demo_bases
from .demo import simulate_hand as simulate_hand
from .recordings import Base as Base
from .recordings import reachable_bases as reachable_bases
from .recordings import record as record
from .recordings import simulate_recordings as simulate_recordings
from .simulated_arms import NOISE as NOISE
from .simulated_arms import TRANSLATION as TRANSLATION
from .simulated_arms import TURN as TURN
from .simulated_arms import Imperfection as Imperfection
from .simulated_arms import perturb as perturb
from .simulated_arms import realistic_flaws as realistic_flaws
from .simulated_worlds import measured_points as measured_points
from .simulated_worlds import random_pose as random_pose
from .simulated_worlds import recorded_by_both as recorded_by_both
from .simulated_worlds import sockets_seen as sockets_seen
