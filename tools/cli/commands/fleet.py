"""``mukca fleet``: many arms, each calibrated by its own recordings, shared out over workers."""

from collections.abc import Sequence
from pathlib import Path

from ....solver import assessment, partial, results
from ....solver.assessment import plural
from ....solver.calibration import SolveOptions
from ....solver.identification.robot import from_folder
from ....solver.results import encode, write_files
from ... import cli, fleet

MOST_ROWS = 6
"""Arms in the short table; those to look at come first."""
NAME, SESSION = 22, 14
"""Letters of an arm's and of a session's name there."""
BELOW = 3
"""Lines of the screen below the answer."""
HEADS = ("arm", "last session", "before", "now", "verdict")


class _FleetOptions(cli.RobotOptions, cli.WorkerOptions, cli.DetailsOptions):
    folder: Path
    out: Path = cli.option(..., "folder to write to", "DIR")
    calibration: SolveOptions = cli.part(
        SolveOptions, "method distance repeatability_mm"
    )


def run_fleet(options: _FleetOptions, terminal: cli.Terminal) -> int:
    """Calibrate all arms, and write the page."""
    options.check_out()
    folders = fleet.find_arms(options.folder)
    copied = fleet.find_copies(folders)
    items = [_arm(options, folder, copied.get(folder)) for folder in folders]
    with terminal.progress(len(items)) as progress:
        arms = options.workers.map(
            fleet.calibrate_arm, items, lambda i: progress(items[i].folder.name)
        )
    result = fleet.FleetDocument(
        format=fleet.FORMAT,
        arms=tuple(arms),
        months=fleet.months_of(arms),
        parameters=fleet.compare_parameters(arms),
        curves=fleet.compare_curves(arms),
    )
    page = fleet.fleet_page(result).encode("utf-8", "replace")
    files = {"fleet.html": page, "fleet.json": encode(result, indent=1)}
    written = write_files(options.out, files)
    show = show_details if options.details else show_in_short
    terminal.say(f"{fleet.summary_of(result)}.")
    show(result, terminal)
    terminal.say(f"Report: {written['fleet.html']}")
    terminal.emit(result)
    return assessment.worst(arm.exit_status for arm in arms)


def show_in_short(result: "fleet.FleetDocument", terminal: cli.Terminal) -> None:
    """Show the state of the fleet: a sentence, a table, and as many next steps as fit."""
    arms = sorted(result.arms, key=fleet.urgency)
    heads = ("mean error", *HEADS[1:])
    rows: list[Sequence[str]] = [heads, *map(fleet.line_of, arms[:MOST_ROWS])]
    if len(arms) > MOST_ROWS:
        rows.append([f"and {plural(len(arms) - MOST_ROWS, 'more arm')}"])
    terminal.say_rows(rows, _aligned)
    terminal.say_in_short(*_steps(arms), below=BELOW + 1 + len(rows))


def _aligned(row: Sequence[str]) -> str:
    """Return a row of the short table as a line."""
    name, session, before, now, verdict = row
    cells = f"{name[-NAME:]:{NAME}} {session[-SESSION:]:{SESSION}} {before:>9} {now:>9}"
    return f"{cells}  {verdict}"


def _steps(arms: "Sequence[fleet.FleetArm]") -> list[str]:
    return [f"{arm.name}: {arm.again}" for arm in arms if arm.again]


def show_details(result: "fleet.FleetDocument", terminal: cli.Terminal) -> None:
    """Show all arms, their answers, the next steps, and how far error curves agree."""
    rows = list(map(fleet.line_of, result.arms))
    terminal.tabulate("", HEADS, rows, left_columns=(0, 1, 4))
    last = ((arm.name, arm.sessions[-1].answer) for arm in result.arms if arm.sessions)
    terminal.say(*(f"{name}: {' '.join(words)}" for name, words in last if words))
    terminal.say(*_steps(result.arms))
    for pair in result.curves:
        terminal.say(f"{pair.a} and {pair.b}: {results.agreement_words(pair.joints)}")


def _arm(options: _FleetOptions, folder: Path, copied: str | None) -> "fleet.ArmFolder":
    robot = options.model_arguments()
    # a cluster's workers stand elsewhere
    robot["robot"] = from_folder(options.robot, Path().resolve())
    out = (options.out / folder.name).resolve()
    return fleet.ArmFolder(
        folder.resolve(), out, robot, options.calibration, partial.what_changed, copied
    )
