"""Addresses: what they stand for, and what is said of those that stand for nothing."""

import pytest

from mukca.drivers import DriverError, Reason
from mukca.drivers.transport import open_bus, parse_can_address, parse_endpoint, resolve


@pytest.mark.parametrize(
    ("address", "expected"),
    [
        ("172.16.0.2", ("172.16.0.2", 1337, {})),
        ("robot.local:99", ("robot.local", 99, {})),
        ("10.0.0.1?version=4", ("10.0.0.1", 1337, {"version": "4"})),
        ("10.0.0.1:5?version=4", ("10.0.0.1", 5, {"version": "4"})),
    ],
)
def test_endpoints(address, expected):
    endpoint = parse_endpoint(address, 1337, ("version",))
    assert (endpoint.host, endpoint.port, endpoint.options) == expected


@pytest.mark.parametrize(
    "address",
    ["", ":80", "host:port", "host:99999", "host:-1", "host/path", "user@host", "host?version",
     "host?versoin=4", "host?version=4&x=1", "[::1", "host?version=4;1"],
)  # fmt: skip
def test_addresses_that_mean_nothing(address):
    with pytest.raises(DriverError) as caught:
        parse_endpoint(address, 1337, ("version",)).options.integer("version", 0)
    assert caught.value.reason is Reason.BAD_ADDRESS
    assert "\n" not in str(caught.value)


def test_an_option_that_is_not_known_names_those_that_are():
    with pytest.raises(DriverError, match="there are: rate, effort"):
        parse_endpoint("host?speed=1", 1, ("rate", "effort"))


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "fast"])
def test_a_rate_is_a_positive_number(text):
    options = parse_endpoint(f"host?rate={text}", 1, ("rate",)).options
    with pytest.raises(DriverError, match=f"rate={text} is not a positive number"):
        options.positive("rate", 100)


def test_a_host_that_nobody_knows():
    with pytest.raises(DriverError) as caught:
        resolve("no-such-robot.invalid")
    assert caught.value.reason is Reason.UNREACHABLE


@pytest.mark.parametrize(
    ("address", "interface", "channel"),
    [
        ("", "socketcan", "can0"),
        ("can1", "socketcan", "can1"),
        ("slcan//dev/ttyACM0?bitrate=1000000", "slcan", "/dev/ttyACM0"),
        ("pcan/PCAN_USBBUS1", "pcan", "PCAN_USBBUS1"),
    ],
)
def test_can_buses(address, interface, channel):
    bus = parse_can_address(address)
    assert (bus.interface, bus.channel) == (interface, channel)


@pytest.mark.parametrize("address", ["/can0", "virtual/", "can0?baud=5", "nothing_such/can0"])
def test_can_buses_that_are_none(address):
    with pytest.raises(DriverError) as caught:
        open_bus(parse_can_address(address))
    assert caught.value.reason is Reason.BAD_ADDRESS


def test_a_can_bus_that_is_not_there_says_how_to_bring_it_up():
    with pytest.raises(DriverError, match="ip link set can0 up") as caught:
        open_bus(parse_can_address("no_such_can"))
    assert caught.value.reason is Reason.UNREACHABLE
