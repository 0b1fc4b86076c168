"""Sessions of ``mukca record`` on a simulated Panda, as commands."""

import math
import random
import time
from dataclasses import dataclass

import numpy as np
from terminal_session import MUKCA

import mukca

PANDA_HOME = (0.0, -0.3, 0.0, -2.0, 0.0, 1.8, 0.7)


def configurations(count, seed=0):
    """Configurations of a Panda, within its limits and well apart."""
    generator = random.Random(seed)
    return [[q + generator.uniform(-0.6, 0.6) for q in PANDA_HOME] for _ in range(count)]


def command(hand, out, *more, mock=""):
    """Without a guide, which is a program of its own beside it: test_guided.py has that."""
    driver = f"mock:{hand}?rate=1000&hold=2.5&move=0.7{mock}"
    words = ["record", "--robot", "panda", "--driver", driver, "--out", str(out), "--no-guide"]
    words += ["--distance", "0.05"]
    return [*MUKCA, *words, *more]


def fast(hand, out):
    driver = f"mock:{hand}?rate=250&speed=8&hold=0.65&move=0.6"
    return [*MUKCA, "record", "--robot", "panda", "--driver", driver, "--out", str(out)]


def read(folder):
    """Return the one placement in a folder."""
    (placement,) = mukca.read_placements(folder)
    return placement


@dataclass
class Done:
    """What a command came to."""

    status: int
    output: str
    errors: str


def assert_true(positions, truth, states):
    """Each position is one of the true ones, within six deviations of the averaged noise."""
    away = np.abs(positions[:, None, :] - np.array(truth)[None]).max(axis=2).min(axis=1)
    assert np.all(away < 6 * 2e-5 / math.sqrt(states))


def capture(terminal, key, *shown, called="space"):
    """Press a key while the arm is still, and again where a busy computer was too late for it."""
    press = f"PRESS: {called} captures"
    groups = [shown, ("! refused", press)]
    terminal.wait_for(press)
    while True:
        time.sleep(0.5)
        terminal.press(key)
        if terminal.wait_for_either(*groups) == shown:
            return
