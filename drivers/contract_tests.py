"""The contract of a driver as tests, to be run on any driver. Needs pytest, when imported."""

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import islice, pairwise

import pytest

from . import clock
from .driver import Driver, DriverError, JointNames, JointState, Reason

Sent = Callable[[], Sequence[JointState]]
"""Returns all states that a robot has sent until now, in order."""

STATES = 50
PAUSE_SECONDS = 0.3
READ_SECONDS = 60.0  # patience with a busy computer
SOON_SECONDS = 30.0
OPEN_SECONDS = 60.0


def _read(driver: Driver, count: int) -> list[JointState]:
    """Return so many states."""
    return [driver.read(READ_SECONDS) for _ in range(count)]


class DriverContract:
    """The contract that every driver keeps.

    That angles are in radians and no state is lost can be seen only where it is known what was
    sent. A simulator knows: give its states by ``sent``, and by ``lossy`` those of one that loses
    some. It should take no position twice: the states could not be told apart.
    """

    driver: type[Driver]
    """The class under test."""

    joints: int
    """Number of the robot's joints."""

    model: Sequence[str] | None = None
    """Joint names of the robot's model, where the driver matches them with the robot's own."""

    nobody: str | None = None
    """An address at which nothing answers; the test is skipped without one."""

    wrong: str | None = None
    """An address that cannot be understood; the test is skipped without one."""

    tolerance: float = 1e-6
    """Largest difference between a position and the one that was sent [rad]."""

    keeps_all: bool = True
    """False for a driver that cannot return the states that came while nobody read."""

    @pytest.fixture
    def address(self) -> str:
        """Address of the robot, or of its simulator; to be overridden."""
        raise NotImplementedError("give an address fixture")

    @pytest.fixture
    def sent(self) -> Sent | None:
        """Function that returns the states that the robot has sent, where that is known."""
        return None

    @pytest.fixture
    def lossy(self) -> tuple[str, Sent] | None:
        """Address of a robot whose messages are lost now and then, and the states it has sent."""
        return None

    @pytest.fixture
    def opened(self, address: str) -> Iterator[Driver]:
        """The driver, connected without a model."""
        with self.driver(address) as driver:
            yield driver

    def names(self) -> JointNames:
        """Return the joint names of a model of the robot."""
        return tuple(
            self.model or (f"arm_joint_{index}" for index in range(self.joints))
        )

    def test_names_each_joint(self, opened: Driver) -> None:
        """Without a model the driver names the joints, each differently."""
        assert isinstance(opened.joint_names, tuple)
        assert len(set(opened.joint_names)) == self.joints
        assert all(name and isinstance(name, str) for name in opened.joint_names)

    def test_takes_the_models_names(self, address: str) -> None:
        """With a model the joints are the model's, in its order."""
        with self.driver(address, self.names()) as driver:
            assert driver.joint_names == self.names()
            assert len(driver.read(READ_SECONDS).position) == self.joints

    def test_streams_states_in_order(self, opened: Driver) -> None:
        """Stamps grow from state to state."""
        stamps = [state.stamp for state in _read(opened, STATES)]
        assert all(first < second for first, second in pairwise(stamps))
        assert stamps[-1] - stamps[0] < 600, "stamps are in seconds"

    def test_states_are_whole(self, opened: Driver) -> None:
        """A state has a finite number for each joint, and efforts for all joints or for none."""
        states = _read(opened, STATES)
        for state in states:
            for values in (state.position, state.effort or state.position):
                assert isinstance(values, tuple)
                assert len(values) == self.joints
                assert all(
                    isinstance(value, float) and math.isfinite(value)
                    for value in values
                )
        assert len({state.effort is None for state in states}) == 1

    def test_positions_move_as_an_arm_can(self, opened: Driver) -> None:
        """No joint jumps by more than half a radian from one state to the next."""
        for first, second in pairwise(_read(opened, STATES)):
            pairs = zip(first.position, second.position, strict=True)
            assert all(abs(a - b) < 0.5 for a, b in pairs)

    def test_states_are_those_that_were_sent(
        self, opened: Driver, sent: Sent | None
    ) -> None:
        """Positions and efforts are what the robot sent: in SI units, in order, none made up."""
        if sent is None:
            pytest.skip("nobody knows what was sent")
        states = _read(opened, STATES)
        truths = sent()
        assert any(any(truth.position) for truth in truths), (
            "an arm at zero proves nothing"
        )
        for state, place in zip(states, self._places(states, truths), strict=True):
            if state.effort and truths[place].effort:
                assert state.effort == pytest.approx(truths[place].effort, abs=1e-3)

    def test_a_late_reader_loses_nothing(
        self, opened: Driver, sent: Sent | None
    ) -> None:
        """States that come while nobody reads are returned afterwards, the oldest first."""
        if sent is None or not self.keeps_all:
            pytest.skip("nobody knows what was sent, or the driver cannot keep it")
        states, missed = self._read_with_a_pause(opened)
        assert missed == 0
        self._assert_complete(states, sent(), missed)

    def test_counts_what_was_missed(self, lossy: tuple[str, Sent] | None) -> None:
        """Each state that was sent is returned or counted as missed."""
        if lossy is None:
            pytest.skip("no robot that loses states")
        with self.driver(lossy[0]) as driver:
            states, missed = self._read_with_a_pause(driver)
            assert missed > 0, "nothing was lost; let the simulator lose more"
            self._assert_complete(states, lossy[1](), missed)

    def test_counts(self, opened: Driver) -> None:
        """Missed and rejected messages are counted, and the status is text."""
        opened.read(READ_SECONDS)
        assert isinstance(opened.missed, int)
        assert isinstance(opened.rejected, int)
        assert min(opened.missed, opened.rejected) >= 0
        assert isinstance(opened.status, str)

    def test_keeps_its_timeout(self, opened: Driver) -> None:
        """A read that gets no state in time says SILENT, soon, and the next one may succeed."""
        start = clock.now()
        for _ in range(3):
            try:
                opened.read(timeout=0.0)
            except DriverError as error:
                assert error.reason is Reason.SILENT
        assert clock.now() - start < SOON_SECONDS
        assert opened.read(READ_SECONDS).position

    def test_iterates(self, opened: Driver) -> None:
        """A driver is an iterator over its states."""
        assert len(list(islice(opened, 3))) == 3

    def test_closes_for_good(self, address: str) -> None:
        """Closing twice does no harm, and a closed driver gives no state."""
        driver = self.driver(address)
        driver.read(READ_SECONDS)
        driver.close()
        driver.close()
        with pytest.raises(DriverError) as caught:
            for _ in range(1000):
                driver.read(0.1)
        assert caught.value.reason is not Reason.SILENT

    def test_opens_again(self, address: str) -> None:
        """A robot whose connection was closed can be connected to again at once."""
        identities = set[str]()
        for _ in range(2):
            with self.driver(address) as driver:
                assert driver.read(READ_SECONDS).position
                identities.add(driver.identity)
        assert len(identities) == 1

    def test_refuses_another_robots_model(self, address: str) -> None:
        """A model with another number of joints is refused."""
        with pytest.raises(DriverError) as caught:
            self.driver(address, (*self.names(), "one_too_many"))
        assert caught.value.reason is Reason.WRONG_ROBOT
        with self.driver(address) as driver:
            assert driver.read(READ_SECONDS).position, (
                "the refused driver left the robot free"
            )

    def test_says_that_nobody_answers(self) -> None:
        """It is said within seconds that nothing answers at an address."""
        if self.nobody is None:
            pytest.skip("no address at which nothing answers")
        start = clock.now()
        with pytest.raises(DriverError) as caught:
            self.driver(self.nobody)
        assert caught.value.reason in (Reason.UNREACHABLE, Reason.BUSY)
        assert clock.now() - start < OPEN_SECONDS

    def test_says_that_an_address_is_wrong(self) -> None:
        """It is said in one line that an address cannot be understood."""
        if self.wrong is None:
            pytest.skip("no address that cannot be understood")
        with pytest.raises(DriverError) as caught:
            self.driver(self.wrong)
        assert caught.value.reason is Reason.BAD_ADDRESS
        assert "\n" not in str(caught.value)

    def _read_with_a_pause(self, driver: Driver) -> tuple[list[JointState], int]:
        """Return states, and how many the driver missed from the first to the last of them."""
        states = [driver.read(READ_SECONDS)]
        before = driver.missed
        states += _read(driver, STATES)
        clock.sleep(PAUSE_SECONDS)
        states += _read(driver, 2 * STATES)
        return states, driver.missed - before

    def _assert_complete(
        self, states: Sequence[JointState], truths: Sequence[JointState], missed: int
    ) -> None:
        """See that between the first and the last state none is unaccounted for."""
        places = self._places(states, truths)
        unread = places[-1] - places[0] + 1 - len(states)
        assert unread == missed, (
            f"{unread} states were sent and not returned, {missed} counted"
        )

    def _places(
        self, states: Sequence[JointState], truths: Sequence[JointState]
    ) -> list[int]:
        """Return the index of each state among those that were sent, after the one before."""
        places: list[int] = []
        for state in states:
            start = places[-1] + 1 if places else 0
            for place in range(start, len(truths)):
                pairs = zip(state.position, truths[place].position, strict=True)
                if all(abs(a - b) <= self.tolerance for a, b in pairs):
                    places.append(place)
                    break
            else:
                raise AssertionError(f"{state} was never sent, or before the last one")
        return places
