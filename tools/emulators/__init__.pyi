from .arm import emulated_arm as emulated_arm
from .emulator import Emulator as Emulator
from .emulator import Journal as Journal
from .fault_injection import KINDS as KINDS
from .fault_injection import FaultInjector as FaultInjector
