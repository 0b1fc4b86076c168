"""Held-out errors of recordings that stay as they are, to 1e-9 m, until a change is meant."""

import json
from pathlib import Path

import pytest
from altered import write_samples
from kept import measures
from worlds.zoo import SHARED, Case

import mukca

pytestmark = pytest.mark.slow

GOLDEN = Path(__file__).with_name("golden")
TRAINED = {"panda_3": "frontcenter", "kuka_14": "front", "dinova_2": "front"}
"""Folders of the paper's Table I, and the placement that each is trained on."""


def errors(found):
    """Mean absolute errors at what was held out [m], by placement."""
    rows = [row for row in found.errors if row.role == "test"]
    return {row.name: row.calibrated.mean_absolute_error for row in rows}


def recorded(source, *changes):
    """Recordings of a source, and its robots; skipped where these are real and not there."""
    case = Case(source, changes)
    if case.missing:
        pytest.skip(f"no recordings of real arms at {SHARED}")
    found = case.recorded()
    return found, {name: found.robot(name) for name in found.robots}


@pytest.mark.parametrize("arm", TRAINED)
def test_table_one_by_placement(arm, recordings):
    placements = mukca.read_placements(recordings / arm)
    train = [p for p in placements if p.place == TRAINED[arm]]
    robot = mukca.load_robot(str(recordings / arm / "nominal.urdf"))
    options = {"method": "paper", "distance": 0.05}
    found = mukca.calibrate(robot, train, [p for p in placements if p not in train], **options)
    measures(GOLDEN / f"{arm}.txt", errors(found))


@pytest.mark.parametrize("arm", ["ur5", "ur10"])
def test_arms_under_a_tracker(arm):
    found, robots = recorded(f"tracked points of {arm}")
    calibration = mukca.calibrate(robots[""], found.train[""], found.test[""])
    measures(GOLDEN / f"{arm}.txt", errors(calibration))


def test_a_servo_arm():
    found, robots = recorded("so101", "8 samples")
    calibration = mukca.calibrate(robots[""], found.train[""], found.test[""], zeros=True)
    measures(GOLDEN / "so101.txt", errors(calibration))


def test_a_pair():
    found, robots = recorded("panda and ur5e", "8 samples")
    pair = mukca.calibrate(robots, found.train, found.test)
    lengths = {f"{arm} {name}": e for arm in pair for name, e in errors(pair[arm]).items()}
    measures(GOLDEN / "pair.txt", lengths)


def test_few_samples_of_a_pair_hold_no_length_at_nominal():
    """Widths that fell to where rounding held them left 1.5 mm."""
    found, robots = recorded("panda and ur5e", "5 samples")
    pair = mukca.calibrate(robots, found.train, found.test)
    assert errors(pair["A"])["left"] < 1e-3


def test_a_fleet(tmp_path, command):
    for seed in range(2):
        arm = Case("xarm6", ("8 samples",), seed).recorded()
        for part in ("train", "test"):
            write_samples(tmp_path / "arms" / f"arm-{seed}" / part, getattr(arm, part)[""][0])
    words = ("--robot", "xarm6", "--out", tmp_path / "out", "--processes", 1)
    command("fleet", tmp_path / "arms", *words)
    arms = json.loads((tmp_path / "out" / "fleet.json").read_text())["arms"]
    measures(GOLDEN / "fleet.txt", {arm["name"]: arm["sessions"][0]["calibrated"] for arm in arms})
