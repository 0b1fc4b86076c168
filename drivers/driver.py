"""The contract of every driver: it streams a robot's joint states, and it only reads.

It never sends a motion, torque, zeroing or parameter command. When it cannot go on it raises
:class:`DriverError`, whose :class:`Reason` says what to do next.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from types import TracebackType

from ..errors import MukcaError, fixed

JointNames = tuple[str, ...]
ModelNames = Sequence[str] | None
"""Names of a model's actuated joints, in chain order; None where no model is at hand."""
JointValues = tuple[float, ...]
"""A number for each joint, in the order of their names."""


class Reason(Enum):
    """Reason for which a driver cannot deliver."""

    UNREACHABLE = "unreachable"
    """Nothing answers at the address: look at cable, power, network, firewall."""
    BUSY = "busy"
    """Another program holds the robot: close it."""
    WRONG_MODE = "wrong mode"
    """The robot is in a mode in which this driver must not, or cannot, listen."""
    SILENT = "silent"
    """Connected, but no state came in time: read again."""
    PROTOCOL = "protocol"
    """The bytes that came cannot be decoded."""
    WRONG_ROBOT = "wrong robot"
    """The robot has other joints than the model."""
    BAD_ADDRESS = "bad address"
    """The address cannot be understood."""
    MISSING_PACKAGE = "missing package"
    """A Python package that this driver needs is not installed."""

    def __call__(self, message: str) -> "DriverError":
        """Return the error for this reason, to be raised; the message is for people."""
        return DriverError(self, message)


class DriverError(MukcaError):
    """A driver cannot deliver joint states; the message says why, and what would work.

    Attributes:
        reason: The kind of trouble, for programs; the message is for people.
    """

    def __init__(self, reason: Reason, message: str) -> None:
        super().__init__(message)
        self.reason = reason


@dataclass(frozen=True, slots=True, repr=False)
class JointState:
    """Positions and efforts of a robot's joints at one moment.

    A robot sends some 100 to 1000 of these a second.
    """

    stamp: float
    """Time of measurement [s], by the controller's clock, or by the host's monotonic clock where
    the controller sends no time. Only differences have a meaning."""

    position: JointValues
    """Joint positions in the order of the driver's joint names [rad], [m] for a prismatic joint."""

    effort: JointValues | None = None
    """Torque that each joint exerts on the links beyond it [N m], force [N] for a prismatic joint.
    While the arm rests it equals the gravity torque. None where the robot does not measure it."""

    def __repr__(self) -> str:
        position = ", ".join(fixed(value, 4) for value in self.position)
        effort = "" if self.effort is None else ", with effort"
        return f"JointState({self.stamp:.3f} s: {position}{effort})"


class Driver(ABC):
    """A connection to one robot: opened by its constructor, ended by :meth:`close`.

    It is a context manager, and an iterator over all states until the caller stops::

        with open_driver("franka:172.16.0.2") as driver:
            state = driver.read(timeout=1.0)

    Args:
        address: The robot's address in the driver's own notation; may be empty where the driver
            has a sensible default.
        joint_names: Names of the model's actuated joints, in chain order. None where no model
            is at hand: the driver then names the joints itself.

    Raises:
        DriverError: The connection cannot be made, or the robot has other joints than the model.
    """

    missed: int = 0
    """Number of states that the robot sent and that did not arrive, by its own counting."""

    rejected: int = 0
    """Number of messages that were thrown away: malformed, late, or from another host."""

    resolution: float = 0.0
    """Smallest step of a position [rad]; 0 where it is finer than any noise."""

    status: str = ""
    """Mode and errors of the robot, in words; empty if it tells none."""

    identity: str = ""
    """What this robot has and others of its kind may not have, such as a serial number, in words;
    empty if its protocol does not tell. It is the same at each connection."""

    @abstractmethod
    def __init__(self, address: str, joint_names: ModelNames = None) -> None: ...

    @property
    @abstractmethod
    def joint_names(self) -> JointNames:
        """Names of the joints, in the order of :attr:`JointState.position`."""

    @abstractmethod
    def read(self, timeout: float) -> JointState:
        """Wait for the next state and return it.

        States come in order and each comes once: those that arrived while nobody read are
        returned first, none is skipped to be up to date.

        Args:
            timeout: Longest wait [s].

        Returns:
            The next state, with a position for each of :attr:`joint_names`.

        Raises:
            DriverError: SILENT when no state came in time; reading again may succeed. With any
                other reason the connection is of no more use.
        """

    @abstractmethod
    def close(self) -> None:
        """End the connection; safe to call twice."""

    def __enter__(self) -> "Driver":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __iter__(self) -> Iterator[JointState]:
        while True:
            yield self.read(timeout=1.0)

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}({len(self.joint_names)} joints, missed {self.missed}, "
            f"rejected {self.rejected})"
        )


def match_joints(joint_names: ModelNames, count: int, robot: str) -> JointNames:
    """Return the names of a robot's joints: the model's if there is one, else joint1, joint2, ...

    Args:
        joint_names: The model's actuated joints in chain order, or None without a model.
        count: Number of the robot's joints.
        robot: The robot as the message names it, as in ``"a UR arm"``.

    Raises:
        DriverError: WRONG_ROBOT when the model has another number of joints.
    """
    if joint_names is None:
        return tuple(f"joint{index}" for index in range(1, count + 1))
    if len(joint_names) != count:
        raise Reason.WRONG_ROBOT(
            f"{robot} has {count} joints, but the model has {len(joint_names)} "
            f"({', '.join(joint_names)}); choose the model of this robot"
        )
    return tuple(joint_names)
