"""Draws docs/images/guide.svg: three moments of a guided session, as the terminal shows them.

    python docs/images/guide.py

A simulated Panda is led to the poses that the coach proposes; what is drawn are the recorder's own
screens, with the advice that it gave.
"""

import io
import re
from pathlib import Path

import numpy as np
from rich.console import Console, Group
from rich.text import Text

from mukca.recorder import Sample
from mukca.recorder.session import BLOCK, Advice, Session, View
from mukca.recorder.terminal import render
from mukca.solver.identification.robot import load_robot
from mukca.solver.poses import InverseKinematics
from mukca.tools.recording import SHARE, PoseSelector, joints_of
from mukca.tools.simulation import Base, perturb

COLUMNS, ROWS = 84, 24


def main() -> None:
    robot = load_robot("panda")
    generator = np.random.default_rng(2)
    arm = perturb(robot, generator, 2e-3, 5e-3)
    base = Base("front", np.array([0.5, 0.0, 0.1]), np.array([0.0, 1.0, 0.0]), 0.1)
    coach, guide = PoseSelector(robot, 0.1), InverseKinematics(arm)
    session, advice = Session(joints_of(robot), block=BLOCK), None
    console = Console(record=True, width=COLUMNS, file=io.StringIO())
    for number in range(1, 2 * SHARE + 1):
        socket = (number - 1) // BLOCK % 2
        session = session if session.socket == socket else session.switched(socket)
        q = np.array(advice.target) if advice and advice.target else None
        q = seated(
            guide, q, base.sockets[socket] + generator.normal(0, 1e-4, 3), generator
        )
        sample = Sample(
            tuple(q.tolist()), socket, number=number, time=1.79e9 + 20 * number, states=300,
            spread=(1e-5,) * 7,
        )  # fmt: skip
        if number == 8:
            draw(console, session, advice, q)
        session = session.captured(sample).with_message(
            f"captured sample {number}: {session.counts[socket] + 1} in socket {socket}"
        )
        advice = coach.advise(session.live, socket, q)
        if number == BLOCK:
            draw(console, session, advice, q)
    words = Advice(
        **{
            **vars(advice),
            "enough": True,
            "exhausted": False,
            "leave": False,
            "closing": coach.closing(session.live),
        }
    )
    draw(console, session, words, q)
    file = Path(__file__).with_suffix(".svg")
    drawn = console.export_svg(title="mukca record")
    # Nothing from elsewhere.
    drawn = re.sub(r"@font-face \{.*?\}\s*", "", drawn, flags=re.DOTALL)
    file.write_text(drawn, encoding="utf-8")


def seated(
    guide: InverseKinematics,
    near: np.ndarray | None,
    seat: np.ndarray,
    generator: np.random.Generator,
) -> np.ndarray:
    """Return a pose with the ball in its seat, near another or anywhere."""
    if near is not None:
        pose, _ = guide.ball_and_neck(near[None])
        found, arrived = guide._follow(
            near[None], np.concatenate([seat[None], pose[:, 3:]], axis=1)
        )
        if arrived[0] and np.abs(found[0] - near).max() < np.pi:
            return found[0]
    return guide.reach(seat[None], generator)[0]


def draw(
    console: Console, session: Session, advice: Advice | None, q: np.ndarray
) -> None:
    title = "panda  data/front  sockets 100 mm  franka:172.16.0.2"
    view = View(
        session, tuple(q.tolist()), title, advice=advice, rate=1000.0, age=0.001
    )
    console.print(Group(*render(view, COLUMNS, ROWS)))
    console.print(Text())


if __name__ == "__main__":
    main()
