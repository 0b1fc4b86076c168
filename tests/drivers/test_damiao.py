"""Damiao motors: worked examples of their frames, and what must stop a recording."""

import pytest
from emulation import emulated
from hypothesis import given, settings
from hypothesis import strategies as st

from mukca.drivers import DriverError, Reason
from mukca.drivers.arms.damiao import (
    Damiao,
    decode_feedback,
    decode_query,
    encode_query,
    encode_refresh,
)
from mukca.tools.emulators.damiao import DamiaoEmulator


def test_the_requests_bytes():
    assert encode_refresh(1) == bytes.fromhex("0100cc0000000000")
    assert encode_query(3) == bytes.fromhex("0300331500000000")


def test_the_answers_bytes():
    """Of a DM8009 at half a radian, as another package reads it."""
    angle, status = decode_feedback(bytes.fromhex("01851e7ff825191b"), 1)
    assert (angle, status) == (pytest.approx(0.49992, abs=1e-5), 0)
    assert decode_query(bytes.fromhex("0100331500004841"), 1) == 12.5


@pytest.mark.parametrize(
    "text", ["", "01851e7ff82519", "01851e7ff825191b00", "02851e7ff825191b", "71851e7ff825191b"]
)
def test_what_is_no_feedback(text):
    with pytest.raises(ValueError, match="feedback of motor 1"):
        decode_feedback(bytes.fromhex(text), 1)


@pytest.mark.slow
@settings(max_examples=200)
@given(st.binary(max_size=10))
def test_feedback_is_plausible(noise):
    try:
        angle, _ = decode_feedback(noise, 3)
    except ValueError:
        return
    assert len(noise) == 8 and abs(angle) <= 12.5


def test_an_enabled_motor_is_refused(tmp_path, monkeypatch):
    with emulated("damiao", tmp_path) as emulation, Damiao(emulation.address) as driver:
        driver.read(1)
        monkeypatch.setattr(DamiaoEmulator, "status", 1)
        with pytest.raises(DriverError, match="is enabled: end the program") as caught:
            driver.read(1)
    assert caught.value.reason is Reason.WRONG_MODE


def test_what_troubles_a_motor_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(DamiaoEmulator, "status", 9)
    with emulated("damiao", tmp_path) as emulation, Damiao(f"{emulation.address}&ids=2,3") as arm:
        arm.read(1)
        assert arm.status == "motor 2: under-voltage, motor 3: under-voltage"


def test_another_scale_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("mukca.tools.emulators.damiao.PMAX_BYTES", b"\xdb\x0f\x49\x40")
    told = pytest.raises(DriverError, match=r"motor 1 on .* counts to 3\.14159 rad, not 12\.5")
    with emulated("damiao", tmp_path) as emulation, told as caught:
        Damiao(emulation.address)
    assert caught.value.reason is Reason.WRONG_ROBOT


def test_motors_and_signs_are_settings(tmp_path):
    with emulated("damiao", tmp_path, "--noise", "0", "--hold", "60") as emulation:
        with Damiao(f"{emulation.address}&ids=1,3&signs=1,-1") as driver:
            position = driver.read(1).position
        truth = emulation.sent()[1]["position"]
    assert position == pytest.approx((truth[0], -truth[2]), abs=2e-4)


@pytest.mark.parametrize("words", ["ids=0", "ids=1,16", "ids=a", "signs=1,1", "signs=2", "rate=0"])
def test_settings_that_mean_nothing(words):
    with pytest.raises(DriverError) as caught:
        Damiao(f"virtual/x?{words}")
    assert caught.value.reason is Reason.BAD_ADDRESS
