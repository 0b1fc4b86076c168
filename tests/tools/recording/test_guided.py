"""Whole guided sessions in a real terminal, by keys and hands free, and the page beside one."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from terminal_session import MUKCA, TerminalSession

from mukca.recorder.convert import write_holes
from mukca.recorder.dataset import read_placement
from mukca.solver.robot.urdf import Robot
from mukca.tools.recording.coach import LEAST, SHARE
from mukca.tools.simulated_arms import Base, record

pytestmark = pytest.mark.slow
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


@pytest.fixture(scope="module")
def hand(true_panda: Robot, shared: Callable[..., Path]) -> Path:
    """Where a hand leads the arm: as many poses in each socket as a guided session asks for."""

    def make(folder: Path) -> None:
        base = Base("front", np.array([0.5, 0.0, 0.1]), np.array([0.0, 1.0, 0.0]))
        led = record(true_panda, base, np.random.default_rng(1), samples=SHARE + 4, noise=5e-5)
        write_holes(led, folder)

    return shared("guided_hand", make)


def command(hand: Path, out: Path, *more: str) -> list[str]:
    driver = f"mock:{hand}?rate=500&hold=1.6&move=0.6"
    words = ["record", "--robot", "panda", "--driver", driver, "--out", str(out)]
    return [*MUKCA, *words, "--goal-mm", "20", *more]


def test_a_guided_session_by_keys(hand: Path, tmp_path: Path) -> None:
    out = tmp_path / "front"
    with TerminalSession(command(hand, out), columns=80, rows=24) as terminal:
        for number in range(1, SHARE + LEAST + 1):
            terminal.wait_for(f"PRESS: space captures sample {number}")
            terminal.press(" ")
            terminal.wait_for(f"GOT {number}")
            if number == 2:
                terminal.wait_for("predicted", "next best", "◆")
            if number == SHARE:
                terminal.wait_for("SOCKET 1 NOW: move the ball to socket 1")
                terminal.press("s")
        shown = terminal.wait_for("ENOUGH: q finishes", "goal 20.00", "A second placement near")
        assert "last" in shown and "mean" in shown
        terminal.press("q")
        assert terminal.wait() == 0
        terminal.wait_for("mukca check", "mukca solve")
    assert len(read_placement(out).samples) == SHARE + LEAST


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium: apt-get install chromium")
def test_hands_free_with_the_page_in_a_browser(hand: Path, tmp_path: Path) -> None:
    playwright = pytest.importorskip("playwright.sync_api")
    out = tmp_path / "front"
    words = command(hand, out, "--auto", "--page")
    with TerminalSession(words) as terminal, playwright.sync_playwright() as player:
        url = re.search(r"http://\S+/", terminal.wait_for("page: http", "SOCKET 0 NOW"))
        assert url
        options = ["--headless", "--no-sandbox", "--disable-gpu"]
        browser = player.chromium.launch(executable_path=CHROMIUM, args=options)
        page = browser.new_page()
        complaints: list[str] = []
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.goto(url[0])
        page.wait_for_selector("text=SOCKET 0 NOW")
        terminal.press(" ")
        page.wait_for_selector("text=/GOT \\d/")
        page.wait_for_selector("canvas[data-drawn='arm and ghost']", timeout=60_000)
        terminal.wait_for("SOCKET 1 NOW", timeout=120)
        page.wait_for_selector("text=SOCKET 1 NOW")
        terminal.press("s")
        terminal.wait_for("ENOUGH", timeout=120)
        page.wait_for_selector("text=ENOUGH")
        assert page.locator("#facts").inner_text().startswith("predicted error of distances")
        assert page.locator(".joint").count() == 7
        browser.close()
        terminal.press("q")
        assert terminal.wait() == 0
        terminal.wait_for("missed 0")
        assert not complaints
    sockets = read_placement(out).sockets
    assert (sockets == 0).sum() == SHARE and (sockets == 1).sum() >= LEAST
