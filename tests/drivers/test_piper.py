"""AgileX Piper: frames, and turns of three of them."""

import math
import struct
import threading

import can
import pytest
from cases import by_table
from terminal_session import PATIENCE

from mukca import open_driver


class Arm:
    """Sends frames 0.1 ms apart, by a clock of its own, so that a busy computer does no harm."""

    def __init__(self, bus):
        self.bus = bus
        self.time = 1000.0

    def __call__(self, *frames):
        """Send frames: 5, 6 and 7 stand for 0x2A5 to 0x2A7, with the turn's number as both angles.

        A number alone is a pause [s].
        """
        for frame in frames:
            if isinstance(frame, float):
                self.time += frame
                continue
            kind, turn = frame
            self.send(0x2A0 + kind, struct.pack(">ii", turn * 1000, turn * 1000))

    def send(self, identifier, data):
        self.time += 1e-4
        self.bus.send(
            can.Message(self.time, arbitration_id=identifier, data=data, is_extended_id=False)
        )


@pytest.fixture
def arm():
    with can.Bus(interface="virtual", channel="piper", preserve_timestamps=True) as bus:
        yield Arm(bus)


def whole(*turns):
    return [(kind, turn) for turn in turns for kind in (5, 6, 7)]


@pytest.fixture
def driver(arm):
    """Opened while the arm sends the same turn again and again, which it then no more does."""
    opened = threading.Event()

    def send():
        while not opened.wait(0.01):
            arm(*whole(0), 0.004)

    sender = threading.Thread(target=send)
    sender.start()
    try:
        driver = open_driver("piper", "virtual/piper")
    finally:
        opened.set()
        sender.join()
    with driver:
        arm(*whole(90))
        assert set(read_up_to(driver, 90)) == {0, 90}
        yield driver


def read_up_to(driver, last):
    """Return the turns that are read up to one that was sent last."""
    turns = []
    while last not in turns:
        degrees = {round(math.degrees(q)) for q in driver.read(PATIENCE).position}
        assert len(degrees) == 1, "a state mixed from two turns"
        turns.append(degrees.pop())
    return turns


@by_table("frames", "turns", "missed")
def test_a_state_is_one_turn(driver, arm, frames, turns, missed):
    """A pause of 5 s, forwards or back, is a clock that was set."""
    arm(*frames)
    assert read_up_to(driver, turns[-1]) == turns
    assert driver.missed == missed


def test_other_frames_do_no_harm_and_one_that_is_too_short_is_rejected(driver, arm):
    arm((5, 1), (8, 9), (6, 1), (1, 9), (7, 1))
    assert read_up_to(driver, 1) == [1]
    assert (driver.missed, driver.rejected) == (0, 0)
    arm((5, 2))
    arm.send(0x2A6, bytes(4))
    arm((7, 2), *whole(3))
    assert read_up_to(driver, 3) == [3]
    assert (driver.missed, driver.rejected) == (1, 1)
