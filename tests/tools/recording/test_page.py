"""The page beside the arm: read-only, behind a token, nothing from elsewhere, and live."""

import http.client
import json
import re
import shutil
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from record_commands import capture, command
from terminal_session import PATIENCE, TerminalSession

import mukca

pytestmark = [pytest.mark.slow, pytest.mark.waits]
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


def ask(url, path, method="GET"):
    connection = http.client.HTTPConnection(url.hostname, url.port, timeout=PATIENCE)
    connection.request(method, path)
    return connection.getresponse()


def views(events):
    """What a browser is told, view by view."""
    for line in events:
        if line.startswith(b"data: "):
            yield json.loads(line.removeprefix(b"data: "))


def test_the_page_is_live_read_only_and_behind_a_token(hand, tmp_path):
    with TerminalSession(command(hand, tmp_path / "front", "--page"), columns=120) as terminal:
        found = re.search(r"http://\S+/", terminal.wait_for("page: http"))
        assert found
        url = urlsplit(found[0])
        path, token = url.path, url.path.strip("/")
        assert url.hostname == "127.0.0.1" and len(token) >= 20
        page = ask(url, path)
        text = page.read().decode()
        assert page.status == 200 and "EventSource" in text
        assert not re.search(r"https?:|//[a-z]|src=|@import|url\(|innerHTML", text)
        assert "default-src 'none'" in str(page.getheader("Content-Security-Policy"))
        for wrong in ("/", "/x/", path + "x", "/" + "x" * len(token) + "/", path[:-2] + "/"):
            assert ask(url, wrong).status == 404
        for method in ("POST", "PUT", "DELETE", "OPTIONS"):
            assert ask(url, path, method).status == 501
        told = views(ask(url, path + "events"))
        capture(terminal, "a", "captured sample 1")
        view = next(view for view in told if view.get("counts") == [1, 0])
        assert view["words"] == "GOT 1" and view["socket"] == 0 and view["target"] == 30
        assert view["messages"][-1] == ["captured sample 1: 1 in socket 0", False]
        assert view["predicted"] is None and view["next"] is None
        name, lower, upper, prismatic = view["joints"][0]
        assert (name, prismatic) == ("panda_joint1", False) and -3 < lower < 0 < upper < 3
        assert len(view["position_drawn"]) > 7
        terminal.press("q")
        assert terminal.wait() == 0
    assert len(mukca.read_placements(tmp_path / "front")[0].samples) == 1


STATE = {
    "title": "panda", "words": "SOCKET 1 NOW", "colour": "magenta", "socket": 0, "counts": [6, 0],
    "reason": "enough here: ball to socket 1, then press s", "target": 30, "mean": 1e-4,
    "joints": [["panda_joint1", -2.9, 2.9, False], ["panda_joint2", -1.8, 1.8, False]],
    "position": [0.1, 0.2], "next": [1.1, 0.2], "predicted": 1e-3, "goal": 5e-4, "last": 2e-4,
    "closing": [], "messages": [["captured sample 6: 6 in socket 0", False]],
    "position_drawn": [[0, 0, 0], [0, 0, 0.33], [0.2, 0, 0.6], [0.5, 0, 0.1]],
    "next_drawn": [[0, 0, 0], [0, 0, 0.33], [0.1, 0.2, 0.6], [0.4, 0.3, 0.1]],
}  # fmt: skip
SPAN = """() => {
  const canvas = document.getElementById("arm"), c = canvas.getContext("2d");
  const { width, height } = canvas, data = c.getImageData(0, 0, width, height).data;
  let x0 = width, x1 = 0, y0 = height, y1 = 0;
  for (let y = 0; y < height; y++) for (let x = 0; x < width; x++) {
    const i = 4 * (y * width + x);
    if (data[i] > 150 && data[i + 3] > 100) {
      x0 = Math.min(x0, x); x1 = Math.max(x1, x); y0 = Math.min(y0, y); y1 = Math.max(y1, y);
    }
  }
  return [(x1 - x0) / width, (y1 - y0) / height];
}"""


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium: apt-get install chromium")
def test_the_page_shows_the_arm_large_and_the_joint_to_move():
    playwright = pytest.importorskip("playwright.sync_api")
    page_file = Path(mukca.__file__).parent / "tools/recording/page.html"
    told = f"data: {json.dumps(STATE)}\n\n"
    with playwright.sync_playwright() as player:
        browser = player.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page()
        page.route("**/x/", lambda way: way.fulfill(path=page_file, content_type="text/html"))
        page.route(
            "**/events", lambda way: way.fulfill(body=told, content_type="text/event-stream")
        )
        for width, height in ((1280, 800), (390, 844)):
            page.set_viewport_size({"width": width, "height": height})
            page.goto("http://page.test/x/")
            page.wait_for_selector("canvas[data-drawn='arm and ghost']")
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            assert max(page.evaluate(SPAN)) > 0.7
            assert page.locator(".joint.move span").first.inner_text() == "panda_joint1"
            assert page.locator(".joint.move").count() == 1
            assert "the best next pose" in page.locator("#legend").inner_text()
            page.locator("summary").click()
            assert "MOVE the arm" in page.locator("details").inner_text()
        browser.close()
