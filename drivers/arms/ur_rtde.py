"""Universal Robots through the package ur-rtde, in a process of its own.

It waits for a mute controller for ever, and keeps the latest state alone: one that comes while
nobody looks is lost, and counted as missed. :mod:`.ur` loses none; it is asked for the rate first.

Address: ``HOST[?rate=HZ]``. Efforts are None: these arms measure no torque in N m.
"""

import os
import struct
import subprocess
import sys
import time
from importlib.util import find_spec
from typing import IO, cast

from .. import (
    DriverError,
    JointState,
    ModelNames,
    Reason,
    ValidatingDriver,
    clock,
    match_joints,
)
from ..transport import parse_endpoint
from .ur import FAST, JOINTS, OUTPUTS, PORT, Ur, check_angles, status_text

POLL_SECONDS = 2e-4
FIRST_STATE_SECONDS = 10.0  # for a Python to start, too
BY_CONTROLLER = -1.0  # Hz: 500 of an e-series, 125 of a CB3
STATE = struct.Struct("=7d2i")  # stamp, angles, modes: written whole, being so short


class UrRtde(ValidatingDriver):
    """A UR arm that ur-rtde reads."""

    def __init__(self, address: str, joint_names: ModelNames = None) -> None:
        if find_spec("rtde_receive") is None:
            raise Reason.MISSING_PACKAGE(
                "ur-rtde is not installed (pip install ur-rtde; Python 3.10 to 3.12 on "
                "Linux, x86-64): install it, or read the arm by --driver ur"
            )
        endpoint = parse_endpoint(address, PORT, options=("rate",))
        if endpoint.port != PORT:
            raise Reason.BAD_ADDRESS(f"ur-rtde knows port {PORT} alone: {endpoint}")
        super().__init__(f"the robot at {endpoint}")
        rate = (
            endpoint.options.positive("rate", FAST)
            if "rate" in endpoint.options
            else None
        )
        self._joint_names = match_joints(joint_names, JOINTS, "a UR arm")
        with (reader := Ur(address)):
            self._period = 1 / reader.rate
        self._process = subprocess.Popen(  # noqa: S603 - this program, and a host as its argument
            [sys.executable, "-m", __name__, endpoint.host, str(rate or BY_CONTROLLER)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
            cwd=sys.prefix,  # whose modules come first: those of the current folder are not ours
            start_new_session=True,  # Ctrl-C is for this process alone
        )
        self._states = cast(IO[bytes], self._process.stdout).fileno()
        with self._closed_on_error():
            try:
                self._await_first(FIRST_STATE_SECONDS)
            except DriverError as error:
                raise Reason.BUSY(
                    f"{self._where} took the connection, but not ur-rtde's: {error}"
                ) from None

    def _receive(self, deadline: float) -> JointState:
        if not clock.wait([self._states], clock.left(deadline)):
            raise self._silence(deadline)
        if not (data := os.read(self._states, STATE.size)):
            output = (
                cast(IO[bytes], self._process.stderr)
                .read()
                .decode(errors="replace")
                .split("\n")
            )
            why = f": {output[-2]}" if output[1:] else ""
            raise Reason.UNREACHABLE(f"{self._where} ended the connection{why}")
        stamp, *position, robot_mode, safety_mode = STATE.unpack(data)
        self.status = status_text(robot_mode, safety_mode)
        return JointState(stamp, check_angles(position))

    def _disconnect(self) -> None:
        with self._process as process:
            process.kill()


def write_states(host: str, rate: float) -> None:
    """Write states to standard output as they come, until the connection ends."""
    from rtde_receive import RTDEReceiveInterface

    if sys.platform != "win32":
        import fcntl

        # When standard input closes, as by the reader's end, the kernel ends this process.
        fcntl.fcntl(0, fcntl.F_SETOWN, os.getpid())
        fcntl.fcntl(0, fcntl.F_SETFL, os.O_ASYNC)
    states = os.dup(1)
    os.dup2(2, 1)  # the package prints
    robot = RTDEReceiveInterface(host, rate, [*OUTPUTS])
    polled = 0.0
    while True:
        stamp, position = robot.getTimestamp(), robot.getActualQ()
        modes = robot.getRobotMode(), robot.getSafetyMode()
        if stamp != polled and robot.getTimestamp() == stamp:  # of one state
            polled = stamp
            os.write(states, STATE.pack(stamp, *position, *modes))
        elif not robot.isConnected():
            return
        else:
            time.sleep(POLL_SECONDS)


if __name__ == "__main__":
    write_states(sys.argv[1], float(sys.argv[2]))
