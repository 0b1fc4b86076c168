"""``mukca tool``: where a tool's tip is on a calibrated arm's flange."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .... import recorder
from ....solver import calibration, partial, robot
from ....solver.calibration import UsageError
from .. import OutputOptions, Terminal, argument, one_arm, option
from .command import read_rows
from .report import emit_with_page


@dataclass(frozen=True, kw_only=True)
class Options(OutputOptions):
    """Options of ``mukca tool``."""

    calibration: Path = argument("calibration.json, or its folder", "CALIBRATION")
    data: Sequence[Path] = argument("placements, or CSV files of joint positions", "DATA")
    name: str = option("name of the tool's link", "LINK", "tool")
    axis: Sequence[Path] = option(
        "touches by a second point up the tool's shaft: z of the link points from there to the tip",
        "DATA",
        (),
    )
    face: tuple[Path, Path] | None = option(
        "touches by two more points of a flat tool: z is normal to the three", ("DATA", "DATA")
    )
    stood: str = option(
        "placement of the calibration whose sockets, which stand where they stood, were touched",
        "PLACEMENT",
        "",
    )


def run(options: Options, terminal: Terminal) -> int:
    """Print the tool's place, and write the calibration with its link."""
    options.check_out()
    held = calibration.load_calibration(one_arm(options.calibration))
    arm = held.robot
    face = None
    if options.face is not None:
        (first,), (second,) = (touches([file], arm) for file in options.face)
        face = first, second
    found = partial.tool(
        held,
        touches(options.data, arm),
        options.name,
        axis=touches(options.axis, arm) if options.axis else (),
        face=face,
        stood=options.stood,
    )
    keep(found, options, terminal)
    return 3 if found.untold else 0


def keep(
    found: "partial.CameraPose | partial.Tool | partial.Zeros",
    options: OutputOptions,
    terminal: Terminal,
) -> None:
    """Print what was found, write it if it is to be kept, and emit it."""
    terminal.say(*found.text)
    outputs: dict[str, str] = {}
    if options.out is not None:
        outputs = found.save(options.out, force=options.force)
    else:
        terminal.say("Nothing was written; add --out DIR for a calibration and a URDF with it.")
    emit_with_page(options, terminal, found.text, found.as_dict(), outputs)


def touches(files: Sequence[Path], arm: "robot.Robot") -> "list[recorder.Placement]":
    """Return placements by their folders; a CSV file's points are its sockets."""
    found: list[recorder.Placement] = []
    for file in files:
        if not file.is_file():
            found += recorder.read_placements(file)
            continue
        if file.suffix != ".csv":
            raise UsageError(
                f"{file}: give a placement's folder, or a CSV file with a column for each joint"
            )
        names = arm.joint_names
        rows, wheres = read_rows(file, [names, (*names, "point"), (*names, "x", "y", "z")])
        m, samples = len(names), list[recorder.Sample]()
        for row, where in zip(rows.tolist(), wheres, strict=True):
            q, rest = tuple(row[:m]), row[m:]
            at = (rest[0], rest[1], rest[2]) if len(rest) == 3 else None
            socket = 0 if at else int(sum(rest))
            samples.append(recorder.Sample(q, socket, where=where, point=at))
        found.append(recorder.Placement(file.stem, tuple(samples), names, files=(file,)))
    return found
