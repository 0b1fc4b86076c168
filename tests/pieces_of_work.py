"""Pieces of work for tests of workers, in a module that other processes can import."""

import os
import signal
import time


def square(number):
    return number * number


def square_after_one_death(marker, number):
    """The first process that comes by 3 dies of it."""
    if number == 3:
        try:
            marker.touch(exist_ok=False)
        except FileExistsError:
            return 9
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number


def die(_):
    os.kill(os.getpid(), signal.SIGKILL)


def refuse(number):
    raise ValueError(f"no {number}")


def say_who_and_sleep(folder, number):
    """Leave one's process number there, and be busy for long."""
    (folder / f"{os.getpid()}.pid").touch()
    time.sleep(60)
    return number


def blocked_signals(_):
    return signal.pthread_sigmask(signal.SIG_BLOCK, [])
