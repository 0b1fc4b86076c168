"""``mukca export``: write a calibration as other programs read it."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from ...export import FORMATS
from .. import Terminal
from ..robot_arguments import UsageError

EXAMPLE = """example:
  mukca export calibrated/calibration.json --to mdh --out panda_mdh.csv

formats:
{formats}

What a format cannot say is named, with what that costs at the ball."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    lines = [f"  {name:<8} {format_.line}" for name, format_ in FORMATS.items()]
    parser.epilog = EXAMPLE.format(formats="\n".join(lines))
    parser.add_argument(
        "calibration", type=Path, metavar="CALIBRATION", help="calibration.json of mukca solve"
    )
    parser.add_argument("--to", required=True, choices=FORMATS, metavar="FORMAT", help="see below")
    parser.add_argument("--out", required=True, type=Path, metavar="FILE", help="where to")
    parser.add_argument(
        "--flange",
        metavar="LINK",
        help="(c, urdf) the link whose pose C gives, or that carries tools "
        "(default: the one that carries the ball)",
    )
    parser.add_argument(
        "--tool",
        metavar="NAME=X,Y,Z,R,P,Y",
        action="append",
        default=[],
        help="(urdf) add a link, fixed to the flange: metres and radians; may be repeated",
    )
    parser.add_argument(
        "--like",
        type=Path,
        metavar="FILE",
        help="(ur) the file that ur_calibration wrote, whose hash is kept; "
        "(mjcf) the model to correct; (lerobot) the arm's present calibration file",
    )
    parser.add_argument(
        "--joints",
        metavar="NAMES",
        help="(mjcf) how the model calls the joints: names in chain order, between commas; or one "
        "word in which * is the URDF's name, as in left/*",
    )
    parser.add_argument(
        "--servos", choices=("feetech", "dynamixel"), help="(lerobot) the make of the arm's servos"
    )
    parser.add_argument(
        "--serial-number", metavar="TEXT", help="the arm's (default: as noted while recording)"
    )
    parser.add_argument("--force", action="store_true", help="overwrite FILE")
    parser.add_argument("--json", action="store_true", help="print one JSON object, SI units")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Write the files, and say what they leave out."""
    from ....solver.calibration import load_calibration
    from ...export import export

    tools = _tools(arguments.tool)
    calibration = load_calibration(arguments.calibration)
    if calibration.document.distorted:
        places = ", ".join(calibration.document.distorted)
        terminal.warn(
            f"{arguments.calibration}: the model does not reproduce the sockets' distance at "
            f"{places}; it was accepted by --accept-distorted"
        )
    exported = export(
        calibration,
        arguments.to,
        arguments.out,
        serial_number=arguments.serial_number,
        force=arguments.force,
        like=arguments.like,
        joints=arguments.joints,
        servos=arguments.servos,
        flange=arguments.flange,
        tools=tools,
    )
    for loss in exported.losses:
        terminal.say(str(loss))
    for line in exported.lines:
        terminal.say(line)
    for file in exported.outputs.values():
        terminal.say(f"Wrote {file}")
    if arguments.json:
        terminal.emit(
            {
                "format": arguments.to,
                "outputs": exported.outputs,
                "losses": [asdict(loss) for loss in exported.losses],
            }
        )
    return 0


def _tools(words: Sequence[str]) -> dict[str, tuple[float, ...]]:
    """Return the places of tools by their names."""
    tools: dict[str, tuple[float, ...]] = {}
    for word in words:
        name, _, place = word.partition("=")
        try:
            numbers = tuple(map(float, place.split(",")))
        except ValueError:
            numbers = ()
        if not name or name in tools or not numbers:
            raise UsageError(
                f"--tool {word}: give each a name of its own, a place in metres and a turn in "
                "radians, as in --tool gripper=0,0,0.12,0,0,1.57"
            )
        tools[name] = numbers
    return tools
