"""States are read in a thread of their own: none waits for a busy consumer, none is lost."""

import time

import pytest

from mukca.drivers import Driver, DriverError, Reason, Reconnecting, open_driver
from mukca.recorder.stream import Stream


@pytest.fixture
def arm(tmp_path):
    """Open a simulated arm with some options."""
    file = tmp_path / "hand.csv"
    file.write_text("0.1,0.2")
    return lambda options: open_driver("mock", f"{file}?{options}")


def test_a_busy_consumer_gets_every_state_in_order(arm):
    """In real time: a thread reads while this one sleeps."""
    stream = Stream(arm("rate=1000&buffer=600"))
    taken, looked = [], []
    while len(taken) < 1000:
        time.sleep(0.15)  # a screen that takes its time
        now = time.monotonic()
        taken += stream.take()
        looked += [now] * (len(taken) - len(looked))
    stream.close()
    stamps = [round(state.stamp * 1000) for _, state, _ in taken]
    assert stamps == list(range(len(taken))) and stream.missed == 0
    arrivals = [arrival for arrival, _, _ in taken]
    assert arrivals == sorted(arrivals)
    early = sum(arrival < when for arrival, when in zip(arrivals, looked, strict=True))
    assert early > 0.9 * len(taken)  # they arrived when they came, not when they were taken


def test_what_no_one_takes_is_dropped_from_its_old_end_and_counted(arm, virtual_time):
    stream = Stream(arm("rate=1000"), capacity=50)
    virtual_time.sleep(0.2)
    stream.close()
    taken = stream.take()
    assert len(taken) == 50 and stream.dropped > 100
    assert round(taken[0][1].stamp * 1000) == stream.dropped == stream.missed


def test_states_tell_over_which_connection_they_came(arm, virtual_time):
    stream = Stream(Reconnecting(lambda: arm("rate=100&fault=drop@0.3+0.2")))
    virtual_time.sleep(3.0)
    assert stream.drops == 1
    taken = stream.take()
    stream.close()
    assert [state.stamp >= 0.5 for _, state, _ in taken] == [lost == 1 for _, _, lost in taken]
    assert {lost for _, _, lost in taken} == {0, 1}


class Broken(Driver):
    """Fails in a way that no driver should."""

    def __init__(self, error):
        self.error = error
        self.closed = False

    @property
    def joint_names(self):
        return ("a",)

    def read(self, timeout):
        raise self.error

    def close(self):
        self.closed = True


@pytest.mark.parametrize("error", [ZeroDivisionError("oops"), DriverError(Reason.PROTOCOL, "oops")])
def test_a_driver_that_fails_is_told_and_closed(error, virtual_time):
    driver = Broken(error)
    stream = Stream(driver)
    virtual_time.sleep(0.1)
    assert stream.ended and driver.closed and "oops" in str(stream.trouble)
    stream.close()
