"""A connection that is lost is made again, and whatever cannot be mended is said at once."""

import pytest
from driver_errors import refused

from mukca.drivers import Driver, DriverError, JointState, Reason, Reconnecting, clock

pytestmark = pytest.mark.usefixtures("virtual_time")


class Scripted(Driver):
    """Does one thing after the other: a state for True, an error for its reason."""

    def __init__(self, acts, names=("a",), missed=0):
        self.acts = list(acts)
        self.names = names
        self.missed = self.rejected = missed
        self.closed = 0

    @property
    def joint_names(self):
        return self.names

    def read(self, timeout):
        act = self.acts.pop(0)
        if isinstance(act, Reason):
            raise DriverError(act, f"it is {act.value}")
        return JointState(0.0, (1.0,))

    def close(self):
        self.closed += 1


class Robot:
    """Hands out connections, or refuses them."""

    def __init__(self, *connections):
        self.connections = list(connections)
        self.attempts = []

    def __call__(self):
        self.attempts.append(clock.now())
        connection = self.connections.pop(0)
        if isinstance(connection, Reason):
            raise DriverError(connection, f"it is {connection.value}")
        return connection


def test_the_first_connection_must_succeed():
    with pytest.raises(DriverError, match="busy"):
        Reconnecting(Robot(Reason.BUSY))


@pytest.mark.parametrize("reason", [Reason.UNREACHABLE, Reason.BUSY, Reason.PROTOCOL])
def test_a_drop_is_told_and_mended(reason):
    first, second = Scripted([True, reason], missed=3), Scripted([True], missed=4)
    driver = Reconnecting(Robot(first, second), first_wait=0.0)
    driver.read(1.0)
    with refused("SILENT", match=reason.value):
        driver.read(1.0)
    assert driver.trouble and first.closed == 1
    driver.read(1.0)
    assert driver.drops == 1 and driver.trouble is None
    assert driver.missed == driver.rejected == 7


def test_attempts_become_rarer():
    robot = Robot(Scripted([Reason.UNREACHABLE]), *[Reason.UNREACHABLE] * 4, Scripted([True]))
    driver = Reconnecting(robot, first_wait=0.05, longest_wait=0.2)
    while True:
        try:
            driver.read(0.02)
        except DriverError as error:
            assert error.reason is Reason.SILENT
        else:
            break
    waits = [b - a for a, b in zip(robot.attempts[1:], robot.attempts[2:], strict=False)]
    assert all(wait >= least for wait, least in zip(waits, (0.1, 0.2, 0.2, 0.2), strict=True))
    assert driver.drops == 1


def test_a_short_silence_keeps_the_connection_and_a_long_one_ends_it():
    first = Scripted([True, Reason.SILENT, Reason.SILENT])
    driver = Reconnecting(Robot(first, Scripted([True])), first_wait=0.0, silence=0.1)
    driver.read(1.0)
    with pytest.raises(DriverError):
        driver.read(0.01)
    assert first.closed == 0
    clock.sleep(0.12)
    with pytest.raises(DriverError, match=r"it is silent; silent for 0\.\d s"):
        driver.read(0.01)
    assert first.closed == 1 and driver.drops == 1
    driver.read(1.0)


@pytest.mark.parametrize("reason", [Reason.BAD_ADDRESS, Reason.MISSING_PACKAGE, Reason.WRONG_ROBOT])
def test_what_cannot_be_mended_is_raised(reason):
    driver = Reconnecting(Robot(Scripted([Reason.UNREACHABLE]), reason), first_wait=0.0)
    with pytest.raises(DriverError):
        driver.read(0.1)
    with pytest.raises(DriverError, match=reason.value) as caught:
        driver.read(0.1)
    assert caught.value.reason is reason


def test_another_robot_at_the_address_is_refused():
    other = Scripted([True], names=("x", "y"))
    driver = Reconnecting(Robot(Scripted([Reason.UNREACHABLE]), other), first_wait=0.0)
    with pytest.raises(DriverError):
        driver.read(0.1)
    with refused("WRONG_ROBOT", match="another robot answers: its joints are x, y"):
        driver.read(0.1)
    assert other.closed == 1


@pytest.mark.parametrize(
    ("first", "second", "goes_on"), [("A1", "A1", 1), ("A1", "B2", 0), ("", "B2", 1), ("A1", "", 1)]
)
def test_another_arm_of_the_kind_is_not_gone_on_with(first, second, goes_on):
    """It is told by what the driver says of it; of one that says nothing nothing is known."""
    lost, again = Scripted([Reason.UNREACHABLE]), Scripted([True])
    lost.identity, again.identity = first, second
    driver = Reconnecting(Robot(lost, again), first_wait=0.0)
    with pytest.raises(DriverError):
        driver.read(0.1)
    if goes_on:
        assert driver.read(0.1).position == (1.0,) and driver.identity == first
        return
    with refused("WRONG_ROBOT", match=f"another robot answers: its marks are {second}, not"):
        driver.read(0.1)
    assert again.closed == 1


def test_joints_in_another_order_are_put_into_the_model_s():
    class Arm(Scripted):
        def read(self, timeout):
            return JointState(0.0, (1.0, 2.0, 3.0), (10.0, 20.0, 30.0))

    driver = Reconnecting(Robot(Arm([], names=("c", "a", "b"))), joint_names=["a", "b", "c"])
    state = driver.read(1.0)
    assert driver.joint_names == ("a", "b", "c") and not driver.remark
    assert (state.position, state.effort) == ((2.0, 3.0, 1.0), (20.0, 30.0, 10.0))


def test_joints_with_other_names_are_taken_in_order_and_told():
    driver = Reconnecting(Robot(Scripted([True], names=("x",))), joint_names=["a"])
    assert driver.read(1.0).position == (1.0,)
    assert "the driver's joints are x; the model's a" in driver.remark


@pytest.mark.parametrize("names", [("b", "x"), ("a", "b", "x")])
def test_joints_that_are_the_model_s_in_part_are_refused(names):
    arm = Scripted([True], names=names)
    with refused("WRONG_ROBOT", match="choose the model of this robot"):
        Reconnecting(Robot(arm), joint_names=["a", "b"])
    assert arm.closed == 1


def test_a_closed_connection_stays_closed():
    first = Scripted([True])
    driver = Reconnecting(Robot(first))
    driver.close()
    driver.close()
    assert first.closed == 1
    with pytest.raises(DriverError, match="closed"):
        driver.read(0.1)
