"""Addresses: what they stand for, and what is said of those that stand for nothing."""

from cases import by_table
from driver_errors import refused

from mukca import open_driver


@by_table("address", "told")
def test_a_host_its_port_and_options_are_taken_apart(address, told):
    with refused("UNREACHABLE", match=told):
        open_driver("franka", address)


@by_table("name", "address")
def test_addresses_that_mean_nothing(name, address):
    with refused("BAD_ADDRESS") as caught:
        open_driver(name, address)
    assert "\n" not in str(caught.value)


def test_an_option_that_is_not_known_names_those_that_are():
    with refused("BAD_ADDRESS", match="there are: rate, effort"):
        open_driver("ur", "host?speed=1")


@by_table("address", "bus")
def test_a_can_bus_that_is_not_there_says_how_to_bring_it_up(address, bus):
    with refused("UNREACHABLE", match=f"CAN bus {bus} .*ip link set can0 up"):
        open_driver("piper", address)
