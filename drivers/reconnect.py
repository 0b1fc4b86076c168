"""A driver around another driver, which connects again by itself when the connection is lost.

That is, when reading fails, or no state came for two seconds. Until it succeeds it raises SILENT;
what trying again cannot mend (a wrong address, another robot) is raised as it is.
"""

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace

from . import clock
from .driver import Driver, DriverError, JointNames, JointState, ModelNames, Reason

_HOPELESS = frozenset({Reason.BAD_ADDRESS, Reason.MISSING_PACKAGE, Reason.WRONG_ROBOT})

logger = logging.getLogger(__name__)


class Reconnecting(Driver):
    """A connection that is made again whenever it is lost.

    Args:
        connect: Makes a new connection, as in ``lambda: open_driver("ur:192.168.1.10")``.
        first_wait: Time before the first new attempt [s]; it doubles with every failure.
        longest_wait: The most that it grows to [s].
        silence: Time after which a silent connection counts as lost [s].
        joint_names: The model's actuated joints in chain order, if there is a model. A driver that
            names the same joints in another order is put into this one.

    Raises:
        DriverError: The first connection cannot be made, or its joints are the model's in part.
    """

    def __init__(
        self,
        connect: Callable[[], Driver],
        *,
        first_wait: float = 0.25,
        longest_wait: float = 1.0,
        silence: float = 2.0,
        joint_names: ModelNames = None,
    ) -> None:
        self._connect = connect
        self._first_wait, self._longest_wait = first_wait, longest_wait
        self._silence = silence
        self._driver: Driver | None = connect()
        self._names = self._driver.joint_names
        self.remark = ""
        """Remark to the operator on the joints' names; empty where they are the model's."""
        self.resolution = self._driver.resolution
        self.identity = self._driver.identity
        self._earlier_missed = self._earlier_rejected = 0
        self._last_state = clock.now()
        self._wait = first_wait
        self._next_attempt = 0.0
        self._closed = False
        self.drops = 0
        """Number of times that the connection was lost."""
        self.trouble: str | None = None
        """Reason for which no states come, in words; None while they come."""
        self._order = self._matched(joint_names or self._names)

    @property
    def joint_names(self) -> JointNames:
        """Names of the joints, the same for every connection."""
        return tuple(self._names[i] for i in self._order)

    def read(self, timeout: float) -> JointState:
        """Return the next state; making a new connection may take longer than the timeout.

        Raises:
            DriverError: SILENT while there is no state, or no connection; the message says why.
                Another reason when the robot cannot be had again.
        """
        if self._closed:
            raise Reason.UNREACHABLE("the connection is closed")
        driver = self._driver or self._again(timeout)
        try:
            state = self._read(driver, timeout)
        except DriverError as error:
            self._fail(error)
            raise Reason.SILENT(self.trouble or str(error)) from error
        self._last_state = clock.now()
        self.trouble = None
        self._wait = self._first_wait
        driver_order = tuple(range(len(state.position)))
        # Another number of joints is refused later.
        if self._order == driver_order or len(self._order) != len(driver_order):
            return state
        position = tuple(state.position[i] for i in self._order)
        effort = state.effort and tuple(state.effort[i] for i in self._order)
        return replace(state, position=position, effort=effort)

    def _matched(self, joint_names: Sequence[str]) -> tuple[int, ...]:
        """Return where each of the model's joints stands among those of the driver."""
        names = self._names
        model = tuple(joint_names)
        if sorted(names) == sorted(model):
            return tuple(names.index(name) for name in model)
        text = f"the driver's joints are {', '.join(names)}; the model's {', '.join(model)}"
        if len(names) == len(model) and all(
            a == b or a not in model for a, b in zip(names, model, strict=True)
        ):
            self.remark = f"{text}: they are taken in this order"
            return tuple(range(len(names)))
        self.close()
        raise Reason.WRONG_ROBOT(f"{text}; choose the model of this robot")

    def _read(self, driver: Driver, timeout: float) -> JointState:
        """Read a connection, and bring the counts over all connections up to date."""
        try:
            return driver.read(timeout)
        finally:
            self.missed = self._earlier_missed + driver.missed
            self.rejected = self._earlier_rejected + driver.rejected
            self.status = driver.status

    def close(self) -> None:
        """End the connection for good."""
        self._closed = True
        self._drop()

    def _fail(self, error: DriverError) -> None:
        """Take note of a failed read, and drop the connection if it is of no more use."""
        if error.reason is Reason.SILENT:
            silent = clock.now() - self._last_state
            self.trouble = f"{error}; silent for {silent:.1f} s"
            if silent < self._silence:
                return
        else:
            self.trouble = str(error)
        if error.reason in _HOPELESS:
            self.close()
            raise error
        self.drops += 1
        self._drop()
        self._next_attempt = clock.now() + self._wait
        logger.warning("connection lost: %s", self.trouble)

    def _drop(self) -> None:
        driver, self._driver = self._driver, None
        if driver:
            self._earlier_missed, self._earlier_rejected = self.missed, self.rejected
            self.status = ""
            driver.close()

    def _again(self, timeout: float) -> Driver:
        """Connect anew when it is time to, or raise SILENT."""
        pause = self._next_attempt - clock.now()
        clock.sleep(max(0.0, min(pause, timeout)))
        if pause > timeout:
            raise Reason.SILENT(f"{self.trouble}; connecting again")
        try:
            driver = self._connect()
        except DriverError as error:
            if error.reason in _HOPELESS:
                raise
            self._wait = min(2 * self._wait, self._longest_wait)
            self._next_attempt = clock.now() + self._wait
            self.trouble = str(error)
            raise Reason.SILENT(f"{self.trouble}; connecting again") from error
        names = [", ".join(joints) for joints in (driver.joint_names, self._names)]
        identities = [driver.identity, self.identity]
        for kind, (now, before) in ("joints", names), ("marks", identities):
            if now != before and now and before:
                driver.close()
                raise Reason.WRONG_ROBOT(
                    f"another robot answers: its {kind} are {now}, not {before}"
                )
        logger.warning("connected again")
        self._driver = driver
        self._last_state = clock.now()
        return driver
