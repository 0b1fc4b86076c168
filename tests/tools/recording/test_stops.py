"""`record --stops` and `rezero --stops` on servos that an emulator turns, to lerobot's file."""

import json
import math

import numpy as np
import pytest
from emulation import emulated
from recorded import write_sockets

import mukca
from mukca.tools.cli import main

SERVOS = {"feetech": ("so101", -1), "dynamixel": ("koch", 1)}
"""An arm, and the sign of its homing offset in a position."""


def record(name, folder, out, shift, capsys):
    """Lead an arm to its stops, whose second joint reads so much more [rad]."""
    arm = SERVOS[name][0]
    robot = mukca.load_robot(arm)
    rng = np.random.default_rng(len(out))
    poses = []
    for joint in range(5):
        for end in (-1.4, 1.2, 0.0):
            pose = np.zeros(5)
            pose[joint] = end + np.sign(end) * abs(rng.normal(0, math.radians(0.3)))
            poses.append(pose + np.array([0, shift, 0, 0, 0]))
    samples = tuple(mukca.recorder.Sample(tuple(pose.tolist()), 0) for pose in poses)
    led = mukca.Placement("led", samples, robot.joint_names)
    write_sockets(folder / f"led_{out}", led)
    motion = ("--hold", "1", "--move", "0.5", "--version", arm)
    recording = ("--recording", str(folder / f"led_{out}"), *motion)
    with emulated(name, folder, *recording) as emulation:
        words = ["--robot", arm, "--driver", f"{name}:{emulation.address}"]
        assert main(["record", "--stops", *words, "--out", str(folder / out)]) == 0
    assert f"{robot.joint_names[1]}: " in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize("name", SERVOS)
def test_a_changed_zero_becomes_a_homing_offset(name, tmp_path, capsys, answer):
    shift = math.radians(14.4)  # a tooth of a servo's horn
    record(name, tmp_path, "calibrated", 0.0, capsys)
    record(name, tmp_path, "today", shift, capsys)
    motor = {"drive_mode": 0, "homing_offset": 100, "range_min": 900, "range_max": 3100}
    names = mukca.load_robot(SERVOS[name][0]).joint_names
    motors = {joint: {"id": i, **motor} for i, joint in enumerate(names, 1)}
    (tmp_path / "arm.json").write_text(json.dumps(motors))
    words = ("--like", tmp_path / "arm.json", "--servos", name, "--out", tmp_path / "new.json")
    said = answer("rezero", tmp_path / "calibrated", tmp_path / "today", "--stops", *words)
    changed = [zero for zero in said["zeros"] if zero["changed"]]
    assert [zero["joint"] for zero in changed] == [names[1]]
    assert abs(changed[0]["offset"] + shift) < math.radians(0.5)
    new = json.loads((tmp_path / "new.json").read_text())
    moved = {joint: row["homing_offset"] - 100 for joint, row in new.items()}
    expected = -SERVOS[name][1] * shift / math.tau * 4096
    assert abs(moved.pop(names[1]) - expected) < 6 and not any(moved.values())


def test_what_stops_need_is_said(refused, tmp_path):
    (tmp_path / "stops.json").write_text("[]")
    refused("no file of mukca record --stops", "rezero", tmp_path, tmp_path, "--stops")
    refused("mukca record --stops --out", "rezero", tmp_path / "none", tmp_path, "--stops")
    again = ("record", "--stops", "--robot", "so101", "--driver", "feetech:x", "--out", tmp_path)
    refused("stops.json is there already", *again)
    words = ("rezero", tmp_path, tmp_path, "--stops", "--out", tmp_path / "a.json")
    refused("--out needs --like FILE", *words)
