"""A worker process that runs the pose selection, so that the recorder never waits for it."""

import math
import multiprocessing
import os
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from ...recorder.session import Advice, GuidanceRequest
from ...solver import calibration
from ...solver.identification.robot import load_robot
from ..cli import RobotOptions
from ..parallel import started_apart

NICE = 1
"""A worker gives way to the recorder, and has its share of a computer that others keep busy."""


class WorkerProcess:
    """A process that answers each message, and that a recorder never waits for."""

    def __init__(self, work: Callable[..., None], *setup: Any) -> None:
        self.trouble: str | None = None
        """Reason why it does not answer any more; None while it does."""
        self._busy = False
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(
            target=_run, args=(work, theirs, *setup), daemon=True
        )
        with started_apart():  # Ctrl-C is for the recorder
            self._process.start()
        theirs.close()
        self.pid = self._process.pid

    @property
    def idle(self) -> bool:
        """True while a message can be sent."""
        return not self._busy and self.trouble is None

    def send(self, message: Any) -> None:
        """Send a message to a process that is idle."""
        self._busy = True
        try:
            self._pipe.send(message)
        except OSError as error:
            self.trouble = f"it cannot be reached: {error.strerror}"

    def answer(self, wait: float = 0.0) -> Any:
        """Return the newest answer that has come since, or comes within some seconds, or None."""
        newest: Any = None
        try:
            while self.trouble is None and self._pipe.poll(wait):
                newest, wait, self._busy = self._pipe.recv(), 0.0, False
        except (EOFError, OSError):
            self.trouble = "its process ended"
        return newest

    def close(self) -> None:
        """End it; safe to call twice."""
        self.trouble = self.trouble or "it is closed"
        self._pipe.close()
        self._process.kill()  # it holds nothing that could be lost
        self._process.join()


def _run(work: Callable[..., None], pipe: Connection, *setup: Any) -> None:
    """Work in a session and quiet of its own until the recorder ends, and give way to it."""
    if sys.platform != "win32":
        os.setsid()
        os.nice(NICE)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nowhere, stream)
    with suppress(EOFError, OSError):
        work(pipe, *setup)


class BackgroundGuidance(WorkerProcess):
    """Guidance by a worker process, a ``GuidanceProvider``.

    Settings are those of a ``PoseSelector``, or with a ``calibration`` of a ``ZeroSelector``.
    """

    def __init__(self, robot: RobotOptions, **settings: Any) -> None:
        super().__init__(_advise, robot.model_arguments(), settings)

    def ask(self, request: GuidanceRequest) -> None:
        """Make a request; never waits."""
        self.send(request)

    def answer(self, wait: float = 0.0) -> Advice | None:
        """Return the newest advice that has come since; None without one."""
        advice: Advice | None = super().answer(wait)
        self._busy = self._busy or bool(advice and advice.early)
        return advice


def _advise(
    pipe: Connection, robot: Mapping[str, Any], settings: Mapping[str, Any]
) -> None:
    from .guidance import PoseSelector
    from .zero_guidance import ZeroSelector

    options = dict(settings)
    document: Path | None = options.pop("calibration", None)
    if document is None:
        selector = PoseSelector(load_robot(**robot), **options)
    else:
        selector = ZeroSelector(calibration.load_calibration(document), **options)
    closing: tuple[str, ...] = ()
    while True:
        request: GuidanceRequest = pipe.recv()
        samples = request.samples
        socket = request.socket
        answers = request.answers
        alarms = selector.alarms(samples, answers)
        if alarms:  # before what takes seconds
            pipe.send(
                Advice(len(samples), socket, math.inf, 0.0, alarms=alarms, early=True)
            )
        advice = selector.advise(samples, socket, request.position, answers)
        pipe.send(replace(advice, closing=closing))
        if (advice.enough or advice.exhausted) and not closing:
            closing = selector.closing(samples)
            pipe.send(replace(advice, closing=closing))
