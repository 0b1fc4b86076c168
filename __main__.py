"""The program ``mukca``, also started as ``python -m mukca``."""

import signal
import sys
from types import FrameType

INTERRUPTED = 130
"""Exit status after Ctrl-C, as of shells."""


def run() -> int:
    """Run the command line, and return its exit status.

    Ctrl-C ends it with 130, also while modules are still loaded. Any exception but those that the
    command line tells is a defect of mukca: it ends with 70, and :func:`report_defect` tells it.
    """
    interrupts: list[int] = []

    def interrupt(number: int, _: FrameType | None) -> None:
        interrupts.append(number)
        raise KeyboardInterrupt

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, interrupt)
    try:
        from .tools.cli import main

        return main()
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception as error:
        if (
            interrupts
        ):  # Ctrl-C while a compiled module is loaded may come out as another error
            return INTERRUPTED
        from .tools.cli import report_defect

        return report_defect(error, sys.argv[1:])


if __name__ == "__main__":
    sys.exit(run())
