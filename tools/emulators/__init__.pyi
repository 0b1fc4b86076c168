# keep: all that ends in Emulator, for mukca emulate
from .arm import KINDS as KINDS
from .arm import FaultInjector as FaultInjector
from .arm import emulated_arm as emulated_arm
from .can_arms import DamiaoEmulator as DamiaoEmulator
from .can_arms import KinovaEmulator as KinovaEmulator
from .can_arms import PiperEmulator as PiperEmulator
from .emulator import Emulator as Emulator
from .emulator import Journal as Journal
from .servos import DynamixelEmulator as DynamixelEmulator
from .servos import FeetechEmulator as FeetechEmulator
from .tcp_arms import UrEmulator as UrEmulator
from .tcp_arms import XArmEmulator as XArmEmulator
from .udp_arms import FrankaEmulator as FrankaEmulator
from .udp_arms import KukaEmulator as KukaEmulator
