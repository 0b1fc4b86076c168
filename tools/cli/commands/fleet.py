"""``mukca fleet``: calibrate many arms, and compare them on one page."""

from dataclasses import dataclass
from pathlib import Path

from ....solver import assessment, calibration, results
from ....solver.calibration import SolveOptions
from ....solver.results import encode, write_files
from ... import fleet
from .. import OutputOptions, RobotOptions, Terminal, WorkerOptions, argument, option, part, table


@dataclass(frozen=True, kw_only=True)
class Options(RobotOptions, WorkerOptions, OutputOptions):
    """Options of ``mukca fleet``."""

    folder: Path = argument("one folder an arm", "DIR")
    out: Path = option("where to write", "DIR", ..., group="output")
    calibration: SolveOptions = part(SolveOptions, "method", "distance", "repeatability_mm")


def run(options: Options, terminal: Terminal) -> int:
    """Calibrate all arms, and write the page."""
    options.check_out()
    items = [_arm(options, folder) for folder in fleet.find_arms(options.folder)]
    with terminal.progress(len(items)) as progress:
        arms = options.workers.map(
            fleet.calibrate_arm, items, lambda i: progress(items[i].folder.name)
        )
    result = fleet.FleetDocument(
        format=fleet.FORMAT,
        arms=tuple(arms),
        parameters=fleet.compare_parameters(arms),
        curves=fleet.compare_curves(arms),
    )
    for pair in result.curves:
        terminal.say(f"{pair.a} and {pair.b}: {results.agreement_words(pair.joints)}")
    page = fleet.fleet_page(result).encode("utf-8", "replace")
    files = {"fleet.html": page, "fleet.json": encode(result, indent=1)}
    usable = [Path(last.outputs["calibration"]) for last in fleet.last_sessions(arms)]
    learned = calibration.learn_types(usable)
    if learned.types:
        files["elasticity.json"] = encode(learned, indent=1)
    written = write_files(options.out, files)
    show(result, terminal)
    if learned.types:
        terminal.say(f"Elasticity, for --type-prior: {written['elasticity.json']}")
    terminal.say(f"Report: {written['fleet.html']}")
    terminal.emit(result)
    return assessment.worst(arm.exit_status for arm in arms)


def _arm(options: Options, folder: Path) -> "fleet.ArmFolder":
    robot = options.model_arguments()
    if Path(options.robot).is_file():  # a cluster's workers stand elsewhere
        robot["robot"] = str(Path(options.robot).resolve())
    return fleet.ArmFolder(
        folder.resolve(), (options.out / folder.name).resolve(), robot, options.calibration
    )


def show(result: "fleet.FleetDocument", terminal: Terminal) -> None:
    """Print a row for each arm, and what to do."""
    heads = ("arm", "last session", "nominal", "calibrated", "verdict")
    terminal.console.print(table("", heads, map(fleet.line_of, result.arms), left=(0, 1, 4)))
    terminal.say(*(f"{arm.name}: {arm.again}" for arm in result.arms if arm.again is not None))
    terminal.say(f"{fleet.summary_of(result)}.")
