"""Bases of drivers for robots: a subclass connects and decodes, and the base checks every state."""

import math
from abc import abstractmethod
from collections import deque
from collections.abc import Generator, Iterable
from contextlib import contextmanager

from . import clock
from .driver import Driver, DriverError, JointNames, JointState, JointValues, Reason

AHEAD = 2.0
"""A stamp may be further ahead of this computer's clock than any before it, by this much [s]."""
LARGEST_STAMP = 1e10
"""No clock has counted more seconds than these, some 300 years [s]."""
USELESS = 100
"""So many bad messages and no good one: this is another robot, or none."""


class ValidatingDriver(Driver):
    """A driver whose states are checked.

    A state has a finite position for each joint, a finite effort for each joint or for none, and a
    stamp that is later than the one before and not far ahead of this computer's clock. Others are
    thrown away and counted in :attr:`Driver.rejected`: one bad message costs itself, never the
    connection. A subclass has

    * a constructor, which calls this one, connects, and sets ``_joint_names``;
    * :meth:`_receive`, which returns the next state as it came;
    * :meth:`_disconnect`.

    Args:
        where: The robot as messages name it, as in ``"the robot at 172.16.0.2:1337"``.
        period: Time between two states [s], where a gap between two stamps tells the number of
            states that were missed; None where a gap tells nothing, or the subclass counts.
    """

    def __init__(self, where: str, period: float | None = None) -> None:
        self._where = where
        self._period = period
        self._joint_names: JointNames = ()
        self._closed = False
        self._unread: JointState | None = None
        self._asked = 0.0
        """Time at which a state was last asked for [s]."""
        self._proven, self._useless = False, 0
        self._begin_anew()

    @property
    def joint_names(self) -> JointNames:
        """The robot's joints, from base to flange: the model's names where there is a model."""
        return self._joint_names

    @abstractmethod
    def _receive(self, deadline: float) -> JointState:
        """Wait for the next state and return it unchecked.

        Args:
            deadline: Time at which to give up, by :func:`.clock.now` [s]; a state that has come by
                then is returned even if the time is up.

        Raises:
            ValueError: What came is no state. It is counted, and this is called again.
            DriverError: SILENT when no state came in time; any other reason when the connection
                is of no more use, which is then ended.
        """

    @abstractmethod
    def _disconnect(self) -> None:
        """End the connection, however much of it there is; called once."""

    def read(self, timeout: float) -> JointState:
        """Return the next state that holds what it must; see :meth:`Driver.read`."""
        if self._unread and not self._closed:
            state, self._unread = self._unread, None
            return state
        return self._next(clock.now() + timeout)

    def close(self) -> None:
        """End the connection; safe to call twice."""
        if not self._closed:
            self._closed = True
            self._disconnect()

    def _count_rejected(self) -> None:
        self.rejected += 1

    @contextmanager
    def _closed_on_error(self) -> Generator[None]:
        """Guard the part of a constructor that follows the first thing that is to be closed."""
        try:
            yield
        except BaseException:
            self.close()
            raise

    def _await_first(self, seconds: float, advice: str = "") -> JointState:
        """Wait for the first state in a constructor; :meth:`read` returns it once more.

        With advice to who waits in vain, silence is UNREACHABLE.
        """
        try:
            self._unread = self._next(clock.now() + seconds)
        except DriverError as error:
            if not advice or error.reason is not Reason.SILENT:
                raise
            raise Reason.UNREACHABLE(f"{error}: {advice}") from None
        return self._unread

    def _silence(
        self, deadline: float, kind: str = "state", advice: str = ""
    ) -> DriverError:
        """Return the error for a time up to a deadline in which nothing came."""
        waited = max(0.0, deadline - self._asked)
        return Reason.SILENT(f"no {kind} from {self._where} for {waited:.3g} s{advice}")

    def _begin_anew(self) -> None:
        """Compare the next stamp with none before it: the robot's clock may start again."""
        self._last_stamp = -math.inf
        self._lead: float | None = None
        """Time by which the robot's clock is ahead of the host's [s]."""
        self._begun = clock.now()

    def _next(self, deadline: float) -> JointState:
        try:
            return self._next_good(deadline)
        except DriverError as error:
            if error.reason is not Reason.SILENT:
                self.close()
            raise

    def _next_good(self, deadline: float) -> JointState:
        bad = ""
        while not self._closed:
            try:
                self._asked = clock.now()
                state = self._receive(deadline)
                # A state has a number for each joint.
                count = len(self._joint_names or state.position)
                efforts = state.position if state.effort is None else state.effort
                for values, name in (
                    (state.position, "positions"),
                    (efforts, "efforts"),
                ):
                    if len(values) != count:
                        raise ValueError(
                            f"a state with {len(values)} {name} for {count} joints"
                        )
                    require_finite(values, f"a state with {name}")
                self._check_stamp(state.stamp)
                self._proven = True
                return state
            except ValueError as error:
                bad = str(error)
                self._count_rejected()
                self._useless += not self._proven
                if self._useless >= USELESS:
                    raise Reason.PROTOCOL(f"{self._where} sends {bad}") from None
            except DriverError as error:
                if bad and error.reason is Reason.SILENT:
                    raise Reason.SILENT(f"{self._where} sends {bad}") from None
                raise
            if clock.now() > deadline:
                raise Reason.SILENT(f"{self._where} sends {bad}")
        raise Reason.UNREACHABLE("the connection is closed")

    def _check_stamp(self, stamp: float) -> None:
        """See that time goes on, and count what was missed."""
        if not abs(stamp) < LARGEST_STAMP:  # false for NaN too
            raise ValueError(
                f"a state with the stamp {stamp:g} s, which no clock shows"
            )
        if stamp <= self._last_stamp:
            raise ValueError("a state that is not later than the one before")
        lead = stamp - (clock.now() if self._lead is not None else self._begun)
        if self._lead is not None and lead > self._lead + AHEAD:
            raise ValueError(
                f"a state that is {lead - self._lead:.3g} s ahead of its time"
            )
        self._lead = lead if self._lead is None else max(lead, self._lead)
        if self._period and math.isfinite(self._last_stamp):
            self.missed += max(0, round((stamp - self._last_stamp) / self._period) - 1)
        self._last_stamp = stamp


def require_finite(values: Iterable[float], what: str) -> None:
    """Refuse a message whose values are no numbers; a ValueError begins with what it is."""
    if not all(map(math.isfinite, values)):
        raise ValueError(f"{what} that are no numbers")


def require_angles(position: Iterable[float], largest: float, what: str) -> None:
    """Refuse a message with an angle that no joint has [rad]; a ValueError begins with it."""
    if not all(abs(angle) <= largest for angle in position):  # false for NaN too
        raise ValueError(f"{what} with impossible joint angles")


class PolledDriver(ValidatingDriver):
    """A driver whose robot sends a state only when it is asked for one."""

    def __init__(self, where: str) -> None:
        super().__init__(where)
        self._next_poll = 0.0
        """Time of the next request, by :func:`.clock.now` [s]; set by the subclass as it asks."""

    def _await_turn(self, deadline: float, interval: float = 0.0) -> float:
        """Wait until it is time to ask; return that, and ask again no sooner than an interval [s].

        Raise SILENT when it is after the deadline.
        """
        if self._next_poll > deadline:
            clock.sleep(clock.left(deadline))
            raise self._silence(deadline)
        clock.sleep(clock.left(self._next_poll))
        start = clock.now()
        self._next_poll = start + interval
        return start


LATEST = 3.0
"""Time within which returns are counted [s]."""
RETURNS = 5
"""So many returns within it are no single faults."""
FAR = 0.05
"""A smaller step to another state and back is noise [rad], [m]."""
NEAR = 0.2
"""A return ends as near to where it began as this share of the step between."""

TWO_SOURCES = "two sources send these joints in turn"


class SourceDetector:
    """Counts the returns of a stream, fed state by state.

    A return is a state that equals the one before the last, which was far from both. No arm moves
    so, but the states of two sources that are merged do.
    """

    def __init__(self) -> None:
        self._before: deque[JointValues] = deque(maxlen=2)
        self._returns: deque[float] = deque()

    @property
    def two_sources(self) -> bool:
        """True while the states are of two sources."""
        return len(self._returns) >= RETURNS

    def feed(self, state: JointState) -> None:
        """Take in a state, sound or not."""
        stamps = self._returns
        while stamps and not 0 <= state.stamp - stamps[0] < LATEST:
            stamps.popleft()
        if len(self._before) == 2:
            first, last = self._before
            step = _distance(last, state.position)
            if step > FAR and _distance(first, state.position) < NEAR * step:
                stamps.append(state.stamp)
        self._before.append(state.position)


def _distance(a: JointValues, b: JointValues) -> float:
    """Return the largest difference of two positions without whole turns, or NaN."""
    if a == b:
        return 0.0
    differences = [y - x for x, y in zip(a, b, strict=False)]
    if not all(map(math.isfinite, differences)):
        return math.nan
    return max((abs(math.remainder(d, math.tau)) for d in differences), default=0.0)
