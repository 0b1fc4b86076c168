"""Universal Robots: what is asked for, and a controller that does not play along."""

import math
import struct

import pytest
from driver_errors import read_until_silent, refused
from emulation import emulated
from listeners import rtde_controller, rtde_package, saying

from mukca import MukcaError, open_driver


@pytest.mark.parametrize(("version", "rate"), [("3.15", 125), ("5.11", 500)])
def test_the_rate_is_the_controllers(version, rate, tmp_path):
    with emulated("ur", tmp_path, "--version", version) as emulation:
        with open_driver("ur", emulation.address) as driver:
            states = [driver.read(5) for _ in range(50)]
        assert states[-1].stamp - states[0].stamp == pytest.approx(49 / rate)
        with open_driver("ur", f"{emulation.address}?rate=25") as driver:
            states = [driver.read(5) for _ in range(10)]
            assert driver.missed == 0
        assert states[-1].stamp - states[0].stamp == pytest.approx(9 / 25)


def test_efforts_are_none_unless_an_output_is_asked_for(tmp_path):
    with emulated("ur", tmp_path, "--noise", "0") as emulation:
        with open_driver("ur", emulation.address) as driver:
            assert driver.read(5).effort is None
            assert driver.status == "running, normal"
        with open_driver("ur", f"{emulation.address}?effort=target_moment") as driver:
            state = driver.read(5)
        emulation.stop()
        assert list(state.effort) in [entry["effort"] for entry in emulation.sent().values()]


@pytest.mark.parametrize(
    ("texts", "reason"),
    [
        ((), "BUSY"),
        ((b"SSH-2.0-OpenSSH\r\n",), "PROTOCOL"),
        ((rtde_package(b"M", b"\1a\1b\0"),), "BUSY"),  # texts without end
        ((rtde_package(b"V", b"\0"),), "PROTOCOL"),
        ((rtde_package(b"V", b"\1"), rtde_package(b"v", b"5")), "PROTOCOL"),
    ],
)
def test_what_is_no_controller_is_told(texts, reason):
    with saying(*texts, pause=1e-4) as address, refused(reason):
        open_driver("ur", address)


Q = (0.1, -0.2, 0.3, -0.4, 0.5, -0.6)


def data(stamp, q=Q):
    """A data package; the stamps are 8 ms apart."""
    return rtde_package(b"U", struct.pack(">Bd6dii", 1, stamp, *q, 7, 1))


@pytest.mark.parametrize("turns", [-1000, 2.5, 3, 70_000])
def test_wrist_3_turns_without_end(turns):
    q = (*Q[:5], 2 * math.pi * turns)
    with (
        rtde_controller(data(1.0, q), data(1.008)) as address,
        open_driver("ur", address) as driver,
    ):
        assert [state.position for state in read_until_silent(driver)] == [q, Q]
        assert driver.rejected == 0


@pytest.mark.parametrize(
    "bad", [(13.0, *Q[1:]), (*Q[:4], -13.0, 0.0), (math.nan, *Q[1:]), (*Q[:5], math.inf)]
)
def test_a_bad_package_costs_itself_and_not_the_connection(bad):
    packages = data(1.0), data(1.008, bad), data(1.016)
    with rtde_controller(*packages) as address, open_driver("ur", address) as driver:
        assert [state.stamp for state in read_until_silent(driver)] == [1.0, 1.016]
        assert (driver.rejected, driver.missed) == (1, 1)


@pytest.mark.parametrize("bad", [(1e308, -1e308), (-1e308, 1e308), (1e300,), (1e9,), (math.nan,)])
def test_stamps_that_no_clock_shows_are_thrown_away(bad):
    packages = [data(stamp) for stamp in (1.0, *bad, 1.008)]
    with rtde_controller(*packages) as address, open_driver("ur", address) as driver:
        assert [state.stamp for state in read_until_silent(driver)] == [1.0, 1.008]
        assert (driver.rejected, driver.missed) == (len(bad), 0)


def test_an_output_that_the_controller_has_not_is_named():
    """Among those that every state needs, too."""
    reply = rtde_package(b"O", b"\1DOUBLE,VECTOR6D,NOT_FOUND,INT32")
    texts = rtde_package(b"V", b"\1"), rtde_package(b"v", bytes(16)), reply
    with saying(*texts, pause=1e-4) as address, pytest.raises(MukcaError) as caught:
        open_driver("ur", address)
    assert "sends no output called robot_mode" in str(caught.value)
    assert "NOT_FOUND" not in str(caught.value)
