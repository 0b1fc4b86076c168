"""``mukca extract``: find the rests of an arm in a log, and make a recording of them."""

import argparse
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ....recorder.stream import STILL, WINDOW
from ....solver.results import refuse_existing, write_files
from ...recording import joints_of
from .. import Terminal, add_robot, robot_of
from ..robot_arguments import UsageError

if TYPE_CHECKING:
    from ....recorder.stream import JointLimits
    from ....solver.robot import Robot
    from ...extract import Log, Proposal, Question

EXAMPLE = """example:
  mukca extract session.mcap --robot panda
  mukca extract session.mcap --robot panda --out recordings

Reads ROS 1 and 2 bags, lerobot data sets, CSV logs with a column of time, and what
mukca record --keep-stream kept. Without --out it shows what it found and writes nothing. Look at
the table and at DIR/rests.svg: a rest is a sample only if the ball sat in a socket, which no log
can tell. --assign says which:
  --assign front:0=1-30 --assign front:1=31-60"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    add = parser.add_argument
    add("log", type=Path, metavar="LOG", help="a bag, a data set, a CSV file, or a recording")
    add_robot(parser)
    add("--out", type=Path, metavar="DIR", help="write a folder for each placement here")
    add("--force", action="store_true", help="overwrite what is in DIR")
    add("--distance", type=float, default=0.05, metavar="M", help="between the centres of sockets "
        "0 and 1, in metres, as measured with a caliper (default: %(default)s)")  # fmt: skip
    add("--assign", action="append", default=[], metavar="NAME:SOCKET=RESTS", help="what the rests "
        "are, by their numbers, instead of what is proposed; may be repeated")  # fmt: skip
    add("--topic", metavar="T", help="(bags) the topic (default: the one with most states)")
    add("--joints", metavar="NAMES", help="how the log calls the joints: names in chain order, "
        "between commas; or one word in which * is the model's name, as in left_*")  # fmt: skip
    add("--units", metavar="U", help="(lerobot, CSV) radians, degrees, or lerobot's calibration "
        "file of the arm, for values from -100 to 100")  # fmt: skip
    add("--efforts", action="store_true", help="(bags) take the efforts: they are in N m")
    add(
        "--window",
        type=float,
        default=WINDOW,
        metavar="S",
        help="seconds that a sample averages (default: %(default)s)",
    )
    add("--still", type=float, metavar="RAD", help="largest standard deviation over the window of "
        f"an arm that is still (default: {STILL}, or the step of its encoders)")  # fmt: skip
    add("--json", action="store_true", help="print one JSON object, SI units")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Find the rests, show what they may be, and write them."""
    from ...extract import assign, find_rests, placements_of, read_log
    from ...extract.propose import propose

    _check(arguments)
    robot = robot_of(arguments)
    joints = joints_of(robot)
    with terminal.progress() as step:
        step(f"reading {arguments.log}")
        log = read_log(_question(arguments, joints))
        window = max(arguments.window, log.least_window)
        still = max(STILL, log.resolution) if arguments.still is None else arguments.still
        step(f"looking for rests in {len(log.stamps)} states")
        rests = find_rests(log, joints, window=window, still=still)
    for note in log.notes:
        terminal.say(note)
    proposals = propose(robot, rests, joints, arguments.distance)
    if arguments.assign:
        proposals = assign(proposals, arguments.assign)
    _show(proposals, terminal)
    folders = placements_of(proposals, robot.joint_names, arguments.distance)
    outputs: dict[str, str] = {}
    if arguments.out is not None and folders:
        session = {"extracted_from": str(arguments.log), "window": window, "still": still}
        about = {**_about(arguments, robot, joints), "sessions": [session]}
        outputs = _write(arguments.out, folders, about, log, proposals, robot)
    _say_outputs(outputs, folders, arguments, terminal)
    if arguments.json:
        terminal.emit(
            {
                "robot": arguments.robot,
                "rests": [_row(proposal) for proposal in proposals],
                "outputs": outputs,
            }
        )
    return 0 if folders else 1


def _check(arguments: argparse.Namespace) -> None:
    """Refuse numbers that mean nothing, and an output that exists."""
    for name, low, high in (("distance", 1e-3, 10.0), ("window", 0.02, 10.0), ("still", 1e-9, 0.1)):
        value = getattr(arguments, name)
        if value is not None and not low <= value <= high:
            raise UsageError(f"--{name} {value:g}: expected {low:g} to {high:g}")
    if arguments.out is not None:
        refuse_existing(arguments.out, force=arguments.force)


def _question(arguments: argparse.Namespace, joints: "Sequence[JointLimits]") -> "Question":
    from ...extract import Question

    return Question(
        path=arguments.log,
        joints=tuple(joint.name for joint in joints),
        prismatic=tuple(joint.prismatic for joint in joints),
        named=arguments.joints,
        topic=arguments.topic,
        units=arguments.units,
        efforts=arguments.efforts,
    )


def _show(proposals: "Sequence[Proposal]", terminal: Terminal) -> None:
    """Print one line for each rest."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, title="rests", title_justify="left")
    for title in ("rest", "from s", "for s", "ball by the nominal model, mm", "spread mrad"):
        table.add_column(title, justify="right")
    table.add_column("sample of")
    for number, proposal in enumerate(proposals, start=1):
        rest = proposal.timed
        named = f"{proposal.placement}, socket {proposal.socket}"
        table.add_row(
            str(number),
            f"{rest.begin - proposals[0].timed.begin:.1f}",
            f"{rest.end - rest.begin:.1f}",
            " ".join(f"{1e3 * value:7.0f}" for value in proposal.ball),
            f"{1e3 * max(rest.rest.spread):.3f}",
            named if proposal.placement else f"none: {proposal.why}",
        )
    terminal.console.print(table)


def _about(
    arguments: argparse.Namespace, robot: "Robot", joints: "Sequence[JointLimits]"
) -> dict[str, Any]:
    """Return what ``mukca record`` would note of the robot."""
    return {
        "robot": robot.name,
        "joints": list(robot.joint_names),
        "units": [joint.unit for joint in joints],
        "distance": arguments.distance,
        "sockets": 2,
        "model_sha256": robot.sha256,
    }


def _write(
    out: Path,
    folders: dict[str, dict[str, bytes]],
    about: dict[str, Any],
    log: "Log",
    proposals: "Sequence[Proposal]",
    robot: "Robot",
) -> dict[str, str]:
    """Write the placements and the picture; return their paths by kind."""
    from ....recorder import METADATA
    from ...extract.picture import picture

    for name, files in folders.items():
        files[METADATA] = json.dumps(about, indent=2).encode() + b"\n"
        write_files(out / name, files)
    write_files(out, {"rests.svg": picture(log, robot.joint_names, proposals)})
    return {**{name: str(out / name) for name in folders}, "picture": str(out / "rests.svg")}


def _say_outputs(
    outputs: dict[str, str],
    folders: dict[str, dict[str, bytes]],
    arguments: argparse.Namespace,
    terminal: Terminal,
) -> None:
    if not folders:
        terminal.say("No rest is a sample, so there is nothing to write.")
    elif not outputs:
        terminal.say("Nothing was written; --out DIR writes a folder for each placement.")
    for path in outputs.values():
        terminal.say(f"Wrote {path}")
    if outputs:
        terminal.say(
            "Look at the picture: only you know whether the ball sat in a socket at each rest. "
            f"Next: mukca check {arguments.out} --robot {arguments.robot}"
        )


def _row(proposal: "Proposal") -> dict[str, Any]:
    rest = proposal.timed.rest
    assert math.isfinite(rest.stamp)
    return {
        "begin": proposal.timed.begin,
        "end": proposal.timed.end,
        "position": list(rest.position),
        "spread": list(rest.spread),
        "ball": proposal.ball.tolist(),
        "placement": proposal.placement,
        "socket": proposal.socket if proposal.placement else None,
        "why": proposal.why,
    }
