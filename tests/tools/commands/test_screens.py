"""What verbs say on one screen: 24 lines of 80 columns, the answer first."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from altered import write_rows, write_samples
from cameras import LYING, POSE, columns_of, flanges
from kept import NUMBER, compare
from terminal_session import MUKCA, TerminalSession

FIGURE = re.compile(r"[-+]?\d+\.\d{2,3}(?=[\s,;:)]|$)")
SCREENS = Path(__file__).with_name("screens")


def lines_of(text):
    """Lines as a terminal of 80 columns breaks them."""
    return [part for line in text.splitlines() for part in re.findall(r".{1,80}", line) or [""]]


@pytest.fixture
def screen(command):
    def screen(*words):
        status, out, err = command(*words)
        return status, out, lines_of(out + err)

    return screen


@pytest.mark.slow
def test_an_answer_comes_first_on_one_screen(session, screen, tmp_path):
    """``MUKCA_KEEP_PAGES=1`` writes the screens anew; numbers are not compared."""
    front, left, right = (str(session / name) for name in ("front", "left", "right"))
    out = str(tmp_path / "calibrated")
    for verb, *words in (
        ("check", front, left, "--robot", "panda"),
        ("solve", front, "--test", left, "--robot", "panda", "--out", out),
        ("validate", out, right),
    ):
        keeps(verb, screen(verb, *words), out)


def keeps(verb, told, folder):
    """Compare a screen with the one that is kept, but for its numbers and a folder's name."""
    _, said, lines = told
    assert len(lines) <= 24, said
    rows = [NUMBER.sub("#", line.replace(str(folder), "OUT")) for line in said.splitlines()]
    compare(SCREENS / f"{verb}.txt", [re.sub(" +", " ", row).rstrip() for row in rows])


@pytest.mark.slow
def test_what_is_found_on_a_calibrated_arm_comes_first(simulated, cal, screen, tmp_path):
    """``--details`` shows what the screen shows, and more."""
    arm = simulated.calibration.robot
    write_samples(tmp_path / "since", simulated.read({3: 5e-3}))
    tip = [0.03, -0.02, 0.2]
    touches = simulated.touched(np.array(tip)).positions.tolist()
    write_rows(tmp_path / "spike.csv", touches, arm.joint_names)
    views = seen_by_camera(simulated).tolist()
    write_rows(tmp_path / "poses.csv", views, (*arm.joint_names, *POSE))
    for verb, data, *words in (
        ("rezero", "since"),
        ("tool", "spike.csv", "--name", "spike"),
        ("handeye", "poses.csv", "--camera", "on-arm"),
    ):
        words = [verb, cal, tmp_path / data, *words]
        told = screen(*words, "--out", tmp_path / verb)
        keeps(verb, told, tmp_path)
        whole = screen(*words, "--details")[1]
        assert whole.startswith(told[1][:14]) and "--details" not in whole


@pytest.mark.slow
@pytest.mark.waits
@pytest.mark.parametrize(
    ("columns", "verb"), [(20, "check"), (20, "solve"), (20, "validate"), (40, "solve")]
)
def test_no_figure_is_cut_on_a_narrow_terminal(session, cal, command, columns, verb):
    """Lines are broken between words; rows of a table that is too wide are told in words."""
    front, left = str(session / "front"), str(session / "left")
    words = {
        "check": ("check", front, left, "--robot", "panda"),
        "solve": ("solve", front, "--test", left, "--robot", "panda", "--method", "paper"),
        "validate": ("validate", str(cal), left),
    }[verb]
    status, out, err = command(*words)
    with TerminalSession([*MUKCA, *words], columns=columns, rows=200) as terminal:
        assert terminal.wait() == status
        terminal.wait_for(out.split()[-1])
        shown = terminal.text
    assert "…" not in shown
    figures = set(FIGURE.findall(out + err))
    assert len(figures) > 3 and figures <= set(FIGURE.findall(shown))


def seen_by_camera(simulated):
    """Joint positions, and a board's poses in a camera at the flange, 0.2 mm noisy."""
    q = simulated.later.positions
    board = np.linalg.inv(flanges(simulated.truth, q)) @ LYING
    board[:, :3, 3] += np.random.default_rng(0).normal(0, 2e-4, (len(q), 3))
    return np.hstack([q, columns_of(board)])


@pytest.mark.slow
def test_of_a_fleet_those_to_look_at_come_first(session, screen, tmp_path):
    """One arm is well; of eight nothing can be read, and their steps take more than a screen."""
    for name in ("front", "left"):
        shutil.copytree(session / name, tmp_path / "fleet/arm-0" / name)
    for number in range(1, 9):
        write_rows(tmp_path / f"fleet/arm-{number}/front/hole_0.csv", [[number, 2]], ["a", "b"])
    words = ("--robot", "panda", "--method", "paper", "--processes", "1", "--out", tmp_path / "out")
    keeps("fleet", screen("fleet", tmp_path / "fleet", *words), tmp_path)
    words = [*words, "--force"]
    told = [*MUKCA, "fleet", str(tmp_path / "fleet"), *map(str, words)]
    with TerminalSession(told, columns=40, rows=200) as terminal:
        assert terminal.wait() == 1
        lines = [line.strip() for line in terminal.text.splitlines()]
    assert "arm-1: verdict no calibration" in lines and "and 3 more arms" in lines
    words = [*words, "--details"]
    assert screen("fleet", tmp_path / "fleet", *words)[1].count("Mend the recordings") == 8
