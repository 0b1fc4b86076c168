"""Opening a driver by one string, what addresses mean, and how connections and states print."""

import pytest
from cases import by_table
from driver_errors import refused

from mukca import JointState, MukcaError, open_driver


@pytest.fixture
def hand(tmp_path):
    file = tmp_path / "hand.csv"
    file.write_text("elbow,wrist\n0.1,0.2\n")
    return file


def test_a_driver_is_opened_by_one_string_and_closed_at_the_end(hand):
    with open_driver(f"mock:{hand}?noise=0") as driver:
        assert driver.read(timeout=1.0).position == (0.1, 0.2)
        assert driver.joint_names == ("elbow", "wrist")
    with pytest.raises(MukcaError, match="closed"):
        driver.read(timeout=1.0)


def test_an_address_may_hold_colons_and_may_come_apart(hand):
    with pytest.raises(MukcaError, match=r"127\.0\.0\.1:9 refused"):
        open_driver("ur:127.0.0.1:9")
    with open_driver("mock", str(hand), ("a", "b")) as driver:
        assert driver.joint_names == ("a", "b")


@by_table("text", "says")
def test_what_cannot_be_opened_is_told_in_one_line(text, says):
    with pytest.raises(MukcaError) as caught:
        open_driver(text)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_state_and_a_connection_print_on_one_line(hand):
    assert repr(JointState(1.5, (0.1, -2.0))) == "JointState(1.500 s: 0.1000, -2.0000)"
    assert repr(JointState(0.0, (1.0,), (2.0,))) == "JointState(0.000 s: 1.0000, with effort)"
    with open_driver(f"mock:{hand}") as driver:
        assert repr(driver) == "Mock(2 joints, missed 0, rejected 0)"


@by_table("address", "told")
def test_a_host_its_port_and_options_are_taken_apart(address, told):
    with refused("UNREACHABLE", match=told):
        open_driver("franka", address)


@by_table("name", "address")
def test_addresses_that_mean_nothing(name, address):
    with refused("BAD_ADDRESS") as caught:
        open_driver(name, address)
    assert "\n" not in str(caught.value)


@by_table("address", "bus")
def test_a_can_bus_that_is_not_there_says_how_to_bring_it_up(address, bus):
    with refused("UNREACHABLE", match=f"CAN bus {bus} .*ip link set can0 up"):
        open_driver("piper", address)
