"""Whole guided sessions in a real terminal, by keys and hands free, and the page beside one."""

import re
import shutil
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from terminal_session import PATIENCE, TerminalSession

from mukca.recorder import read_placement, sample_files, write_holes
from mukca.solver.robot import Robot
from mukca.tools.recording.guidance import MIN_ENOUGH as LEAST
from mukca.tools.simulation import Base, record

pytestmark = [pytest.mark.slow, pytest.mark.waits]
LEFT = 2
"""So many samples a session that is continued lacks in each socket."""
ASTRAY = 0.5
"""So far the first joint is turned to where no socket is [rad]."""
LED_ARM = Path(__file__).parents[2] / "led_arm.py"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


@pytest.fixture(scope="module")
def hands(true_panda: Robot, shared: Callable[..., Path]) -> Path:
    """Where a hand leads the arm: for all of a session, for the rest of one, and once astray."""

    def make(folder: Path) -> None:
        base = Base("front", np.array([0.5, 0.0, 0.1]), np.array([0.0, 1.0, 0.0]))
        led = record(true_panda, base, np.random.default_rng(1), samples=LEAST, noise=5e-5)
        first, second = ([s for s in led.samples if s.socket == k] for k in (0, 1))
        q = first[0].position
        astray = replace(second[0], position=(q[0] + ASTRAY, *q[1:]))
        write_holes(led, folder / "all")
        rest = (*first[:LEFT], *second[:LEFT])
        write_holes(replace(led, samples=rest), folder / "rest")
        way = (*first, *second[:2], astray, *second[2:])
        write_holes(replace(led, samples=way), folder / "astray")

    return shared("guided_hands", make)


@pytest.fixture
def begun(session: Path, panda: Robot, tmp_path: Path) -> Path:
    """A recording that lacks a few samples in each socket, the ball in socket 0."""
    earlier = read_placement(session / "front")
    sockets = [[s for s in earlier.samples if s.socket == k][: LEAST - LEFT] for k in (1, 0)]
    taken = replace(earlier, samples=(*sockets[0], *sockets[1]), joint_names=panda.joint_names)
    folder = tmp_path / "front"
    folder.mkdir()
    for name, content in sample_files(taken).items():
        (folder / name).write_bytes(content)
    return folder


def led(steps: Path, hand: Path, out: Path, pace: str, *more: str) -> list[str]:
    """Return a command that records an arm, which rests until it is led on."""
    steps.touch()
    driver = f"mock:{hand}?{pace}"
    words = ["record", "--robot", "panda", "--driver", driver, "--out", str(out)]
    return [sys.executable, str(LED_ARM), str(steps), *words, "--goal-mm", "20", *more]


@pytest.mark.parametrize("part", ["all", "rest"])
def test_a_guided_session_by_keys(hands: Path, begun: Path, tmp_path: Path, part: str) -> None:
    """A new one, and one that goes on: it changes sockets, says where to go next, and ends."""
    done = 0 if part == "all" else LEAST - LEFT
    out = begun if done else tmp_path / "new"
    steps = tmp_path / "steps"
    words = led(steps, hands / part, out, "rate=250&move=0.25")
    with TerminalSession(words) as terminal:
        if done:
            terminal.wait_for("GO ON?", f"Continues {done} in socket 0, {done} in socket 1")
            terminal.press("y")
        for number in range(2 * done + 1, 2 * LEAST + 1):
            if number == done + LEAST + 1:
                terminal.wait_for("SOCKET 1 NOW: enough here: ball to socket 1, then press s")
                terminal.press("s")
                terminal.wait_for("socket 1 is active")
            if number > 2 * done + 1:
                lead_on(steps)
            terminal.wait_for(f"PRESS: space captures sample {number}")
            terminal.press(" ")
            terminal.wait_for(f"GOT {number}")
            if number == 2 * LEAST - 1:
                terminal.wait_for("predicted", "goal 20.00", "next best", "◆", "mean")
        shown = terminal.wait_for("ENOUGH: q finishes", "the goal is reached", "second placement")
        assert "last" in shown and "mean" in shown
        terminal.press("q")
        assert terminal.wait() == 0
        terminal.wait_for("mukca check", "mukca solve")
    assert np.bincount(read_placement(out).sockets).tolist() == [LEAST, LEAST]


def lead_on(steps: Path) -> None:
    """Lead the arm to its next configuration."""
    with steps.open("ab") as file:
        file.write(b".")


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium: apt-get install chromium")
def test_hands_free_with_the_page_in_a_browser(hands: Path, tmp_path: Path) -> None:
    playwright = pytest.importorskip("playwright.sync_api")
    out = tmp_path / "front"
    steps = tmp_path / "steps"
    pace = "rate=100&move=0.6&speed=3"
    words = led(steps, hands / "astray", out, pace, "--auto", "--page")
    options = ["--headless", "--no-sandbox", "--disable-gpu"]
    with playwright.sync_playwright() as player:
        browser = player.chromium.launch(executable_path=CHROMIUM, args=options)
        page = browser.new_page()
        page.set_default_timeout(1000 * PATIENCE)
        with TerminalSession(words) as terminal:
            url = re.search(r"http://\S+/", terminal.wait_for("page: http", "SOCKET 0 NOW"))
            assert url
            complaints: list[str] = []
            page.on("console", lambda message: complaints.append(message.text))
            page.on("pageerror", lambda error: complaints.append(str(error)))
            page.goto(url[0])
            page.wait_for_selector("text=SOCKET 0 NOW")
            terminal.press(" ")
            page.wait_for_selector("text=/GOT \\d/")
            page.wait_for_selector("canvas[data-drawn='arm and ghost']")
            for number in range(1, LEAST):
                lead_on(steps)
                terminal.wait_for(f"captured sample {number + 1}: ")
                if number == LEAST - 2:
                    terminal.wait_for("predicted", "next best", "◆")
            terminal.wait_for("SOCKET 1 NOW")
            page.wait_for_selector("text=SOCKET 1 NOW")
            terminal.press("s")
            terminal.wait_for("socket 1 is active")
            for number in range(LEAST, 2 * LEAST):
                lead_on(steps)
                if number == LEAST + 2:
                    terminal.wait_for("puts the ball")
                    lead_on(steps)
                terminal.wait_for(f"captured sample {number + 1}: ")
            terminal.wait_for("ENOUGH")
            page.wait_for_selector("text=ENOUGH")
            assert page.locator("#facts").inner_text().startswith("predicted error of distances")
            assert page.locator(".joint").count() == 7
            terminal.press("q")
            assert terminal.wait() == 0
            terminal.wait_for("missed 0")
        browser.close()
    assert not complaints
    taken = read_placement(out)
    sockets, turns = taken.sockets, taken.positions[:, 0]
    astray = read_placement(hands / "astray").positions[LEAST + 2, 0]
    assert np.abs(turns - astray).min() > 0.01
    assert (sockets == 0).sum() == (sockets == 1).sum() == LEAST
