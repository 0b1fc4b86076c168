"""The page beside the arm: read-only, behind a token, nothing from elsewhere, and live."""

import http.client
import json
import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import SplitResult, urlsplit

import pytest
from record_commands import capture, command
from terminal_session import PATIENCE, TerminalSession

import mukca

pytestmark = [pytest.mark.slow, pytest.mark.waits]


def ask(url: SplitResult, path: str, method: str = "GET") -> http.client.HTTPResponse:
    assert url.hostname
    connection = http.client.HTTPConnection(url.hostname, url.port, timeout=PATIENCE)
    connection.request(method, path)
    return connection.getresponse()


def views(events: http.client.HTTPResponse) -> Iterator[dict[str, object]]:
    """What a browser is told, view by view."""
    for line in events:
        if line.startswith(b"data: "):
            yield json.loads(line.removeprefix(b"data: "))


def test_the_page_is_live_read_only_and_behind_a_token(hand: Path, tmp_path: Path) -> None:
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
        assert view["messages"][-1] == ["captured sample 1: 1 in socket 0", False]  # pyright: ignore
        assert view["predicted"] is None and view["next"] is None
        name, lower, upper, prismatic = view["joints"][0]  # pyright: ignore
        assert (name, prismatic) == ("panda_joint1", False) and -3 < lower < 0 < upper < 3
        assert len(view["position_drawn"]) > 7  # pyright: ignore
        terminal.press("q")
        assert terminal.wait() == 0
    assert len(mukca.read_placements(tmp_path / "front")[0].samples) == 1
