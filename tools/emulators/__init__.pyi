from .arm import KINDS as KINDS
from .arm import FaultInjector as FaultInjector
from .arm import emulated_arm as emulated_arm
from .emulator import Emulator as Emulator
from .emulator import Journal as Journal
