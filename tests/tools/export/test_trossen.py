"""A Trossen arm's configuration: each reading moves by its zero, and nothing else changes."""

import numpy as np
import pytest
from imagined import configurations, edited

import mukca

yaml = pytest.importorskip("yaml", reason="PyYAML comes with xacro")
JOINTS = [f"joint_{i}" for i in range(6)]
ZEROS = [0.001, -0.02, 0.03, 0.5, 0.004, 0.02]
DEVIATIONS = [0.01, 0.002, 0.002, 0.002, 0.001, 0.03]
WRITTEN = [0, -0.02, 0.03, 0, 0.004, 0]
PRESENT = [0, 0.01, "-1e-3", 0, 0.019999999552965164, 0, 0.0004]


def present(offsets=PRESENT):
    """A file as the driver saves it: six joints, then the gripper."""
    rows = "".join(
        f"  - effort_correction: 1.1\n    position_offset: {offset}\n" for offset in offsets
    )
    after = "modes:\n  - idle\njoint_limits:\n  - position_offset: 7\n"
    return f"ip_method: manual\njoint_characteristics:\n{rows}{after}"


@pytest.fixture
def calibration(calibrations, tmp_path):
    columns = zip(JOINTS, ZEROS, DEVIATIONS, strict=True)
    zeros = [
        {"name": f"{name}.zero", "unit": "rad", "value": zero, "standard_deviation": deviation}
        for name, zero, deviation in columns
    ]
    out = tmp_path / "calibration.json"
    return edited(calibrations / "wxai.json", out, lambda d: d.update(coefficients=zeros))


@pytest.fixture
def words(calibration, tmp_path):
    like = tmp_path / "arm.yaml"
    like.write_text(present())
    return (calibration, "--to", "trossen", "--like", like, "--out", tmp_path / "new.yaml")


def offsets(text):
    return np.array([float(row["position_offset"]) for row in text["joint_characteristics"]])


def test_the_new_readings_and_the_new_urdf_put_the_ball_where_it_was(
    export, calibration, words, tmp_path
):
    """The motor's angle is the position plus the offset: that of an old reading stays."""
    status, shown, error = export(*words)
    assert status == 0, error
    old, new = (yaml.safe_load(file.read_text()) for file in (words[-3], words[-1]))
    change = offsets(new) - offsets(old)
    assert change == pytest.approx([*np.negative(WRITTEN), 0], abs=1e-9)
    for document in (old, new):
        for row in document["joint_characteristics"]:
            del row["position_offset"]
    assert new == old
    calibrated = mukca.load_calibration(calibration).calibrated
    q = configurations(calibrated.robot, 20)
    motors = q + offsets(yaml.safe_load(present()))[:6]
    readings = motors - offsets(yaml.safe_load(words[-1].read_text()))[:6]
    urdf = type(calibrated)(mukca.load_robot(tmp_path / "new.urdf"), (), np.empty(0))
    assert urdf.ball(readings) == pytest.approx(calibrated.geometric_ball(q), abs=1e-9)
    assert np.abs(calibrated.geometric_ball(readings) - calibrated.geometric_ball(q)).max() > 1e-3
    assert "joint_0        +0.06 +- 0.57 deg, not decided by the data, left as it is" in shown
    assert "joint_3        +28.65 +- 0.11 deg, too large" in shown


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (present(PRESENT[:6]), "6 times position_offset"),
        ("modes:\n  - idle\n", "0 times position_offset"),
    ],
)
def test_another_file_is_refused(refused, words, text, says):
    words[-3].write_text(text)
    refused(says, "export", *words)


def test_what_is_missing_is_said(refused, calibrations, words):
    refused("solve with --zeros", "export", calibrations / "wxai.json", *words[1:])
    refused("needs --like FILE", "export", *words[:3], *words[-2:])
    refused("and another name for --out", "export", *words[:-1], words[-3])


def test_another_makers_arm_is_refused(refused, calibrations, tmp_path, words):
    names = mukca.load_robot("ur5e").joint_names
    zeros = [
        {"name": f"{name}.zero", "unit": "rad", "value": 0, "standard_deviation": 0}
        for name in names
    ]
    other = tmp_path / "ur5e.json"
    edited(calibrations / "ur5e.json", other, lambda d: d.update(coefficients=zeros))
    refused("ur5e does not have the joints of a Trossen arm", "export", other, *words[1:])
