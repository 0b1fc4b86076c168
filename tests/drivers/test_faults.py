"""What a controller or the network gets wrong never becomes a joint angle, and is counted."""

from itertools import pairwise

import pytest
from cases import by_table
from driver_errors import refused
from emulation import emulated, reading

from mukca.drivers import DriverError, Reason, Reconnecting, clock, open_driver

pytestmark = pytest.mark.waits

STATES = 300


def options(*faults):
    return [word for fault in faults for word in ("--fault", fault)]


def read_states(driver, count):
    """Read states; a silence between them is no trouble."""
    states = []
    while len(states) < count:
        states += read_one(driver, 5)
    return states


def read_one(driver, timeout):
    """Return the next state in a list, which is empty where the driver tells a silence."""
    try:
        return [driver.read(timeout)]
    except DriverError as error:
        assert error.reason is Reason.SILENT
        return []


def assert_were_sent(states, sent, tolerance=1e-6):
    """Each state is one that was sent, and later than the one before."""
    truths = iter(sent.values())
    for state in states:
        assert any(
            all(
                abs(a - b) <= tolerance
                for a, b in zip(state.position, truth["position"], strict=True)
            )
            for truth in truths  # goes on where the last state was found
        ), f"{state} was never sent, or earlier"


@pytest.mark.slow
@by_table("name", "version", "faults")
def test_what_is_read_was_sent(name, version, faults, tmp_path):
    words = options(*(f"{fault}:0.03" for fault in faults.split()))
    with emulated(name, tmp_path, "--version", version, *words) as emulation:
        with open_driver(name, emulation.address) as driver:
            states = read_states(driver, STATES)
            counts = driver.missed, driver.rejected
        emulation.stop()
        assert_were_sent(states, emulation.sent(), 1e-5 if name == "piper" else 1e-6)
    assert min(counts) > 0, "faults were neither missed nor rejected"
    if name != "piper":  # whose states carry no clock
        period = min(b.stamp - a.stamp for a, b in pairwise(states))
        lost = round((states[-1].stamp - states[0].stamp) / period) + 1 - len(states)
        assert counts[0] == lost


@pytest.mark.slow
@pytest.mark.parametrize("version", ["serial", "can"])
def test_kinova_asks_again_after_a_bad_answer(version, tmp_path):
    faults = options("drop:0.02", "truncate:0.02", "garble:0.02", "duplicate:0.02")
    with emulated("kinova", tmp_path, "--version", version, "--noise", "0", *faults) as emulation:
        with open_driver("kinova", emulation.address) as driver:
            states = read_states(driver, 30)
            assert driver.rejected > 0
        emulation.stop()
        sent = list(emulation.sent().values())
    for joint in range(6):
        told = {round(entry["position"][joint], 5) for entry in sent}
        near = told | {round(value + step, 5) for value in told for step in (1e-5, -1e-5)}
        assert {round(state.position[joint], 5) for state in states} <= near


@pytest.mark.parametrize("fault", ["truncate:0.01@0.5", "garble:0.01@0.5"])
def test_a_stream_that_lost_its_order_ends(fault, tmp_path):
    """TCP repeats nothing: bytes that make no sense end the connection, told as PROTOCOL."""
    with emulated("ur", tmp_path, *options(fault)) as emulation:
        with open_driver("ur", emulation.address) as driver:
            states = []
            with refused("PROTOCOL"):
                while True:
                    states.append(driver.read(5))
        emulation.stop()
        assert_were_sent(states, emulation.sent(), tolerance=0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["franka", "kuka", "ur", "piper", "kinova"])
def test_a_silence_is_told_and_survived(name, tmp_path):
    with reading(name, tmp_path, *options("silent@1.5+1.5")) as (_, driver):
        start, silent = clock.now(), 0.0
        while clock.now() < start + 60 and not silent:
            asked = clock.now()
            if not read_one(driver, 0.4):
                silent = clock.now() - asked
        assert 0.3 < silent < 5, "the timeout was not kept"
        assert read_states(driver, 5)


@pytest.mark.slow
@pytest.mark.parametrize("again", [False, True], ids=["same connection", "new connection"])
@by_table("name", "version", "tolerance")
def test_a_line_that_stalls_and_then_delivers_all_gives_no_old_angles(
    name, version, tolerance, again, tmp_path
):
    """Each joint's angle was told within 0.2 s of its stamp; nothing old passes for anything."""
    words = ("--version", version, "--hold", "0", *options("stall@0.5+1.2"))
    with emulated(name, tmp_path, *words) as emulation:
        silence = 0.5 if again else 10.0
        states = []
        with Reconnecting(lambda: open_driver(name, emulation.address), silence=silence) as driver:
            end = clock.now() + 3
            while clock.now() < end:
                states += read_one(driver, 0.2)
            assert bool(driver.drops) == again
        emulation.stop()
        sent = list(emulation.sent().values())
    assert states[-1].stamp > end - 1
    for state in states:
        near = [told for told in sent if abs(told["at"] - state.stamp) < 0.2]
        for joint, angle in enumerate(state.position):
            assert any(abs(told["position"][joint] - angle) < tolerance for told in near), state


@pytest.mark.parametrize("name", ["franka", "kuka", "ur", "kinova"])
def test_a_controller_that_takes_nobody_is_told(name, tmp_path):
    """Busy where the connection is taken, unreachable where no answer tells them apart."""
    with (
        emulated(name, tmp_path, *options("busy")) as emulation,
        pytest.raises(DriverError) as caught,
    ):
        open_driver(name, emulation.address)
    expected = {"franka": Reason.BUSY, "ur": Reason.BUSY}.get(name, Reason.UNREACHABLE)
    assert caught.value.reason is expected


def test_franka_serves_one_client_at_a_time(tmp_path):
    with reading("franka", tmp_path) as (emulation, driver):
        driver.read(5)
        with refused("BUSY", match="another program holds FCI"):
            open_driver("franka", emulation.address)
        assert driver.read(5)


@pytest.mark.parametrize("name", ["franka", "kuka", "ur"])
def test_a_version_that_cannot_be_read_is_told(name, tmp_path):
    with emulated(name, tmp_path, *options("version")) as emulation, refused("PROTOCOL") as caught:
        open_driver(name, emulation.address)
    if name == "franka":
        assert "99" in str(caught.value)


@pytest.mark.parametrize("version", ["1.15", "2.7"])
@pytest.mark.parametrize("start", ["0", "1"])
def test_kuka_leaves_a_session_that_commands(version, start, tmp_path):
    fault = options(f"commanding@{start}")
    with emulated("kuka", tmp_path, "--version", version, *fault) as emulation:
        with pytest.raises(DriverError) as caught, open_driver("kuka", emulation.address) as driver:
            while True:
                driver.read(5)
        replies = len(emulation.received())
        clock.sleep(0.5)
        assert len(emulation.received()) == replies, "a reply to a commanding session"
    assert caught.value.reason is Reason.WRONG_MODE
    assert (replies == 0) == (start == "0")


@by_table("name", "settings", "odd", "reason", "told")
def test_another_arm_than_is_asked_for_is_refused(name, settings, odd, reason, told, tmp_path):
    with emulated(name, tmp_path) as emulation, refused(reason, match=told):
        vars(emulation.emulator).update(odd)
        open_driver(name, emulation.address + settings)
