# keep: EMULATORS, open_emulator
from .emulate import EMULATORS as EMULATORS
from .emulate import open_emulator as open_emulator
