"""From a controller's bytes to a calibrated arm: record each emulator, then solve."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from cases import by_table
from emulation import emulated
from emulator_programs import emulated_program
from record_commands import read
from recorded import recorded_in_reach, true_arm, write_sockets
from terminal_session import MUKCA, TerminalSession

import mukca
from mukca.tools.cli import main

pytestmark = pytest.mark.slow

SAMPLES = 8
STATES = 40  # at least so many are averaged, at 200 Hz for 0.25 s
NOISE = 2e-5  # rad, of the emulated encoders
TICK = math.pi / 4096
ROUNDING = {"piper": 1e-5, "feetech": TICK, "dynamixel": TICK, "damiao": 2e-4}  # rad
RATES = {"kinova": 20, "damiao": 20, "feetech": 20, "dynamixel": 20}  # polled states in a window
LEVER = 0.5  # m: what rounding does at the ball
NOISY = ("--noise", str(NOISE))
WINDOW = 0.25  # s
OFTEN = {"franka": 0.1, "ur": 0.1}  # so many states a second that less is enough
FARTHER = {"so101": 3}  # so many times as far from its model as a cobot, as such arms are


def write_placements(robot, folder):
    """Two placements of an arm whose true kinematics differ from its URDF: to train, to test."""
    generator = np.random.default_rng(5)
    worse = FARTHER.get(robot, 1)
    arm = true_arm(mukca.load_robot(robot), generator, 2e-3 * worse, 5e-3 * worse)
    placements = recorded_in_reach(arm, generator, 2, samples=40, noise=2e-5)
    for name, placement in zip(("train", "test"), placements, strict=True):
        few = replace(placement, samples=tuple(short_steps(placement)))
        write_sockets(folder / name, few)


def short_steps(placement):
    """Choose samples of each socket as a hand would: on to the nearest."""
    last = placement.samples[0]
    for socket in (0, 1):
        left = [sample for sample in placement.samples if sample.socket == socket]
        for _ in range(SAMPLES):
            last = min(left, key=lambda sample: math.dist(sample.position, last.position))
            left.remove(last)
            yield last


@by_table("name", "robot", "version")
def test_the_truth_is_found(name, robot, version, tmp_path, capsys):
    write_placements(robot, tmp_path)
    keys = tmp_path / "keys.txt"
    keys.write_text(f"a*{SAMPLES} s a*{SAMPLES} q")
    window = OFTEN.get(name, WINDOW)
    motion = ("--hold", str(2.4 * window), "--move", str(2 * window), *NOISY)
    recording = ("--recording", str(tmp_path / "train"), *motion)
    with emulated(name, tmp_path, "--version", version, *recording) as emulation:
        assert main(words(robot, f"{name}:{emulation.address}", tmp_path, window)) == 0
    capsys.readouterr()

    recorded = read(tmp_path / "recorded")
    truth = read(tmp_path / "train")
    tolerance = 5 * NOISE / np.sqrt(RATES.get(name, STATES)) + ROUNDING.get(name, 0.0)
    assert np.abs(recorded.positions - truth.positions).max() < tolerance
    errors = solve(tmp_path / "recorded", robot, tmp_path / "test", capsys)
    best = solve(tmp_path / "train", robot, tmp_path / "test", capsys)
    assert errors["calibrated"] < 0.4 * errors["nominal"]
    slack = 2e-5 + LEVER * ROUNDING.get(name, 0.0)
    assert errors["calibrated"] < 1.3 * best["calibrated"] + slack


def words(robot, driver, folder, window=WINDOW):
    """Return how to record by the folder's key script."""
    options = ["--driver", driver, "--window", str(window)]
    files = ["--out", str(folder / "recorded"), "--keys", str(folder / "keys.txt")]
    return ["record", "--robot", robot, *options, *files]


@pytest.mark.waits
def test_a_program_is_recorded_in_a_terminal(session, tmp_path):
    """Two programs, in real time: the arm goes on only once the first sample is taken."""
    (tmp_path / "keys.txt").write_text("a*2 q")
    motion = ("--hold", "0.9", "--move", "0.7", *NOISY, "--wait")
    recording = ("--recording", str(session / "front"), *motion)
    with emulated_program("franka", tmp_path, *recording) as emulation:
        command = [*MUKCA, *words("panda", f"franka:{emulation.address}", tmp_path)]
        with TerminalSession(command) as terminal:
            terminal.wait_for("0:  1/30")
            emulation.release()
            assert terminal.wait() == 0, terminal.text
    recorded = read(tmp_path / "recorded").positions
    truth = read(session / "front").positions
    nearest = np.abs(recorded[:, None] - truth[None]).max(axis=2).argmin(axis=1)
    assert nearest[0] == 0 and nearest[1] > 0
    assert np.abs(recorded - truth[nearest]).max() < 5 * NOISE / np.sqrt(STATES)


def solve(train, robot, test, capsys):
    """Return the mean absolute errors on the held-out placement, before and after [m]."""
    data = [str(train), "--test", str(test), "--distance", "0.05"]
    words = ["solve", *data, "--robot", robot, "--method", "paper", "--json"]
    main(words)  # so few samples may not suffice for a PASS
    summary = json.loads(capsys.readouterr().out)["summary"]["test"]
    return {model: summary[model]["mean_absolute_error"] for model in ("nominal", "calibrated")}
