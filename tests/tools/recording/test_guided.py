"""Guided sessions in a real terminal, by keys and hands free, and the page beside one."""

import math
import re
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from altered import write_rows
from record_commands import read
from terminal_session import MUKCA, PATIENCE, TerminalSession

import mukca
from mukca.recorder import sample_files
from mukca.solver.results import write_files

pytestmark = [pytest.mark.slow, pytest.mark.waits]
LEAST = 10
"""So many samples in each socket are the fewest that are enough."""
BLOCK = 6
"""So many samples are taken in a socket before it is the other's turn."""
CHANGES = (2 * BLOCK, LEAST + BLOCK)
"""Numbers of samples after which the ball is moved over, to socket 0 and to socket 1."""
BEGUN = 2 * BLOCK - 2
"""So many samples a session has that is continued."""
ASTRAY = 2 * BLOCK + 2
"""After so many samples the arm goes astray first: half a radian, to where no socket is."""
GOAL = ("--goal-mm", "20")
PACE = "rate=40&move=1.5&speed=3"
LED_ARM = Path(__file__).parents[2] / "led_arm.py"


@pytest.fixture(scope="module")
def hands(shared):
    """Where a hand leads the arm: a session's begin, and its rest, once astray."""

    def make(folder):
        panda = mukca.load_robot("panda")
        _, (placement,) = mukca.simulate_recordings(panda, 1, samples=LEAST, seed=1)
        first, second = (placement.positions[placement.sockets == k].tolist() for k in (0, 1))
        elsewhere = [first[0][0] - math.copysign(0.5, first[0][0]), *first[0][1:]]
        whole = first[:BLOCK] + second[:BLOCK] + first[BLOCK:] + second[BLOCK:]
        write_rows(folder / "begin.csv", whole[:BEGUN])
        write_rows(folder / "rest.csv", [*whole[BEGUN:ASTRAY], elsewhere, *whole[ASTRAY:]])

    return shared("guided_hands", make)


def led(steps, hand, out, pace, *more):
    """Return a command that records an arm, which rests until it is led on."""
    steps.touch()
    driver = f"mock:{hand}?{pace}"
    words = ["record", "--robot", "panda", "--driver", driver, "--out", str(out)]
    words += ["--distance", "0.05", *more]
    return [sys.executable, str(LED_ARM), str(steps), *words]


def lead_on(steps, to=()):
    """Lead the arm to its next configuration, or to one that is given [rad]."""
    with steps.open("a") as file:
        file.write(",".join(map(repr, to)) + "\n")


def test_a_guided_session_of_a_calibrated_arm_tells_which_zero_changed(simulated, cal, tmp_path):
    """A hand follows what the screen says of a zero 3 mrad off; the verdict comes at the end."""
    hand, out, steps = tmp_path / "hand.csv", tmp_path / "since", tmp_path / "steps"
    zero, starts = 3e-3 * np.eye(7)[3], simulated.later.positions[[0, 8]]
    centres, at = simulated.truth.ball(starts), starts[0]
    hand.write_text(",".join(map(repr, (at - zero).tolist())))
    words = led(steps, hand, out, PACE, "--calibration", str(cal))
    with TerminalSession(words, columns=200, rows=30) as terminal:
        for number in range(1, 2 * BLOCK + 1):
            socket = int(number > BLOCK)
            if number == BLOCK + 1:
                terminal.wait_for("SOCKET 1 NOW")
                terminal.press("s")
                terminal.wait_for("socket 1 is active")
                at = starts[1]
            elif number > 1:
                at = in_socket(simulated.truth, at + turns_asked(terminal), centres[socket])
            if number > 1:
                lead_on(steps, (at - zero).tolist())
            terminal.wait_for(f"PRESS: space captures sample {number}")
            terminal.press(" ")
            terminal.wait_for(f"captured sample {number}: ")
        shown = terminal.wait_for("ENOUGH: q finishes", "predicted 0.", "mrad", "goal 0.")
        predicted, goal = map(float, re.findall(r"(?:predicted|goal) ([0-9.]+)", shown))
        assert predicted <= goal < 0.2
        terminal.press("q")
        assert terminal.wait() == 1
        terminal.wait_for(
            "nearest cause panda_joint4", "This finds the joint's new zero: mukca rezero"
        )
    assert np.bincount(read(out).sockets).tolist() == [BLOCK, BLOCK]


def turns_on(shown):
    """Return by how much a screen says to turn each joint [rad]."""
    found = np.zeros(7)
    for joint, way, angle in re.findall(r"panda_joint(\d)\s+(up|down)\s+by\s+([0-9.]+)°", shown):
        found[int(joint) - 1] = math.radians(float(angle)) * (1 if way == "up" else -1)
    return found


def turns_asked(terminal):
    """Return the same of a whole drawing, once it says where to go on from the last sample."""
    deadline, least = time.monotonic() + PATIENCE, math.radians(1)
    seen, drawings = None, 0
    while time.monotonic() < deadline:
        begun, turns = terminal.output.count(b"last state"), turns_on(terminal.text)
        if seen is None or (turns != seen).any():
            seen, drawings = turns, begun
        elif np.abs(turns).max() > least and begun > drawings + 1:  # one was begun and ended since
            return turns
        time.sleep(0.02)
    raise AssertionError(terminal.text)


def in_socket(arm, q, centre):
    """Return the configuration near another in which an arm's ball is in a socket [rad]."""
    for _ in range(8):
        there, *moved = arm.ball(np.vstack([q, q + 1e-6 * np.eye(len(q))]))
        slopes = (np.array(moved) - there).T / 1e-6
        q = q + np.linalg.pinv(slopes) @ (centre - there)
    return q


def test_an_so101_is_led_in_practice_to_its_end(tmp_path):
    """From what was recorded before, by the keys that the screen names."""
    robot = mukca.load_robot("so101")
    noise = {"noise": 1e-4, "zeros": 0.05}
    _, (front,) = mukca.simulate_recordings(robot, 1, samples=12, seed=2, **noise)
    hand, out = tmp_path / "so101" / "front", tmp_path / "recordings" / "front"
    write_files(hand, sample_files(front))
    samples = [*front.samples[:10], *front.samples[12:22]]
    write_files(out, sample_files(replace(front, samples=tuple(samples))))
    words = [*MUKCA, "record", "--robot", "so101", "--distance", "0.05", "--out", str(out)]
    words += ["--driver", f"mock:{hand}?follow&rate=100&speed=4"]
    with TerminalSession(words, columns=100) as terminal:
        terminal.wait_for("GO ON?", "Continues 10 in socket 0, 10 in socket 1")
        terminal.press("y")
        socket, number, end = front.samples[21].socket, len(samples) + 1, "base elsewhere"
        while True:
            asked = (f"space captures sample {number}", "then press s", "k keep", end)
            (text,) = terminal.wait_for_either(*((text,) for text in asked))
            if text == end:
                break
            terminal.press({"then press s": "s", "k keep": "k"}.get(text, " "))
            if text == asked[1]:
                socket = 1 - socket
                terminal.wait_for(f"socket {socket} is active")
            elif text == asked[2]:
                terminal.wait_for("kept as it is")
            else:
                terminal.wait_for_either((f"captured sample {number}: ",), ("then press s",))
                number += 1
        terminal.press("q")
        assert terminal.wait() == 0
        terminal.wait_for("mukca solve", "--robot so101 --zeros")
    taken = read(out).sockets
    assert len(samples) < len(taken) <= 40 and min(np.bincount(taken)) >= LEAST


def test_a_session_goes_on_hands_free_with_the_page_in_a_browser(hands, tmp_path, scripted, tab):
    """It says where to go, changes sockets, takes nothing astray, and ends."""
    out, steps = tmp_path / "front", tmp_path / "steps"
    keys = f"a*{BLOCK} 1 a*{BEGUN - BLOCK} q"
    assert scripted(out, keys, hand=hands / "begin.csv").status == 0
    pace = "rate=100&move=0.6&speed=3"
    words = led(steps, hands / "rest.csv", out, pace, *GOAL, "--auto", "--page")
    tab.set_default_timeout(1000 * PATIENCE)
    with TerminalSession(words) as terminal:
        terminal.wait_for("GO ON?", f"Continues {BLOCK} in socket 0, {BEGUN - BLOCK} in socket")
        terminal.press("y")
        url = re.search(r"http://\S+/", terminal.wait_for("page: http", "SOCKET 1 NOW"))
        assert url
        complaints = []
        tab.on("console", lambda message: complaints.append(message.text))
        tab.on("pageerror", lambda error: complaints.append(str(error)))
        tab.goto(url[0])
        tab.wait_for_selector("text=SOCKET 1 NOW")
        terminal.press(" ")
        tab.wait_for_selector("text=/GOT \\d/")
        tab.wait_for_selector("canvas[data-drawn='arm and ghost']")
        for number in range(BEGUN + 1, 2 * LEAST):
            if number in CHANGES:
                if number == 2 * BLOCK:
                    tab.wait_for_selector("text=SOCKET 0 NOW")
                    terminal.wait_for("enough here: ball to socket 0, then press s")
                terminal.press("s")
                terminal.wait_for(f"socket {CHANGES.index(number)} is active")
            lead_on(steps)
            if number == ASTRAY:
                terminal.wait_for("puts the ball")
                lead_on(steps)
            terminal.wait_for(f"captured sample {number + 1}: ")
            if number == ASTRAY:
                terminal.wait_for("predicted", "goal 20.00", "next best", "◆", "mean")
        terminal.wait_for("ENOUGH: q finishes", "the goal is reached", "missed 0")
        tab.wait_for_selector("text=ENOUGH")
        assert tab.locator("#facts").inner_text().startswith("predicted error of distances")
        assert tab.locator(".joint").count() == 7
        assert not complaints  # until the session ends: then there is no link
        terminal.press("q")
        assert terminal.wait() == 0
        terminal.wait_for("mukca check", "mukca solve")
        tab.wait_for_selector("text=ENDED")
    taken = read(out)
    astray = np.loadtxt(hands / "rest.csv", delimiter=",")[ASTRAY - BEGUN, 0]
    assert np.abs(taken.positions[:, 0] - astray).min() > 0.01
    assert np.bincount(taken.sockets).tolist() == [LEAST, LEAST]
