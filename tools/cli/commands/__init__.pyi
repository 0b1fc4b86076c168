# keep: open_emulator
from .emulate import open_emulator as open_emulator
