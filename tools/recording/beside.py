"""What runs beside the recorder: the coach, and the page."""

import argparse
import time
from contextlib import ExitStack, closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...recorder.session import Session
from ...solver.assessment import ARMS, RESOLUTION, known_arm
from ...solver.calibration import UsageError
from ...solver.robot import Robot
from .coaching import COACHING, BackgroundCoach, setup_of
from .neighbour import WorkerProcess

if TYPE_CHECKING:
    from .page import PageLink

GOAL = 3.0
"""The goal is so many times the arm's repeatability."""


def goal_for(robot: Robot, goal_mm: float | None = None) -> float:
    """Return what the predicted error of distances should come to [m].

    Three times what the arm repeats to, or a printed socket resolves, where nothing is given.
    """
    if goal_mm is not None:
        return 1e-3 * goal_mm
    name = known_arm([robot.name, Path(robot.source).stem])
    repeatability = ARMS[name].repeatability if name else RESOLUTION
    return GOAL * max(repeatability, RESOLUTION)


def adviser_of(
    arguments: argparse.Namespace, robot: Robot, stack: ExitStack
) -> BackgroundCoach | None:
    """Return who guides the operator, in a process of its own; None where nobody is to."""
    if arguments.no_guide:
        return None
    setup = setup_of(
        _loaded(arguments),
        arguments.distance,
        goal_for(robot, arguments.goal_mm),
        arguments.sockets,
    )
    return BackgroundCoach(stack.enter_context(closing(WorkerProcess(COACHING, setup))))


def _loaded(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return how the robot was loaded, for a process that loads it too."""
    return {name: getattr(arguments, name) for name in ("robot", "base", "tip", "flange", "ball")}


def page_of(
    arguments: argparse.Namespace, session: Session, stack: ExitStack
) -> "tuple[PageLink | None, Session]":
    """Return what shows the page, and the session with its address.

    Raises:
        UsageError: It cannot be served there.
    """
    if not arguments.page:
        return None, session
    from .page import PAGE, PageLink

    setup = {"robot": _loaded(arguments), "host": arguments.page_host}
    neighbour = stack.enter_context(closing(WorkerProcess(PAGE, setup)))
    neighbour.send({})
    answer: Any = None
    while answer is None and neighbour.trouble is None:
        answer = neighbour.answer()
        time.sleep(0.02)
    if answer is None:
        raise UsageError(f"--page-host {arguments.page_host}: no page can be served there")
    session = session.with_message(f"page: {answer['url']}")
    if arguments.page_host not in ("127.0.0.1", "localhost", "::1"):
        warning = "whoever knows this address can watch, from anywhere in the network"
        session = session.with_message(warning, alarm=True)
    return PageLink(neighbour), session
