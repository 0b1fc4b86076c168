"""The verbs of the command line, one module each."""

import argparse
from typing import Protocol

from .console import Terminal


class Command(Protocol):
    """What a module in ``tools/commands`` offers."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Add the verb's arguments, and an example as the parser's epilog."""
        ...

    def run(self, arguments: argparse.Namespace, terminal: Terminal) -> int:
        """Do the work and return the exit status.

        Raises:
            MukcaError: What is wrong with the input, in one line.
        """
        ...
