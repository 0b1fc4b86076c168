"""The program ``mukca``, also started as ``python -m mukca``."""

import os
import signal
import sys
from types import FrameType

INTERRUPTED = 130
"""Exit status after Ctrl-C, as of shells."""


def run() -> int:
    """Run the command line, and return its exit status.

    Ctrl-C ends it with 130, also while modules are still loaded. Any exception but those that the
    command line tells is a defect of mukca: it ends with 70, and :func:`report_defect` tells it.
    No module is loaded from the current folder, which may be a stranger's.
    """
    os.environ["PYTHONSAFEPATH"] = "1"  # of the processes that it starts
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
    folder = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))  # noqa: PTH100, PTH120
    if sys.path[0] in ("", os.getcwd()) and sys.path[0] != folder:  # noqa: PTH109
        del sys.path[0]
    sys.exit(run())
