"""``mukca check``: look at recordings before they are fitted."""

import argparse
from pathlib import Path

from ..arguments import add_load, add_robot, load_of, measure_all, robot_of
from ..terminal import Terminal

EXAMPLE = """example:
  mukca check recordings --robot panda

Exit status 1 if something should be mended before training on it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    parser.add_argument("data", nargs="+", type=Path, metavar="DATA", help="placements")
    add_robot(parser)
    add_load(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object, SI units")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Print one line for each thing seen, and which placement to record next."""
    from ...solver.checks.inspection import inspect_all, next_placement
    from ...solver.data.measurements import check_distinct
    from ...solver.robot.parameters import choose_parameters

    robot = robot_of(arguments)
    data = measure_all(arguments.data, robot, None, sockets=1)
    check_distinct(data)
    warnings = [line for measured in data for line in measured.warnings]
    for line in warnings:
        terminal.warn(line)
    inspections = inspect_all(robot, choose_parameters(robot), data, load_of(arguments))
    for one in inspections:
        counts = "+".join(map(str, one.measured.counts))
        terminal.say(
            f"{one.measured.name}: {counts} samples; fitted alone it leaves "
            f"{1e3 * one.floor:.3f} mm"
        )
        for finding in one.findings:
            terminal.say(f"  {finding.level}: {finding}")
    hint = next_placement(robot, inspections)
    terminal.say(hint)
    findings = [finding for one in inspections for finding in one.findings]
    if not findings:
        terminal.say("Nothing wrong was seen.")
    if arguments.json:
        terminal.emit(
            {
                "robot": arguments.robot,
                "placements": [
                    {
                        "name": one.measured.name,
                        "samples": list(one.measured.counts),
                        "floor": one.floor,
                        "findings": [finding.as_dict() for finding in one.findings],
                    }
                    for one in inspections
                ],
                "next_placement": {"text": hint},
                "warnings": warnings,
            }
        )
    return 1 if any(finding.level == "error" for finding in findings) else 0
