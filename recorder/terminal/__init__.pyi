from .display import Lines as Lines
from .display import Screen as Screen
from .key_bindings import keys_with as keys_with
from .key_script import Script as Script
from .keyboard import Keyboard as Keyboard
from .record import Outcome as Outcome
from .record import Recorder as Recorder
from .screen import render as render
