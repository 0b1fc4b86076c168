"""The page beside the arm: read-only, behind a token, nothing from elsewhere, and live."""

import http.client
import json
import re
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from urllib.parse import urlsplit

import pytest

import mukca.tools.recording.page as page_module
from mukca.recorder import Sample
from mukca.recorder.session import Advice, Session, View
from mukca.recorder.session.operator_prompt import OperatorPrompt
from mukca.recorder.stream import JointLimits
from mukca.tools.recording.page import Board, Server, state_of


@pytest.fixture
def server() -> Iterator[Server]:
    server = Server("127.0.0.1", Board())
    thread = threading.Thread(target=server.serve_forever, args=(0.05,))
    thread.start()
    yield server
    server.shutdown()
    thread.join()
    server.server_close()


def ask(server: Server, path: str, method: str = "GET") -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection(*server.server_address[:2], timeout=10)
    connection.request(method, path)
    return connection.getresponse()


def test_the_page_is_behind_a_token_and_read_only(server: Server) -> None:
    path = urlsplit(server.url).path
    assert len(server.token) >= 20
    response = ask(server, path)
    assert response.status == 200 and b"EventSource" in response.read()
    assert "default-src 'none'" in str(response.getheader("Content-Security-Policy"))
    for wrong in ("/", "/x/", path + "x", "/" + "x" * len(server.token) + "/", path[:-2] + "/"):
        assert ask(server, wrong).status == 404
    for method in ("POST", "PUT", "DELETE", "OPTIONS"):
        assert ask(server, path, method).status == 501


def test_nothing_is_loaded_from_elsewhere() -> None:
    text = Path(page_module.__file__).with_name("page.html").read_text()
    assert not re.search(r"https?:|//[a-z]|src=|@import|url\(", text)


def test_a_state_reaches_a_browser(server: Server) -> None:
    joints = (JointLimits("elbow"), JointLimits("rail", 0.0, 0.5, prismatic=True))
    session = Session(joints).captured(Sample((0.1, 0.2), 0, number=1)).with_message("<b>hi</b>")
    advice = Advice(3, 0, 4e-4, 3e-4, target=(0.5, 0.3))
    view = View(session, "arm", OperatorPrompt("PRESS", "dark_green", "now"), (0.1, 0.2), advice)
    response = ask(server, urlsplit(server.url).path + "events")
    assert response.readline() == b"data: {}\n" and response.readline() == b"\n"
    server.board.post(json.dumps(state_of(view)))
    said = json.loads(response.readline().removeprefix(b"data: "))
    assert said["words"] == "PRESS" and list(said["counts"]) == [1, 0]
    assert said["next"] == [0.5, 0.3] and said["messages"] == [["<b>hi</b>", False]]
    assert said["predicted"] == 4e-4
    assert said["joints"][0] == ["elbow", -3.2, 3.2, False]
    response.close()
    assert state_of(replace(view, advice=replace(advice, count=2)))["predicted"] is None
