"""The contract of every robot adapter: it streams joint states, and it only reads.

An adapter connects, decodes, and yields :class:`JointState`. It never sends a motion, torque,
zeroing or parameter command. What it cannot do it says with :class:`DriverError`, whose
:class:`Reason` tells a program (and a person) what to do next::

    UNREACHABLE       nothing answers at the address: cable, power, network, firewall
    BUSY              another program holds the robot: close it
    WRONG_MODE        the robot is in a state in which this adapter must not, or cannot, listen
    SILENT            connected, but no state came in time: the caller may read again
    PROTOCOL          what came is not what this adapter can decode
    WRONG_ROBOT       another number of joints, or other joint names, than the model has
    BAD_ADDRESS       the address cannot be understood
    MISSING_PACKAGE   the adapter needs a Python package that is not installed
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from types import TracebackType

from .. import MukcaError

__all__ = ["Driver", "DriverError", "JointState", "Reason", "match_joints"]


class Reason(Enum):
    """Why an adapter cannot deliver; the module's docstring says what each means."""

    UNREACHABLE = "unreachable"
    BUSY = "busy"
    WRONG_MODE = "wrong mode"
    SILENT = "silent"
    PROTOCOL = "protocol"
    WRONG_ROBOT = "wrong robot"
    BAD_ADDRESS = "bad address"
    MISSING_PACKAGE = "missing package"


class DriverError(MukcaError):
    """An adapter cannot deliver joint states.

    Attributes:
        reason: What kind of trouble it is, for programs; the message is for people.
    """

    def __init__(self, reason: Reason, message: str) -> None:
        super().__init__(message)
        self.reason = reason


@dataclass(frozen=True, slots=True)
class JointState:
    """What the robot's joints are at one moment."""

    stamp: float
    """Time of measurement [s]: the controller's clock where it gives one, else the host's
    monotonic clock. Only differences have a meaning."""

    position: tuple[float, ...]
    """Joint positions in the model's order [rad], [m] for a prismatic joint."""

    effort: tuple[float, ...] | None = None
    """What each joint exerts on the arm beyond it [N m] ([N] for a prismatic joint), at rest
    equal to the gravity torque; None where the robot does not measure it."""


class Driver(ABC):
    """A connection to one robot, opened by its constructor and ended by :meth:`close`.

    A context manager, and an iterator over all states until the caller stops::

        with open_driver("franka", "172.16.0.2", joint_names) as driver:
            state = driver.read(timeout=0.1)

    Args:
        address: Where the robot is, in the adapter's own notation; may be empty where the
            adapter has a sensible default.
        joint_names: Names of the model's actuated joints, in chain order. None where no model
            is at hand: the adapter then names the joints itself.

    Raises:
        DriverError: The connection cannot be made.
    """

    missed: int = 0
    """How many states the robot sent that did not arrive, by its own sequence numbers."""

    rejected: int = 0
    """How many messages were thrown away: malformed, late, or from another host."""

    status: str = ""
    """What the robot says of itself, its mode and its errors, in words; empty if nothing."""

    @abstractmethod
    def __init__(self, address: str, joint_names: Sequence[str] | None = None) -> None: ...

    @property
    @abstractmethod
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in the order of :attr:`JointState.position`."""

    @abstractmethod
    def read(self, timeout: float) -> JointState:
        """Return the next state that has not been returned yet, in order, waiting for it.

        Args:
            timeout: How long to wait at most [s].

        Raises:
            DriverError: SILENT when no state came within the timeout (reading again may
                succeed); any other reason when the connection is of no more use.
        """

    @abstractmethod
    def close(self) -> None:
        """End the connection; safe to call twice."""

    def _count_rejected(self) -> None:
        self.rejected += 1

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


def match_joints(joint_names: Sequence[str] | None, count: int, robot: str) -> tuple[str, ...]:
    """Return the names of a robot's joints: the model's if there is one, else ``joint1``...

    Args:
        joint_names: The model's actuated joints, or None without a model.
        count: How many joints the robot has.
        robot: What the robot is, for the message.

    Raises:
        DriverError: WRONG_ROBOT when the model has another number of joints.
    """
    if joint_names is None:
        return tuple(f"joint{index}" for index in range(1, count + 1))
    if len(joint_names) != count:
        raise DriverError(
            Reason.WRONG_ROBOT,
            f"{robot} has {count} joints, but the model has {len(joint_names)} "
            f"({', '.join(joint_names)}); choose the model of this robot",
        )
    return tuple(joint_names)
