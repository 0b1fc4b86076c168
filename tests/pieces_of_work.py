"""Pieces of work for tests of workers, in a module that other processes can import."""

import os
import signal
import time
from pathlib import Path


def square(number: int) -> int:
    return number * number


def square_after_one_death(marker: Path, number: int) -> int:
    """The first process that comes by 3 dies of it."""
    if number == 3:
        try:
            marker.touch(exist_ok=False)
        except FileExistsError:
            return 9
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number


def die(_: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def refuse(number: int) -> None:
    raise ValueError(f"no {number}")


def say_who_and_sleep(folder: Path, number: int) -> int:
    """Leave one's process number there, and be busy for long."""
    (folder / f"{os.getpid()}.pid").touch()
    time.sleep(60)
    return number
