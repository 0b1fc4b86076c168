"""The process beside the recorder that runs the coach.

The first line says which robot it is, every other one asks; each is a JSON object.
"""

import json
import os
import sys
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from ...recorder.session import Advice, Question
from .neighbour import WorkerProcess, lines_from_recorder

COACHING = "mukca.tools.recording.coaching"
"""This module, for the process that runs it."""


class BackgroundCoach:
    """Asks a coach in another process; see :class:`.guidance.GuidanceProvider`.

    Args:
        neighbour: The process.
    """

    def __init__(self, neighbour: WorkerProcess) -> None:
        self._neighbour = neighbour

    @property
    def trouble(self) -> str | None:
        """Why no advice comes any more; None while it does."""
        return self._neighbour.trouble

    @property
    def idle(self) -> bool:
        """Whether a question can be asked now."""
        return self._neighbour.idle

    def ask(self, question: Question) -> None:
        """Ask; never waits."""
        self._neighbour.send(
            {
                "samples": [(s.position, s.socket) for s in question.samples],
                "socket": question.socket,
                "position": question.position,
            }
        )

    def answer(self) -> Advice | None:
        """Return the newest answer that has come since; None without one."""
        said: Any = self._neighbour.answer()
        if not isinstance(said, dict):
            return None
        target, closing = said.pop("target"), said.pop("closing")  # pyright: ignore
        return Advice(**said, target=target and tuple(target), closing=tuple(closing))  # pyright: ignore


def setup_of(
    robot: Mapping[str, Any], distance: float, goal: float, sockets: int
) -> dict[str, Any]:
    """Return the first line for this process.

    Args:
        robot: The arguments of :func:`mukca.load_robot`.
        distance: Between sockets 0 and 1 [m].
        goal: Of the predicted error of distances [m].
        sockets: How many there are.
    """
    return {"robot": dict(robot), "distance": distance, "goal": goal, "sockets": sockets}


def _say(advice: Advice, closing: tuple[str, ...]) -> None:
    """Write an answer."""
    sys.stdout.write(json.dumps({**asdict(advice), "closing": closing}) + "\n")
    sys.stdout.flush()


def main() -> None:
    """Answer questions until nobody asks any more."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.nice(10)
    lines = lines_from_recorder()
    setup = next(lines)
    from ...recorder import Sample
    from ...solver.robot import load_robot
    from .coach import PoseSelector

    coach = PoseSelector(
        load_robot(**setup["robot"]), setup["distance"], setup["goal"], setup["sockets"]
    )
    closing: tuple[str, ...] = ()
    for asked in lines:
        samples = [
            Sample(tuple(q), socket, number=i)
            for i, (q, socket) in enumerate(asked["samples"], start=1)
        ]
        advice = coach.advise(samples, asked["socket"], asked["position"])
        _say(advice, closing)
        if advice.enough and not closing:
            closing = coach.closing(samples)
            _say(advice, closing)


if __name__ == "__main__":
    main()
