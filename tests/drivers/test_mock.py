"""The simulated arm: what it streams is what it was given, and it misbehaves as asked."""

from itertools import pairwise

import pytest
from cases import by_table
from driver_errors import refused

from mukca import MukcaError, open_driver

pytestmark = pytest.mark.usefixtures("virtual_time")

FAST = "rate=100&hold=0.5&move=0.5&noise=0&effort_noise=0&speed=20"
"""An arm whose minute passes in three seconds of the computer's clock."""


@pytest.fixture
def arm(tmp_path):
    """Open an arm that goes through configurations with efforts; numbers are its options."""

    def arm(options="", rows="0.1,0.2,0.3,1,1,1"):
        file = tmp_path / "hand.csv"
        joints = len(rows.splitlines()[0].split(",")) // 2
        header = [f"{kind}.{j}" for kind in ("position", "effort") for j in "abc"[:joints]]
        file.write_text(",".join(header) + "\n" + rows + "\n")
        return open_driver("mock", f"{file}?{FAST}{options}")

    return arm


def states(driver, count):
    with driver:
        return [driver.read(5.0) for _ in range(count)]


def test_every_state_comes_once_in_order_along_a_minimum_jerk_path(arm):
    read = states(arm(rows="0,5\n1,7"), 150)
    assert [state.stamp for state in read] == [k / 100 for k in range(150)]
    assert {state.position for state in read[:51]} == {(0.0,)}
    assert read[75].position == pytest.approx((0.5,))
    assert read[75].effort == pytest.approx((6.0,))
    assert {state.position for state in read[100:]} == {(1.0,)}
    steps = [b.position[0] - a.position[0] for a, b in pairwise(read)]
    assert max(steps) == pytest.approx(15 / 8 / 50, rel=1e-2)  # of the mean speed
    assert max(abs(b - a) for a, b in pairwise(steps)) < 6 / 50**2  # no jump of the velocity


def test_states_come_at_the_arm_s_rate(arm, virtual_time):
    begun = virtual_time.now()
    states(arm("&speed=1"), 50)
    assert virtual_time.now() - begun == pytest.approx(0.49, abs=1e-3)


def test_the_noise_is_as_asked_and_the_same_for_a_seed(arm):
    first, second = (states(arm("&noise=1e-3&speed=1e4&seed=3"), 2000) for _ in range(2))
    assert [s.position for s in first] == [s.position for s in second]
    errors = [s.position[0] - 0.1 for s in first]
    assert sum(error**2 for error in errors) / 2000 == pytest.approx(1e-6, rel=0.1)
    assert abs(sum(errors) / 2000) < 1e-4


def test_a_fault_may_affect_a_share_of_the_states_and_have_no_end(arm):
    read = states(arm("&speed=1e4&fault=short:0.3@1+inf"), 1100)
    short = [len(state.position) == 2 for state in read]
    assert not any(short[:100])
    assert 200 < sum(short) < 400


def test_a_dropped_connection_comes_back_to_an_arm_that_went_on(arm, virtual_time):
    fault = "&fault=drop@0.5+10"
    with refused("UNREACHABLE", match="dropped"):
        states(arm(fault), 10000)
    with pytest.raises(MukcaError, match="does not answer"):
        arm(fault)
    virtual_time.sleep(0.6)
    with arm(fault) as again:
        assert again.read(1.0).stamp > 10.4
    with arm(fault) as anew:
        assert anew.read(1.0).stamp == 0.0


@pytest.mark.parametrize("form", ["file", "holes", "samples"])
def test_it_replays_either_form_of_a_recording(tmp_path, form):
    (tmp_path / "hand.csv").write_text("a,b\n0.1,0.2\n0.3,0.4\n")
    if form == "samples":
        (tmp_path / "samples.csv").write_text(
            "socket,position.a,position.b,effort.a,effort.b\n0,0.1,0.2,1,2\n1,0.3,0.4,3,4\n"
        )
    elif form == "holes":
        (tmp_path / "hole_0.csv").write_text("a,b\n0.1,0.2\n")
        (tmp_path / "hole_1.csv").write_text("a,b\n0.3,0.4\n")
    path = tmp_path / "hand.csv" if form == "file" else tmp_path
    with open_driver("mock", f"{path}?{FAST}&rate=10&speed=50") as driver:
        read = [driver.read(1.0) for _ in range(12)]
        assert driver.joint_names == ("a", "b")
    assert (read[0].position, read[-1].position) == ((0.1, 0.2), (0.3, 0.4))
    efforts = (read[0].effort, read[-1].effort)
    assert efforts == (((1.0, 2.0), (3.0, 4.0)) if form == "samples" else (None, None))


@by_table("address", "told")
def test_a_bad_address_is_told(tmp_path, address, told):
    contents = {"file": "1,2\n", "words": "1,2\n1,two\n", "empty": ""}
    files = {name: tmp_path / f"{name}.csv" for name in contents}
    for name, content in contents.items():
        files[name].write_text(content)
    with refused("BAD_ADDRESS", match=told):
        open_driver("mock", address.format(**files))
