"""``mukca record --stops``: a hand leads each joint to both of its stops, once."""

import math
from collections.abc import Iterator
from functools import partial

from ...drivers import (
    Driver,
    DriverError,
    JointState,
    Reason,
    Reconnecting,
    open_driver,
)
from ...errors import fixed
from ...recorder import STOPS, StopFinder, Stops, follow_to_stops
from ...solver.calibration import UsageError
from ...solver.identification.robot import Robot
from ..cli import Terminal
from .options import RecordOptions

PAUSE = 15.0
"""The session ends once the arm has rested for so long [s]."""
READ_SECONDS = 0.5
LED = math.radians(20)
"""Range through which a joint that is led to its stops turns [rad]."""


def record_stops(options: RecordOptions, robot: Robot, terminal: Terminal) -> int:
    """Write what each joint reads at its stops."""
    file = options.out / STOPS
    if file.exists():
        raise UsageError(
            f"{file} is there already: name another folder, or put it away"
        )
    joints = robot.joint_names
    terminal.say_at_once(
        "Lead each joint to both of its stops, and hold it there for a second, as gently as you "
        f"can. The session ends when the arm has rested for {PAUSE:.0f} s."
    )
    connect = partial(open_driver, options.driver, None, joints)
    finder = StopFinder(joints)
    led: set[str] = set()
    with Reconnecting(connect, joint_names=joints) as driver:
        for finder in follow_to_stops(_states(driver), joints, PAUSE):
            spans = zip(joints, finder.upper - finder.lower, strict=True)
            news = [joint for joint, span in spans if span > LED and joint not in led]
            led.update(news)
            if news:
                terminal.say_at_once(f"{', '.join(news)} moves")
    if not led:
        raise UsageError(
            f"--stops: no joint was led through {math.degrees(LED):.0f} degrees"
        )
    stops = finder.stops(options.driver)
    stops.write(options.out)
    terminal.say(*_lines(stops), f"Wrote {file}")
    return 0


def _states(driver: Driver) -> Iterator[JointState]:
    """Yield states as they come; a silent connection is made again."""
    while True:
        try:
            yield driver.read(READ_SECONDS)
        except DriverError as error:
            if error.reason is not Reason.SILENT:
                raise


def _lines(stops: Stops) -> Iterator[str]:
    """Yield what each joint read at its stops, in degrees."""
    for joint, ends in stops.ranges.items():
        low, high = [fixed(math.degrees(end), 2, "+") for end in ends]
        note = "; its reading jumped by a whole turn" * (joint in stops.wrapped)
        yield f"{joint}: {low} to {high} deg{note}"
