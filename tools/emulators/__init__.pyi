from .arm import replay_arm as replay_arm
from .arm import wandering_arm as wandering_arm
from .emulator import Emulator as Emulator
from .emulator import Journal as Journal
from .fault_injection import KINDS as KINDS
from .fault_injection import FaultInjector as FaultInjector
