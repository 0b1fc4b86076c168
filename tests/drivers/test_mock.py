"""The simulated arm: what it streams is what it was given, and it misbehaves as asked."""

import math
from pathlib import Path

import numpy as np
import pytest

from mukca.drivers import DriverError, JointState, Reason, clock, open_driver
from mukca.drivers.arms import Motion, SimulatedArm
from mukca.drivers.arms.simulated import FAULTS, Fault, Mock
from mukca.recorder import sample_files
from mukca.recorder.dataset import Placement, Sample

pytestmark = pytest.mark.usefixtures("virtual_time")
REST = [[0.1, 0.2, 0.3]]


def arm(*faults: str, configurations: list[list[float]] = REST, **options: float) -> SimulatedArm:
    """An arm whose hour passes in a second or so."""
    options = {"speed": 20.0, "rate": 100.0, "noise": 0.0} | options
    motion = Motion(configurations, hold=0.5, move=0.5)
    return SimulatedArm(motion, faults=[Fault.parse(f) for f in faults], **options)


def states(driver: Mock, count: int) -> list[JointState]:
    return [driver.read(5.0) for _ in range(count)]


def test_every_state_comes_once_and_in_order() -> None:
    with Mock(arm=arm(configurations=[[0.0], [1.0]])) as driver:
        read = states(driver, 150)
    assert [state.stamp for state in read] == [k / 100 for k in range(150)]
    motion = Motion([[0.0], [1.0]], hold=0.5, move=0.5)
    assert [state.position for state in read] == [motion.position(s.stamp) for s in read]


def test_states_come_at_the_arm_s_rate() -> None:
    with Mock(arm=arm(speed=1.0)) as driver:
        begun = clock.now()
        states(driver, 50)
        assert clock.now() - begun >= 0.49


def test_the_noise_is_as_asked_and_the_same_for_a_seed() -> None:
    options = {"noise": 1e-3, "speed": 1e4, "seed": 3}
    first, second = (states(Mock(arm=arm(**options)), 2000) for _ in range(2))
    assert [s.position for s in first] == [s.position for s in second]
    deviation = np.std([s.position for s in first])
    error = np.array([s.position for s in first]) - REST[0]
    assert error.std() == pytest.approx(1e-3, rel=0.05)
    assert abs(error.mean()) < 1e-4 < deviation


def test_a_reader_that_is_late_misses_nothing_without_a_buffer_s_limit() -> None:
    with Mock(arm=arm()) as driver:
        clock.sleep(0.2)
        assert [s.stamp for s in states(driver, 100)] == [k / 100 for k in range(100)]
        assert driver.missed == 0


def test_a_reader_that_is_late_misses_what_a_buffer_cannot_hold() -> None:
    with Mock(arm=arm(buffer=1.0)) as driver:
        clock.sleep(0.2)  # four seconds of the arm's time
        first = driver.read(1.0)
        assert driver.missed == round(first.stamp * 100) > 200
        assert states(driver, 50)[-1].stamp == pytest.approx(first.stamp + 0.5)


def test_efforts_follow_the_motion() -> None:
    moving = arm(configurations=[[0.0], [1.0]], effort_noise=0.0)
    moving = SimulatedArm(moving.motion, efforts=[[5.0], [7.0]], effort_noise=0.0, noise=0.0)
    assert moving.state(0.1).effort == (5.0,)
    assert moving.state(0.75).effort == pytest.approx((6.0,))
    assert arm().state(0.0).effort is None


@pytest.mark.parametrize("kind", [kind for kind in FAULTS if kind not in ("drop", "silent")])
def test_a_fault_shows_from_its_start_to_its_end(kind: str) -> None:
    still = arm(f"{kind}@0.5+0.3", noise=1e-6)
    still = SimulatedArm(
        still.motion, efforts=[[1.0] * 3], rate=100, speed=1e4, faults=still.faults, noise=1e-6
    )
    driver = Mock(arm=still)
    read = states(driver, 120)
    sound = [k for k, state in enumerate(read) if _sound(read, k, state)]
    assert sound == [k for k in range(120) if not 50 <= k < 80 or (kind == "freeze" and k == 50)]


def _sound(read: list[JointState], k: int, state: JointState) -> bool:
    assert state.effort is not None
    before = read[k - 1] if k else None
    return (
        len(state.position) == 3
        and all(abs(a - b) < 0.01 for a, b in zip(state.position, REST[0], strict=True))
        and all(abs(tau) < 2 for tau in state.effort)
        and (before is None or state.stamp > before.stamp)
        and (before is None or state.position != before.position)
    )


def test_a_silent_arm_sends_nothing_for_a_while() -> None:
    with Mock(arm=arm("silent@0.5+5")) as driver:
        states(driver, 50)
        with pytest.raises(DriverError) as caught:
            driver.read(0.05)
        assert caught.value.reason is Reason.SILENT
        assert driver.read(5.0).stamp == 5.5


def test_a_dropped_connection_comes_back_to_an_arm_that_went_on() -> None:
    living = arm("drop@0.5+4")
    driver = Mock(arm=living)
    states(driver, 50)
    with pytest.raises(DriverError, match="dropped") as caught:
        driver.read(1.0)
    assert caught.value.reason is Reason.UNREACHABLE
    with pytest.raises(DriverError, match="does not answer"):
        Mock(arm=living)
    clock.sleep(max(0.0, 4.6 / 20 - living.now() / 20))
    assert Mock(arm=living).read(1.0).stamp >= 4.5


def test_an_address_finds_the_arm_that_it_dropped(tmp_path: Path) -> None:
    file = tmp_path / "hand.csv"
    file.write_text("1,2\n")
    address = f"{file}?speed=20&fault=drop@0.5+2"
    driver = Mock(address)
    with pytest.raises(DriverError, match="dropped"):
        states(driver, 10000)
    driver.close()
    with pytest.raises(DriverError, match="does not answer"):
        Mock(address)
    clock.sleep(0.2)
    with Mock(address) as again:
        assert again.read(1.0).stamp > 2.4
    with Mock(address) as anew:
        assert anew.read(1.0).stamp == 0.0


@pytest.mark.parametrize("form", ["file", "holes", "samples"])
def test_it_replays_either_form_of_a_recording(tmp_path: Path, form: str) -> None:
    samples = (Sample((0.1, 0.2), 0, (1.0, 2.0), number=1), Sample((0.3, 0.4), 1, (3.0, 4.0)))
    placement = Placement("front", samples, ("a", "b"), 0.05)
    if form == "samples":
        for name, content in sample_files(placement).items():
            (tmp_path / name).write_bytes(content)
    elif form == "holes":
        (tmp_path / "hole_0.csv").write_text("a,b\n0.1,0.2\n")
        (tmp_path / "hole_1.csv").write_text("a,b\n0.3,0.4\n")
    else:
        (tmp_path / "hand.csv").write_text("a,b\n0.1,0.2\n0.3,0.4\n")
    path = tmp_path / "hand.csv" if form == "file" else tmp_path
    address = f"{path}?rate=10&hold=0.5&move=0.5&speed=50&noise=0&effort_noise=0"
    with open_driver("mock", address) as driver:
        read = [driver.read(1.0) for _ in range(12)]
        assert driver.joint_names == ("a", "b")
    assert (read[0].position, read[-1].position) == ((0.1, 0.2), (0.3, 0.4))
    efforts = (read[0].effort, read[-1].effort)
    assert efforts == (((1.0, 2.0), (3.0, 4.0)) if form == "samples" else (None, None))


@pytest.mark.parametrize(
    ("address", "told"),
    [
        ("", "needs a recording"),
        ("/nowhere", "/nowhere: cannot be read"),
        ("{file}?speed=fast", "option speed: 'fast' is not a number"),
        ("{file}?colour=1", "option 'colour' is none of rate"),
        ("{file}?fault=melt@1", "fault 'melt' is none of drop"),
        ("{file}?fault=nan@soon", "could not convert"),
        ("{file}?rate=0", "must be positive"),
        ("{file}?rate", "bad query field"),
        ("{words}", "could not convert"),
        ("{empty}", "no configuration"),
    ],
)
def test_a_bad_address_is_told(tmp_path: Path, address: str, told: str) -> None:
    files = {name: tmp_path / f"{name}.csv" for name in ("file", "words", "empty")}
    files["file"].write_text("1,2\n")
    files["words"].write_text("1,2\n1,two\n")
    files["empty"].write_text("")
    with pytest.raises(DriverError, match=told) as caught:
        open_driver("mock", address.format(**files))
    assert caught.value.reason is Reason.BAD_ADDRESS


def test_another_number_of_joints_than_the_model_s_is_refused() -> None:
    with pytest.raises(DriverError, match="3 joints, but the model has 2") as caught:
        Mock(joint_names=("a", "b"), arm=arm())
    assert caught.value.reason is Reason.WRONG_ROBOT


def test_a_closed_connection_reads_no_more() -> None:
    driver = Mock(arm=arm())
    driver.close()
    driver.close()
    with pytest.raises(DriverError, match="closed"):
        driver.read(1.0)


def test_a_fault_without_an_end() -> None:
    fault = Fault.parse("nan@2+inf")
    assert fault.active(1e9) and not fault.active(1.9)
    assert Fault.parse("nan@2").duration == 0.5 and math.isinf(fault.duration)
