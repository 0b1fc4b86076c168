"""States are read in a thread of their own: none waits for a busy consumer, none is lost."""

import time
from collections.abc import Callable

import pytest

from mukca.drivers import Driver, DriverError, JointState, Reason, Reconnecting
from mukca.drivers.arms import Mock, Motion, SimulatedArm
from mukca.drivers.arms.simulated import Fault
from mukca.recorder.stream import Stream


def mock(*faults: str, **options: float) -> Mock:
    faults_ = [Fault.parse(fault) for fault in faults]
    return Mock(arm=SimulatedArm(Motion([[0.1, 0.2]]), faults=faults_, **options))


def wait_until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 20
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_a_busy_consumer_gets_every_state_in_order() -> None:
    stream = Stream(mock(rate=1000.0, buffer=5.0))
    taken: list[JointState] = []
    while len(taken) < 1000:
        time.sleep(0.15)  # a screen that takes its time
        taken += [state for _, state, _ in stream.take()]
    stream.close()
    assert [round(state.stamp * 1000) for state in taken] == list(range(len(taken)))
    assert stream.missed == 0


def test_arrivals_are_when_states_came_not_when_they_were_taken() -> None:
    stream = Stream(mock(rate=100.0))
    wait_until(lambda: stream.waiting > 0)
    time.sleep(0.3)
    now = time.monotonic()
    arrivals = [arrival for arrival, _, _ in stream.take()]
    stream.close()
    assert now - arrivals[0] > 0.25 and arrivals == sorted(arrivals)


def test_what_no_one_takes_is_dropped_from_its_old_end_and_counted() -> None:
    stream = Stream(mock(rate=1000.0, speed=100.0), capacity=50)
    wait_until(lambda: stream.dropped > 100)
    stream.close()
    taken = stream.take()
    assert len(taken) == 50
    assert round(taken[0][1].stamp * 1000) == stream.dropped == stream.missed


def test_silence_is_told_and_ends() -> None:
    stream = Stream(mock("silent@0.1+1"))
    wait_until(lambda: stream.trouble is not None)
    assert "no state" in str(stream.trouble) and not stream.ended
    wait_until(lambda: stream.trouble is None)
    stream.close()


def test_a_driver_that_gives_up_ends_the_stream() -> None:
    stream = Stream(mock("drop@0.1+1"))
    wait_until(lambda: stream.ended)
    assert "dropped the connection" in str(stream.trouble)
    stream.close()
    stream.close()


def test_states_tell_over_which_connection_they_came() -> None:
    arm = SimulatedArm(Motion([[0.1, 0.2]]), rate=100.0, faults=[Fault.parse("drop@0.3+0.2")])
    stream = Stream(Reconnecting(lambda: Mock(arm=arm)))
    wait_until(lambda: stream.drops == 1 and stream.waiting > 40)
    stream.close()
    taken = stream.take()
    assert [state.stamp >= 0.5 for _, state, _ in taken] == [lost == 1 for _, _, lost in taken]
    assert {lost for _, _, lost in taken} == {0, 1}


class Broken(Driver):
    """Fails in a way that no driver should."""

    def __init__(self, error: Exception) -> None:
        self.error = error
        self.closed = False

    @property
    def joint_names(self) -> tuple[str, ...]:
        return ("a",)

    def read(self, timeout: float) -> JointState:
        raise self.error

    def close(self) -> None:
        self.closed = True


@pytest.mark.parametrize("error", [ZeroDivisionError("oops"), DriverError(Reason.PROTOCOL, "oops")])
def test_a_driver_that_fails_is_told_and_closed(error: Exception) -> None:
    driver = Broken(error)
    stream = Stream(driver)
    wait_until(lambda: stream.ended and driver.closed)
    assert "oops" in str(stream.trouble)
    stream.close()
