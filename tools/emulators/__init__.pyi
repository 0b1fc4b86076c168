from .arm import replay_arm as replay_arm
from .arm import wandering_arm as wandering_arm
from .emulator import Emulator as Emulator
from .emulator import Journal as Journal
from .sabotage import KINDS as KINDS
from .sabotage import Fault as Fault
from .sabotage import FaultInjector as FaultInjector
