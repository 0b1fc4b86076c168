# keep: VERBS, build_parser, main, run
from .arguments import MILLIMETRES as MILLIMETRES
from .commands.main import VERBS as VERBS
from .commands.main import build_parser as build_parser
from .commands.main import main as main
from .console import Terminal as Terminal
