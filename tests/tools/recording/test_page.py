"""The page beside the arm: read-only, behind a token, nothing from elsewhere, and live."""

import http.client
import json
import re
import socket
import time
from contextlib import ExitStack, closing
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from record_commands import capture, command
from terminal_session import PATIENCE, TerminalSession

import mukca

pytestmark = [pytest.mark.slow, pytest.mark.waits]


def ask(url, path, method="GET"):
    """The status, the headers and the body of an answer."""
    with closing(http.client.HTTPConnection(url.hostname, url.port, timeout=PATIENCE)) as asked:
        asked.request(method, path)
        answer = asked.getresponse()
        return answer.status, answer.headers, answer.read().decode()


def awaited(url, condition):
    """The first view that a browser is shown of which a condition is true."""
    end = time.monotonic() + PATIENCE
    while not condition(view := json.loads(ask(url, url.path + "state")[2])):
        assert time.monotonic() < end, view
        time.sleep(0.05)
    return view


def test_the_page_is_live_read_only_and_behind_a_token(hand, tmp_path):
    with TerminalSession(command(hand, tmp_path / "front", "--page"), columns=120) as terminal:
        found = re.search(r"http://\S+/", terminal.wait_for("page: http"))
        assert found
        url = urlsplit(found[0])
        path, token = url.path, url.path.strip("/")
        assert url.hostname == "127.0.0.1" and len(token) >= 12
        status, headers, text = ask(url, path)
        assert status == 200 and "fetch" in text
        assert not re.search(r"https?:|//[a-z]|src=|@import|url\(|innerHTML", text)
        assert "default-src 'none'" in headers["Content-Security-Policy"]
        for wrong in ("/", "/x/", path + "x", "/" + "x" * len(token) + "/", path[:-2] + "/"):
            assert ask(url, wrong)[0] == 404
        for method in ("POST", "PUT", "DELETE", "OPTIONS"):
            assert ask(url, path, method)[0] == 501
        capture(terminal, "a", "captured sample 1")
        view = awaited(url, lambda view: view.get("counts") == [1, 0])
        assert view["words"] in ("GOT 1", "MOVE") and (view["socket"], view["target"]) == (0, "30")
        assert view["messages"][-1] == ["captured sample 1: 1 in socket 0", False]
        assert view["predicted"] is None and view["next"] is None
        name, lower, upper, prismatic = view["joints"][0]
        assert (name, prismatic) == ("panda_joint1", False) and -3 < lower < 0 < upper < 3
        assert len(view["position_drawn"]) > 7
        terminal.press("q")
        assert awaited(url, lambda view: view.get("ended"))["counts"] == [1, 0]
        assert terminal.wait() == 0
    assert len(mukca.read_placements(tmp_path / "front")[0].samples) == 1


def served(hand, out):
    """A session with a page, and the address of that."""
    terminal = TerminalSession(command(hand, out, "--page"), columns=120)
    found = re.search(r"http://\S+/", terminal.wait_for("page: http"))
    return terminal, found[0]


def test_a_crash_is_told_and_a_restart_has_the_same_address(hand, tmp_path):
    terminal, address = served(hand, tmp_path / "front")
    url = urlsplit(address)
    with terminal:
        awaited(url, lambda view: view.get("words"))
        terminal.process.kill()
        assert awaited(url, lambda view: view.get("ended"))["words"]
    (file,) = (tmp_path / "state").rglob("page.json")
    assert file.stat().st_mode & 0o077 == 0
    deadline = time.monotonic() + PATIENCE
    with pytest.raises(ConnectionRefusedError):
        while time.monotonic() < deadline:
            socket.create_connection((url.hostname, url.port)).close()
    terminal, again = served(hand, tmp_path / "front")
    with terminal:
        assert again == address
        beside, other = served(hand, tmp_path / "left")
        with beside:
            assert urlsplit(other).port != url.port and awaited(urlsplit(other), lambda view: view)


def test_a_name_that_is_not_its_own_and_connections_beyond_a_bound_are_refused(hand, tmp_path):
    terminal, address = served(hand, tmp_path / "front")
    url = urlsplit(address)
    with terminal, ExitStack() as stack:
        for name, status in (("evil.test", 421), ("[", 421), ("", 421), ("localhost", 200)):
            with closing(http.client.HTTPConnection(url.hostname, url.port)) as asked:
                asked.request("GET", url.path, headers={"Host": name})
                assert asked.getresponse().status == status
        tablet = stack.enter_context(closing(http.client.HTTPConnection(url.hostname, url.port)))
        sockets = []
        for _ in range(300):
            tablet.request("GET", url.path + "state")
            assert tablet.getresponse().read()
            sockets.append(socket.create_connection((url.hostname, url.port), timeout=PATIENCE))
            stack.callback(sockets[-1].close)
        assert ask(url, url.path + "state")[0] == 200  # another tablet
        for closed in sockets[-60:-30]:
            closed.settimeout(3.0)  # an idle one is closed after ten
            assert closed.recv(1) == b""


def test_the_page_shows_the_arm_large_and_the_joint_to_move(tab):
    page_file = Path(mukca.__file__).parent / "tools/recording/page.html"
    span = Path(__file__).with_name("span.js").read_text().partition("\n")[2]
    state = Path(__file__).with_suffix(".json").read_text()
    tab.route("**/x/", lambda way: way.fulfill(path=page_file, content_type="text/html"))
    tab.route("**/state", lambda way: way.fulfill(body=state, content_type="application/json"))
    for width, height in ((1280, 800), (390, 844)):
        tab.set_viewport_size({"width": width, "height": height})
        tab.goto("http://page.test/x/")
        tab.wait_for_selector("canvas[data-drawn='arm and ghost']")
        assert tab.evaluate("document.documentElement.scrollWidth") <= width
        assert max(tab.evaluate(span)) > 0.7
        name = tab.locator(".joint.move span").first
        assert name.inner_text() == "J1 openarm_right_joint1"  # none shipped is longer
        assert name.bounding_box()["height"] < 30
        assert tab.locator(".joint.move").count() == 1
        assert tab.locator("#joints").bounding_box()["y"] < height - 220  # for seven joints
        counts = [row.bounding_box() for row in tab.locator("#counts div").all()]
        assert len(counts) == 2 and counts[0]["y"] == counts[1]["y"] and counts[0]["height"] < 30
        assert "y yes, go on   n new placement" in tab.locator("#reason").inner_text()
        assert "the best next pose" in tab.locator("#legend").inner_text()
        tab.locator("summary").click()
        assert "MOVE the arm" in tab.locator("details").inner_text()
