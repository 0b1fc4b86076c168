# keep: Base, Imperfection, perturb, reachable_bases, record
from .practice import DEMO_SEED as DEMO_SEED
from .practice import SEAT_NOISE as SEAT_NOISE
from .practice import Session as Session
from .practice import SessionFault as SessionFault
from .practice import demo_arm as demo_arm
from .practice import demo_bases as demo_bases
from .practice import practice_driver as practice_driver
from .practice import simulate_hand as simulate_hand
from .practice import with_faults as with_faults
from .recordings import Base as Base
from .recordings import lead as lead
from .recordings import reachable_bases as reachable_bases
from .recordings import record as record
from .recordings import simulate_recordings as simulate_recordings
from .recordings import truth_of as truth_of
from .simulated_arms import Imperfection as Imperfection
from .simulated_arms import perturb as perturb
