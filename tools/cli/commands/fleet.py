"""``mukca fleet``: calibrate many arms, and compare them on one page."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ....solver.calibration import SolveOptions
from ....solver.results import refuse_existing, write_files
from .. import OutputOptions, RobotOptions, Terminal, WorkerOptions, argument, option, part

if TYPE_CHECKING:
    from ...fleet import ArmFolder, FleetDocument


@dataclass(frozen=True, kw_only=True)
class Options(RobotOptions, WorkerOptions, OutputOptions):
    """Options of ``mukca fleet``."""

    folder: Path = argument("one folder an arm", "DIR")
    out: Path = option("where to write", "DIR", ..., group="output")
    calibration: SolveOptions = part(SolveOptions, "method", "distance", "repeatability_mm")


def run(options: Options, terminal: Terminal) -> int:
    """Calibrate all arms, and write the page."""
    from ....solver.assessment import worst
    from ....solver.calibration import learn_types
    from ....solver.results import agreement_words, encode
    from ...fleet import (
        FORMAT,
        FleetDocument,
        calibrate_arm,
        compare_curves,
        compare_parameters,
        find_arms,
        fleet_page,
        last_sessions,
    )

    refuse_existing(options.out, force=options.force)
    items = [_arm(options, folder) for folder in find_arms(options.folder)]
    with terminal.progress(len(items)) as progress:
        arms = options.workers.map(calibrate_arm, items, lambda i: progress(items[i].folder.name))
    result = FleetDocument(
        format=FORMAT,
        arms=tuple(arms),
        parameters=compare_parameters(arms),
        curves=compare_curves(arms),
    )
    for pair in result.curves:
        terminal.say(f"{pair.a} and {pair.b}: {agreement_words(pair.joints)}")
    page = fleet_page(result).encode("utf-8", "replace")
    files = {"fleet.html": page, "fleet.json": encode(result, indent=1)}
    learned = learn_types(Path(last.outputs["calibration"]) for last in last_sessions(arms))
    if learned.types:
        files["elasticity.json"] = encode(learned, indent=1)
    written = write_files(options.out, files)
    show(result, terminal)
    if learned.types:
        terminal.say(f"Elasticity, for --type-prior: {written['elasticity.json']}")
    terminal.say(f"Report: {written['fleet.html']}")
    terminal.emit(result)
    return worst(arm.exit_status for arm in arms)


def _arm(options: Options, folder: Path) -> "ArmFolder":
    from ...fleet import ArmFolder

    robot = options.model_arguments()
    if Path(options.robot).is_file():  # a cluster's workers stand elsewhere
        robot["robot"] = str(Path(options.robot).resolve())
    return ArmFolder(
        folder.resolve(), (options.out / folder.name).resolve(), robot, options.calibration
    )


def show(result: "FleetDocument", terminal: Terminal) -> None:
    """Print a row for each arm, and what to do."""
    from ...fleet import line_of, summary_of
    from .. import table

    heads = ("arm", "last session", "nominal", "calibrated", "verdict")
    terminal.console.print(table("", heads, map(line_of, result.arms), left=(0, 1, 4)))
    terminal.say(*(f"{arm.name}: {arm.again}" for arm in result.arms if arm.again is not None))
    terminal.say(f"{summary_of(result)}.")
