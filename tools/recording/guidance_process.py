"""A worker process beside the recorder that runs the pose selection, so that nothing waits.

The recorder and a worker exchange lines, each a JSON object; the first sets the worker up.
"""

import json
import os
import select
import subprocess
import sys
from collections.abc import Generator, Mapping
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ...recorder.session import Advice, GuidanceRequest
from ...solver.assessment import ARMS, RESOLUTION, known_arm
from ...solver.robot import Robot
from ..cli import RobotOptions

GOAL = 3.0
"""Ratio of the default goal to the arm's repeatability."""


class WorkerProcess:
    """A process that answers one line with one line, and that a recorder never waits for.

    It gets a line only after it has answered the one before, so the pipe between them never fills.
    It ends by itself when the recorder does, however that comes.

    Args:
        module: Its program, as in ``mukca.tools.recording.guidance_process``.
        setup: Its first line, which it does not answer.
    """

    def __init__(self, module: str, setup: Mapping[str, Any]) -> None:
        self.trouble: str | None = None
        """Reason why it does not answer any more; None while it does."""
        self._busy = False
        self._part = b""
        self._process = subprocess.Popen(  # noqa: S603 - our own module
            [sys.executable, "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C is for the recorder
            env={"OPENBLAS_NUM_THREADS": "1", **os.environ},
        )
        assert self._process.stdin and self._process.stdout
        self.pid = self._process.pid
        self._to, self._from = self._process.stdin.fileno(), self._process.stdout.fileno()
        self._write(setup)

    @property
    def idle(self) -> bool:
        """True while a line can be sent."""
        return not self._busy and self.trouble is None

    def send(self, value: Mapping[str, Any]) -> None:
        """Send a line, if it is idle."""
        if self.idle:
            self._busy = True
            self._write(value)

    def answer(self, wait: float = 0.0) -> Any:
        """Return the newest answer that has come since, or comes within some seconds, or None."""
        if self.trouble is not None or not select.select([self._from], [], [], wait)[0]:
            return None
        data = os.read(self._from, 1 << 20)
        if not data:
            self.trouble = f"it ended with status {self._process.poll()}"
            return None
        *lines, self._part = (self._part + data).split(b"\n")
        if not lines:
            return None
        self._busy = False
        return json.loads(lines[-1])

    def close(self) -> None:
        """End it; safe to call twice."""
        self.trouble = self.trouble or "it is closed"
        for pipe in (self._process.stdin, self._process.stdout):
            with suppress(OSError):
                if pipe:
                    pipe.close()
        self._process.kill()  # it holds nothing that could be lost
        self._process.wait()

    def _write(self, value: Mapping[str, Any]) -> None:
        data = json.dumps(value).encode() + b"\n"
        try:
            while data:
                data = data[os.write(self._to, data) :]
        except OSError as error:
            self.trouble = f"it cannot be reached: {error.strerror}"


def lines_from_recorder() -> Generator[Any, None, None]:
    """Yield the lines that a recorder sends, in a worker; it gives way to the recorder."""
    os.nice(10)
    for line in sys.stdin.buffer:
        yield json.loads(line)


def reply(value: Mapping[str, Any]) -> None:
    """Answer a line, in a worker."""
    sys.stdout.write(json.dumps(value) + "\n")
    sys.stdout.flush()


def goal_for(robot: Robot, goal_mm: float | None = None) -> float:
    """Return the goal of the predicted error of distances [m].

    By default three times the arm's repeatability, or the resolution of a printed socket.
    """
    if goal_mm is not None:
        return 1e-3 * goal_mm
    name = known_arm([robot.name, Path(robot.source).stem])
    repeatability = ARMS[name].repeatability if name else RESOLUTION
    return GOAL * max(repeatability, RESOLUTION)


class BackgroundGuidance(WorkerProcess):
    """Guidance by a worker process; a ``GuidanceProvider``.

    Args:
        robot: Options of the robot.
        distance: Between the sockets [m].
        sockets: Number of sockets.
        goal: Of the predicted error of distances [m].
    """

    def __init__(self, robot: RobotOptions, distance: float, sockets: int, goal: float) -> None:
        setup = {
            "robot": robot.model_arguments(),
            "distance": distance,
            "goal": goal,
            "sockets": sockets,
        }
        super().__init__("mukca.tools.recording.guidance_process", setup)

    def ask(self, request: GuidanceRequest) -> None:
        """Make a request; never waits."""
        samples = [(sample.position, sample.socket) for sample in request.samples]
        self.send({"samples": samples, "socket": request.socket, "position": request.position})

    def answer(self, wait: float = 0.0) -> Advice | None:
        """Return the newest advice that has come since; None without one."""
        answer: Any = super().answer(wait)
        if answer is None:
            return None
        target, closing = answer.pop("target"), answer.pop("closing")
        return Advice(**answer, target=target and tuple(target), closing=tuple(closing))


def main() -> None:
    """Answer requests until the recorder ends."""
    lines = lines_from_recorder()
    setup = next(lines)
    from ...recorder import Sample
    from ...solver.robot import load_robot
    from .guidance import PoseSelector

    selector = PoseSelector(
        load_robot(**setup["robot"]), setup["distance"], setup["goal"], setup["sockets"]
    )
    closing: tuple[str, ...] = ()
    for request in lines:
        samples = [
            Sample(tuple(q), socket, number=i)
            for i, (q, socket) in enumerate(request["samples"], start=1)
        ]
        advice = selector.advise(samples, request["socket"], request["position"])
        reply({**asdict(advice), "closing": closing})
        if advice.enough and not closing:
            closing = selector.closing(samples)
            reply({**asdict(advice), "closing": closing})


if __name__ == "__main__":
    main()
