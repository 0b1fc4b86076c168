# keep: EMULATORS, open_emulator
from .robots import EMULATORS as EMULATORS
from .robots import open_emulator as open_emulator
