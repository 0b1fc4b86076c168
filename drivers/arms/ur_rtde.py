"""Universal Robots through the package ur-rtde, whose receive interface is polled.

The interface keeps the latest state alone. A state that comes while nobody looks is lost; it is
counted as missed. :mod:`mukca.drivers.arms.ur` reads the same stream and loses none. It goes first:
ur-rtde waits for a controller that is mute for ever, and lets nothing else run meanwhile.

Address: ``HOST[?rate=HZ]``. Efforts are None: these arms measure no torque in N m.
"""

from collections.abc import Sequence

from .. import DriverError, JointState, Reason, ValidatingDriver, clock, match_joints
from ..transport import parse_endpoint
from .rtde import OUTPUTS, check_angles, status_text
from .ur import FAST, JOINTS, PORT, Ur

POLL_SECONDS = 2e-4
FIRST_STATE_SECONDS = 1.0
BY_CONTROLLER = -1.0  # Hz: 500 of an e-series, 125 of a CB3


class UrRtde(ValidatingDriver):
    """A UR arm that ur-rtde reads."""

    def __init__(self, address: str, joint_names: Sequence[str] | None = None) -> None:
        try:
            from rtde_receive import RTDEReceiveInterface
        except ImportError:
            raise DriverError(
                Reason.MISSING_PACKAGE,
                "ur-rtde is not installed (pip install ur-rtde; Python 3.10 to 3.12 on "
                "Linux, x86-64): install it, or read the arm by --driver ur",
            ) from None
        endpoint = parse_endpoint(address, PORT, options=("rate",))
        if endpoint.port != PORT:
            raise DriverError(Reason.BAD_ADDRESS, f"ur-rtde knows port {PORT} alone: {endpoint}")
        super().__init__(f"the robot at {endpoint}")
        rate = endpoint.options.positive("rate", FAST) if "rate" in endpoint.options else None
        self._joint_names = match_joints(joint_names, JOINTS, "a UR arm")
        with (reader := Ur(address)):
            reader.read(FIRST_STATE_SECONDS)
            self._period = 1 / reader.rate
        try:
            self._robot = RTDEReceiveInterface(endpoint.host, rate or BY_CONTROLLER, [*OUTPUTS])
        except RuntimeError as error:
            raise DriverError(
                Reason.BUSY, f"{self._where} took the connection, but not ur-rtde: {error}"
            ) from None
        self._polled = 0.0

    def _receive(self, deadline: float) -> JointState:
        while True:
            stamp, position = self._robot.getTimestamp(), self._robot.getActualQ()
            modes = self._robot.getRobotMode(), self._robot.getSafetyMode()
            if stamp != self._polled and self._robot.getTimestamp() == stamp:  # of one state
                self._polled = stamp
                self.status = status_text(*modes)
                return JointState(stamp, check_angles(position))
            if not self._robot.isConnected():
                raise DriverError(Reason.UNREACHABLE, f"{self._where} ended the connection")
            if clock.now() >= deadline:
                raise DriverError(Reason.SILENT, f"no state from {self._where}")
            clock.sleep(POLL_SECONDS)

    def _disconnect(self) -> None:
        self._robot.disconnect()
