"""Kinova: Gen2 and JACO actuators over RS-485 or CAN (experimental), Gen3 over Kortex.

Angles jump from 360 to 0 degrees where a joint turns past its zero; such jumps are taken out. The
sign of the torques was not proven. Missed states cannot be counted: answers carry no numbers.

Address: ``serial://PORT?baud=..&parity=..&stopbits=..``, ``can://[INTERFACE/]CHANNEL?tx=..&rx=..``
(ISO-TP through a gateway), or ``kortex://HOST[:PORT]?user=..&password=..``; all take ``rate=HZ``
(100) and ``effort=-1``, which turns the sign of the torques.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

from ... import DriverError, JointState, PolledDriver, Reason, clock, match_joints

HALF_TURN = 180.0
ONE_MOMENT = 0.1  # s: joints that answer within it were measured together, as a hand is slow


@dataclass(frozen=True, slots=True)
class Measurement:
    """An arm's answer: one number for each joint, from base to flange."""

    degrees: tuple[float, ...]
    """Joint angles [degrees]."""
    torques: tuple[float, ...]
    """Joint torques [N m], with the arm's own sign."""


class KinovaArm(ABC):
    """A connection that is asked for the joints again and again."""

    joints: int
    """Number of the arm's joints."""
    sign: int
    """1, or -1 where the torques have the opposite sign of what a state needs."""
    rate: float
    """Rate at which to ask [Hz]."""
    centred: bool = False
    """True where the first angle of each joint is brought between -180 and 180 degrees."""
    rejected: int = 0
    """Number of answers that could not be used."""

    @abstractmethod
    def measure(self, deadline: float) -> Measurement:
        """Ask all joints once; raise SILENT when one does not answer until the deadline [s]."""

    @abstractmethod
    def close(self) -> None:
        """End the connection; safe to call twice."""


class Kinova(PolledDriver):
    """A connection to a Kinova arm, which is asked for its joints again and again."""

    def __init__(self, address: str, joint_names: Sequence[str] | None = None) -> None:
        super().__init__("the Kinova arm")
        self._arm = _connect(address)
        with self._closed_on_error():
            self._joint_names = match_joints(joint_names, self._arm.joints, "the Kinova arm")
        self._unwrap = Unwrap(self._arm.centred)
        self._fastest = math.inf

    def _receive(self, deadline: float) -> JointState:
        self._await_turn(deadline)
        before = self._arm.rejected
        try:
            measurement, stamp = self._measure(deadline)
        finally:
            self.rejected += self._arm.rejected - before
        return JointState(
            stamp,
            self._unwrap(measurement.degrees),
            tuple(self._arm.sign * torque for torque in measurement.torques),
        )

    def _disconnect(self) -> None:
        self._arm.close()

    def _measure(self, deadline: float) -> tuple[Measurement, float]:
        """Ask all joints once; return their answers and the time in the middle [s]."""
        # Joints are asked one after the other. If that takes much longer than the fastest time so
        # far, the computer or the bus was held up, and the arm may have moved: all are asked again.
        while True:
            start = clock.now()
            self._next_poll = start + 1 / self._arm.rate
            measurement = self._arm.measure(deadline)
            end = clock.now()
            if end - start <= max(ONE_MOMENT, 2 * self._fastest):
                self._fastest = min(self._fastest, end - start)
                return measurement, (start + end) / 2
            self._count_rejected()
            self._fastest *= 1.05  # so that a bus that became slower is accepted after a while
            if end >= deadline:
                raise DriverError(Reason.SILENT, f"the joints take {end - start:.2g} s to answer")


class Unwrap:
    """Makes angles continuous that jump by a whole turn, as from 359 to 0 degrees."""

    def __init__(self, centred: bool) -> None:
        self._last: tuple[float, ...] | None = None
        self._centred = centred

    def __call__(self, degrees: Sequence[float]) -> tuple[float, ...]:
        """Return angles [degrees] in radians, each within half a turn of the joint's last one."""
        reference = self._last or ((0.0,) * len(degrees) if self._centred else degrees)
        self._last = tuple(
            angle - 2 * HALF_TURN * round((angle - last) / (2 * HALF_TURN))
            for angle, last in zip(degrees, reference, strict=True)
        )
        return tuple(map(math.radians, self._last))


def _connect(address: str) -> KinovaArm:
    """Open the kind of connection that an address names."""
    scheme, separator, rest = address.partition("://")
    if separator and scheme == "serial":
        from .polled_bus import open_serial

        return open_serial(rest)
    if separator and scheme == "can":
        from .polled_bus import open_can

        return open_can(rest)
    if separator and scheme == "kortex":
        from .kortex import Kortex

        return Kortex(rest)
    raise DriverError(
        Reason.BAD_ADDRESS,
        f"kinova address {address!r}: expected serial://PORT (Gen2, JACO), can://CHANNEL, or "
        "kortex://HOST (Gen3, Gen3 lite)",
    )
