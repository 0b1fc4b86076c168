"""A read-only page for a tablet beside the arm, and the worker process that serves it."""

import json
import os
import secrets
import socket
import threading
from collections.abc import Mapping
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from ...drivers import clock
from ...recorder.session import View
from ...solver.calibration import UsageError
from ...solver.identification.robot import load_robot
from ..cli import RobotOptions
from .guidance_process import WorkerProcess

LINGER = 1.5
"""Time in which browsers are still told that the session ended [s]."""
MOST_CONNECTIONS = 30
DIGITS = 3
"""Of positions [rad], [m]: an arm at rest is not drawn again and again for its noise."""
EVERYWHERE = ("0.0.0.0", "")  # noqa: S104 - only where the operator asks for it
HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; "
    "script-src 'unsafe-inline'; connect-src 'self'; img-src data:",
}


class PageProcess(WorkerProcess):
    """Worker process that serves the page; call it with a view to show it."""

    def __init__(self, robot: RobotOptions, host: str) -> None:
        super().__init__(_serve, robot.model_arguments(), host)
        self._sent: dict[str, Any] = {}
        url: str | None = None
        while url is None and self.trouble is None:
            url = self.answer(wait=1.0)
        if url is None:
            self.close()
            raise UsageError(f"--page-host {host}: no page can be served there")
        self.url = url

    def close(self) -> None:
        """Let browsers know of the end, and end it; safe to call twice."""
        self._pipe.close()
        self._process.join(LINGER + 1.0)
        super().close()

    def __call__(self, view: View) -> None:
        """Send a view that shows something new, unless one is still being taken in; never waits."""
        self.answer()
        state = state_of(view)
        if self.idle and state != self._sent:
            self.send(state)
            self._sent = state


def state_of(view: View) -> dict[str, Any]:
    """Return the contents of the page for a view."""
    session = view.session
    advice = view.advice
    of_advice = {
        "next": "target",
        "goal": "goal",
        "unit": "unit",
        "mean": "mean_error",
        "last": "last_error",
    }
    return {
        "title": view.title,
        "words": view.prompt.words,
        "large": view.large,
        "colour": view.prompt.colour,
        "reason": view.prompt.reason,
        "socket": session.socket,
        "counts": session.counts,
        "target": session.asked,
        "joints": [
            (j.name, max(j.lower, -3.2), min(j.upper, 3.2), j.prismatic)
            for j in session.joints
        ],
        "position": view.position and [round(q, DIGITS) for q in view.position],
        **{key: getattr(advice, name, None) for key, name in of_advice.items()},
        "predicted": advice.predicted if advice and advice.is_informative else None,
        "closing": advice.closing if advice else (),
        "messages": [(m.text, m.alarm) for m in session.messages[-4:]],
    }


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    request_queue_size = MOST_CONNECTIONS

    def __init__(self, host: str, port: int, token: str) -> None:
        super().__init__((host, port), _Handler)
        self.token = token
        self.page = (Path(__file__).parent / "page.html").read_bytes()
        self.state = b"{}"
        self.asked = -LINGER
        """When a browser asked for the state."""
        self.trusted: dict[socket.socket, bool] = {}
        """Open connections, the oldest first: whether the address was known there."""
        port = self.server_address[1]
        reachable = _reachable(host)
        this = socket.gethostname().lower()
        self.names = {"localhost", host.lower(), reachable, this, f"{this}.local"}
        self.url = f"http://{reachable}:{port}/{self.token}/"

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a connection; beyond the bound, close a stranger's for it, or refuse it."""
        if len(self.trusted) >= MOST_CONNECTIONS:
            strangers = (c for c, trusted in [*self.trusted.items()] if not trusted)
            stranger = next(strangers, None)
            if stranger is None:
                self.shutdown_request(request)
                return
            self.trusted.pop(stranger, None)
            with suppress(OSError):
                stranger.shutdown(socket.SHUT_RDWR)
        self.trusted[request] = False
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """Close a connection."""
        self.trusted.pop(request, None)
        super().shutdown_request(request)

    def end(self, state: Mapping[str, Any]) -> None:
        """Tell browsers that the session ended, if any asked a moment ago."""
        self.state = json.dumps({**state, "ended": True}).encode()
        if clock.now() - self.asked < LINGER:
            clock.sleep(LINGER)


def _server(host: str) -> _Server:
    """Return a server at the address of the start before, if that is free."""
    port, secret = kept_address()
    if port:
        with suppress(OSError):
            return _Server(host, port, secret)
    server = _Server(host, 0, secret)
    if not port:
        keep_address(server.server_address[1], secret)
    return server


def _reachable(host: str) -> str:
    """Return the address of this computer by which others reach a server at a host."""
    if host not in EVERYWHERE:
        return host
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # nothing is sent; it chooses the way out
        except OSError:
            return host
        return str(probe.getsockname()[0])


class _Handler(BaseHTTPRequestHandler):
    server: _Server  # pyright: ignore[reportIncompatibleVariableOverride]
    protocol_version = (
        "HTTP/1.1"  # one connection a browser, though it asks again and again
    )
    timeout = 10.0

    def do_GET(self) -> None:
        """Send the page, or the state that it asks for again and again."""
        if not self._is_own():
            self.send_error(421)
            return
        root, _, name = self.path.removeprefix("/").partition("/")
        authorised = secrets.compare_digest(root.encode(), self.server.token.encode())
        if not authorised or name not in ("", "state"):
            self.send_error(404)
            return
        self.server.trusted[self.connection] = True
        body = self.server.state if name else self.server.page
        self.send_response(200)
        kind = "application/json" if name else "text/html; charset=utf-8"
        headers = {"Content-Type": kind, "Content-Length": str(len(body)), **HEADERS}
        for header, value in headers.items():
            self.send_header(header, value)
        self.end_headers()
        self.wfile.write(body)
        if name:
            self.server.asked = clock.now()

    def _is_own(self) -> bool:
        """Return whether the address names this computer: another site's name may lead here."""
        try:
            name = urlsplit(f"//{self.headers.get('Host', '')}").hostname
        except ValueError:
            return False
        return name in {*self.server.names, self.connection.getsockname()[0]}

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002
        """Say nothing: the terminal is the recorder's."""


def _serve(pipe: Connection, robot: Mapping[str, Any], host: str) -> None:
    import numpy as np

    from ...solver.identification.robot import link_poses

    joints = load_robot(**robot).joints
    server = _server(host)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    pipe.send(server.url)
    state: dict[str, Any] = {}
    with suppress(EOFError, OSError):  # the recorder ended, or crashed
        while True:
            state = pipe.recv()
            for name in ("position", "next"):
                if state[name] is not None:
                    drawn = link_poses(joints, np.array([state[name]]))[0, :, :, 3]
                    state[f"{name}_drawn"] = drawn.round(4).tolist()
            server.state = json.dumps(state).encode()
            pipe.send({})
    server.end(state)


LETTERS, LENGTH = "abcdefghijkmnpqrstuvwxyz23456789", 12
"""Of a secret that nobody can guess, and that can be typed into a tablet: 60 bits."""


def kept_address() -> tuple[int, str]:
    """Return port and secret of the start before, or 0 for any free port and a new secret."""
    with suppress(OSError, RuntimeError, ValueError, TypeError, KeyError):
        entries = json.loads(_file().read_text())
        port, secret = int(entries["port"]), str(entries["secret"])
        if len(secret) >= LENGTH and 0 < port < 1 << 16:
            return port, secret
    return 0, "".join(secrets.choice(LETTERS) for _ in range(LENGTH))


def keep_address(port: int, secret: str) -> None:
    """Keep an address where this user alone can read it, if that can be written."""
    with suppress(OSError, RuntimeError):
        file = _file()
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch(mode=0o600)
        file.write_text(json.dumps({"port": port, "secret": secret}))


def _file() -> Path:
    state = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(state) / "mukca" / "page.json"
