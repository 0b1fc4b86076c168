"""Addresses: what they stand for, and what is said of those that stand for nothing."""

import pytest
from cases import by_table
from driver_errors import refused

from mukca import open_driver


@by_table("address", "told")
def test_a_host_its_port_and_options_are_taken_apart(address, told):
    with refused("UNREACHABLE", match=told):
        open_driver("franka", address)


NONSENSE = {
    "damiao": [f"virtual/x?{word}" for word in
               ("ids=0", "ids=1,16", "ids=a", "signs=1,1", "signs=2", "rate=0")],
    "feetech": ["", "?arm=so101", *(f"/dev/null?{word}" for word in
                ("arm=koch", "ids=1,1", "ids=1,254", "signs=1,1,1", "signs=1,1,1,1,2",
                 "zeros=a,b,c,d,e", "baud=quick", "rate=0", "calibration=/no/such/file",
                 "spedd=1"))],
    "franka": ["", ":80", "host:port", "host:99999", "host:-1", "host/path", "user@host",
               "host?version", "host?versoin=4", "host?version=4&x=1", "[::1", "host?version=4;1",
               *(f"127.0.0.1:9?version={word}" for word in ("2", "11", "99999", "-1", "x"))],
    "kinova": ["", "/dev/ttyUSB0", "usb://1", "serial://", "serial:///dev/null?parity=maybe",
               "serial:///dev/null?baud=quick", "serial:///dev/null?spedd=1", "can://can0?tx=one",
               "kortex://", "kortex://host?rate=0"],
    "piper": ["/can0", "virtual/", "can0?baud=5", "nothing_such/can0"],
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "address"), [(n, a) for n, each in NONSENSE.items() for a in each]
)
def test_addresses_that_mean_nothing(name, address):
    with refused("BAD_ADDRESS") as caught:
        open_driver(name, address)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "fast"])
def test_a_rate_is_a_positive_number(text):
    with refused("BAD_ADDRESS", match=f"rate={text} is not a positive number"):
        open_driver("ur", f"host?rate={text}")


def test_an_option_that_is_not_known_names_those_that_are():
    with refused("BAD_ADDRESS", match="there are: rate, effort"):
        open_driver("ur", "host?speed=1")


@pytest.mark.parametrize(
    ("address", "bus"),
    [
        ("no_such_can", "socketcan/no_such_can"),
        ("slcan//dev/no_such_port?bitrate=1000000", "slcan//dev/no_such_port"),
    ],
)
def test_a_can_bus_that_is_not_there_says_how_to_bring_it_up(address, bus):
    with refused("UNREACHABLE", match=f"CAN bus {bus} .*ip link set can0 up"):
        open_driver("piper", address)
