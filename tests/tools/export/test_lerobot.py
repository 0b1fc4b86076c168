"""lerobot's calibration file: each reading moves by the zero that was found, and nothing else."""

import hashlib
import json
import math

import numpy as np
import pytest
from cases import by_table
from imagined import edited

import mukca

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll")
ZEROS = np.radians([0.5, -4.0, 3.0, 20.0, 1.0])
KNOWN = np.radians([0.3, 0.19, 0.1, 0.1, 0.15])
TICKS = [0, round(-4 / 360 * 4096), round(3 / 360 * 4096), 0, round(1 / 360 * 4096)]


def present(**changes):
    """What the arm has now."""
    motors = {
        name: {"id": number, "drive_mode": 0, "homing_offset": 37 * number, "range_min": 700,
               "range_max": 3300 + number}
        for number, name in enumerate((*JOINTS, "gripper"), 1)
    }  # fmt: skip
    motors["elbow_flex"] |= changes
    return motors


@pytest.fixture
def calibration(calibrations, tmp_path):
    zeros = [
        {"name": f"{name}.zero", "unit": "rad", "value": zero, "standard_deviation": known}
        for name, zero, known in zip(JOINTS, ZEROS.tolist(), KNOWN.tolist(), strict=True)
    ]
    out = tmp_path / "calibration.json"
    return edited(calibrations / "so101.json", out, lambda d: d.update(coefficients=zeros))


@pytest.fixture
def like(tmp_path):
    file = tmp_path / "my_arm.json"
    file.write_text(json.dumps(present()))
    return file


@pytest.fixture
def words(calibration, like, tmp_path):
    """Words of an export to new.json, for Feetech's servos."""
    how = ("--to", "lerobot", "--like", like, "--servos", "feetech")
    return (calibration, *how, "--out", tmp_path / "new.json")


def degrees(motor, actual, sign):
    """What lerobot tells of a motor, from the servo's count without an offset."""
    position = actual + sign * motor["homing_offset"]
    return (position - (motor["range_min"] + motor["range_max"]) / 2) * 360 / 4095


@pytest.mark.parametrize(("make", "sign"), [("feetech", -1), ("dynamixel", 1)])
def test_each_reading_moves_by_its_zero(export, words, make, sign):
    status, shown, _ = export(*(make if word == "feetech" else word for word in words))
    assert status == 0
    old, new = present(), json.loads(words[-1].read_text())
    assert list(new) == list(old)
    for name, ticks in zip((*JOINTS, "gripper"), (*TICKS, 0), strict=True):
        moved = degrees(new[name], 1234, sign) - degrees(old[name], 1234, sign)
        assert moved == pytest.approx(ticks * 360 / 4095)
        same = {key: value for key, value in old[name].items() if key != "homing_offset"}
        assert new[name] == {**same, "homing_offset": new[name]["homing_offset"]}
    assert "shoulder_pan   +0.50 +- 0.30 deg, not decided by the data, left as it is" in shown
    assert "shoulder_lift  -4.00 +- 0.19 deg, -46 ticks" in shown
    assert "wrist_flex     +20.00 +- 0.10 deg, +228 ticks are too many" in shown


def test_a_file_that_changes_nothing_says_so(export, calibration, words):
    def undecided(document):
        for one in document["coefficients"]:
            one["standard_deviation"] = 1.0

    edited(calibration, calibration, undecided)
    status, shown, error = export(*words)
    assert status == 0, error
    assert "Nothing changes: every homing offset is that of" in shown
    assert json.loads(words[-1].read_text()) == present()


def test_the_old_file_stays_and_its_digest_is_noted(export, words, like, tmp_path):
    before = like.read_bytes()
    export(*words)
    assert like.read_bytes() == before
    beside = json.loads((tmp_path / "new.json.mukca.json").read_text())
    assert beside["calibration_file_sha256"] == hashlib.sha256(before).hexdigest()
    assert [zero["ticks"] for zero in beside["zeros"]] == TICKS


def test_the_urdf_beside_it_has_the_new_zeros(export, calibration, words, tmp_path):
    """Where the old readings are by the calibrated URDF, the new ones are by this one."""
    export(*words)
    calibrated = mukca.load_calibration(calibration).calibrated
    robot = mukca.load_robot(tmp_path / "new.urdf")
    q = np.random.default_rng(0).uniform(-1, 1, (20, 5))
    shifted = q + np.array(TICKS) * 2 * math.pi / 4096
    new = type(calibrated)(robot, (), np.empty(0))
    assert new.ball(shifted) == pytest.approx(calibrated.geometric_ball(q), abs=1e-9)


def by_other_names(motors, order):
    """The motors called as no joint is, in another order."""
    names = {name: f"motor_of_{name}" for name in motors}
    return {names[name]: motors[name] for name in sorted(motors, key=order)}


@pytest.mark.parametrize("order", [lambda name: name, lambda name: name[::-1]])
def test_motors_of_other_names_are_known_by_their_ids(export, words, like, order):
    like.write_text(json.dumps(by_other_names(present(), order)))
    export(*words)
    old, new = present(), json.loads(words[-1].read_text())
    offsets = [
        old[name]["homing_offset"] - new[f"motor_of_{name}"]["homing_offset"] for name in JOINTS
    ]
    assert offsets == TICKS


@pytest.mark.parametrize(
    ("number", "says"),
    [(2, "motor_of_shoulder_lift, motor_of_elbow_flex all have the id 2"), (9, "no motor has")],
)
def test_motors_that_no_id_tells_apart_are_refused(refused, words, like, number, says):
    like.write_text(json.dumps(by_other_names(present(id=number), lambda name: 0)))
    refused(says, "export", *words)


@by_table("change", "words", "says")
def test_what_cannot_be_gets_one_line(refused, calibration, like, tmp_path, change, words, says):
    like.write_text(json.dumps(present(**change)))
    given = [like if word == "LIKE" else word for word in words]
    out = tmp_path / "new.json"
    refused(says, "export", calibration, "--to", "lerobot", *given, "--out", out)
    assert not out.exists()


def test_joints_that_were_read_the_other_way_are_refused(refused, calibration, words, tmp_path):
    (tmp_path / "placement.json").write_text('{"sessions": [{"driver": "feetech:p?signs=-1,1"}]}')
    files = [str(tmp_path / "hole_0.csv")]
    edited(calibration, calibration, lambda document: document["data"][0].update(files=files))
    refused("recorded with signs=", "export", *words)


def test_without_zeros_there_is_nothing_to_write(refused, calibrations, words):
    refused("solve with --zeros", "export", calibrations / "fitted.json", *words[1:])
