"""``mukca solve``: calibrate a robot from recordings."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from msgspec import structs

from .... import recorder
from ....solver import assessment, calibration, results
from ....solver.calibration import SolveOptions
from ....solver.identification import data
from ....solver.identification.robot import Robot
from ... import report
from ...report import figures
from .. import (
    DetailsOptions,
    RobotsOptions,
    TableOptions,
    Terminal,
    part,
    split_by_robot,
)
from .calibration_tables import show_details, show_errors

Result: TypeAlias = "calibration.MultiRobotCalibration | calibration.Calibration"
LEROBOT = (
    "lerobot loads a file of motors: mukca export {} --to lerobot --servos feetech "
    "--like my_arm.json --out my_arm_new.json writes the new one."
)
"""The next step for an arm made of servos."""
LOAD = f"load {assessment.URDF}."
WRITE_AND_LOAD = f"add --out DIR, and load DIR/{assessment.URDF}."
"""The same where nothing is written."""
MORE = "--details shows limits, joints and choices"
"""Begin of the last line of the screen."""


class _CalibrateOptions(RobotsOptions, TableOptions, DetailsOptions):
    train: Sequence[Path]
    test: Sequence[Path] = ()
    exit_zero: bool = False
    settings: SolveOptions = part(SolveOptions)


def run_solve(options: _CalibrateOptions, terminal: Terminal) -> int:
    """Calibrate, show the figures, and write the results."""
    options.check_out()
    result, left_out = calibrated(options, terminal)
    arms = result if isinstance(result, Mapping) else {"": result}
    for name, arm in arms.items():
        if name:
            terminal.say(f"Robot {name}")
        _show_answer(arm, terminal, options)
    terminal.say(*left_out)
    refusals = list(filter(None, (arm.refusal() for arm in arms.values())))
    outputs: dict[str, str] = {}
    if options.out and not refusals:
        # The folder was looked at before it held the recordings of tables.
        outputs = result.save(options.out, force=True, pages=report.report_files)
    for name, arm in arms.items():
        saved = arm.saved_in(options.out / name) if options.out and outputs else arm
        _show_steps(name, saved, terminal, details=options.details)
    for reason in refusals:
        terminal.warn(reason)
        terminal.say("Nothing was written.")
    if isinstance(result, Mapping):
        terminal.say(*(pair.text for pair in result.document.between.values()))
    if not options.details:
        terminal.say(f"{MORE}; the report has all." if outputs else f"{MORE}.")
    usable = all(arm.verdict.use for arm in arms.values())
    if not refusals:
        terminal.say(*_closing_lines(outputs, usable=usable))
        if usable and options.settings.zeros and "urdf" in outputs:
            terminal.say(LEROBOT.format(outputs["calibration"]))
    verdicts = {name: arm.verdict.as_said() for name, arm in arms.items()}
    if isinstance(result, Mapping):
        terminal.emit({**result.as_dict(), "outputs": outputs, "verdicts": verdicts})
    else:
        fit = result.result.as_dict()
        terminal.emit({**fit, "outputs": outputs, "verdict": verdicts[""]})
    if options.exit_zero and usable and not refusals:
        return 0
    return assessment.worst(arm.verdict.exit_status for arm in arms.values())


def _show_answer(
    arm: "calibration.Calibration", terminal: Terminal, options: _CalibrateOptions
) -> None:
    """Show whether to load a model, its errors, and what is wrong in the recordings."""
    document, verdict = arm.document, arm.verdict
    if not options.out:
        answer = tuple(line.replace(LOAD, WRITE_AND_LOAD) for line in verdict.answer)
        verdict = structs.replace(verdict, answer=answer)
    report.show_answer(terminal.console, verdict)
    if options.details:
        show_details(terminal, arm)
        if document.error_parts:
            terminal.say(document.error_parts.text)
    else:
        show_errors(arm.errors, terminal, short=True)
        terminal.say(assessment.distance_text(document.placements))
    terminal.warn(*document.warnings)
    for check in document.checks or ():
        if check.level != "note":  # the report has those
            terminal.warn(str(check), level=check.level)


def _show_steps(
    name: str, arm: "calibration.Calibration", terminal: Terminal, *, details: bool
) -> None:
    """Show what to do next with an arm, and with the details each limit."""
    result = arm.assessment
    todo = figures.steps(result)
    if name and (todo or details):
        terminal.say(f"Robot {name}")
    if details:
        report.show_limits(terminal.console, result.verdict, result.limits, todo)
    else:
        report.show_steps(terminal.console, todo)


def calibrated(
    options: _CalibrateOptions, terminal: Terminal
) -> "tuple[Result, list[str]]":
    """Calibrate by the options; return remarks on the placements, too."""
    robots = options.load_robots()
    training, tested, left_out = split_by_robot(options.train, options.test, robots)
    settings = vars(options.settings)
    how = {"as_recorded": options.settings.as_recorded, **options.table}
    train: dict[str, list[recorder.Placement]] = {}
    test: dict[str, list[recorder.Placement]] = {}
    for name, robot in robots.items():
        to_fit, held_out = _read(training[name], tested[name], how)
        if options.out:
            keep = partial(_kept, robot=robot, out=options.out, terminal=terminal)
            to_fit, held_out = list(map(keep, to_fit)), list(map(keep, held_out))
        train |= {name: to_fit} if to_fit else {}
        test |= {name: held_out} if held_out else {}
    with terminal.progress() as progress:
        if "" in robots:
            sets = train.get("", []), test.get("", [])
            result = calibration.calibrate(robots[""], *sets, progress, **settings)
        else:
            result = calibration.calibrate(robots, train, test, progress, **settings)
    return result, left_out


def _read(
    training: Sequence[Path], tested: Sequence[Path], how: Mapping[str, Any]
) -> "tuple[list[recorder.Placement], list[recorder.Placement]]":
    """Return a robot's placements to train on and to test on; see :func:`mukca.read_placements`."""
    if not training and not tested:
        return [], []
    folders = {folder.resolve() for folder in recorder.find_placements(training)}
    train = list[recorder.Placement]()
    test = list[recorder.Placement]()
    for placement in recorder.read_placements(*training, *tested, **how):
        is_trained = placement.path and placement.path.resolve() in folders
        (train if is_trained else test).append(placement)
    return train or recorder.read_placements(*training, **how), test


def _closing_lines(outputs: dict[str, str], *, usable: bool) -> list[str]:
    if not outputs:
        result = "new URDF" if usable else "report"
        return [
            f"Nothing was written; add --out DIR to write the {result} into a folder DIR."
        ]
    if "arms" in outputs:
        summary = outputs["arms"]
        if "urdf" in outputs:
            summary = f"{outputs['urdf']}, all robots in one URDF"
        return [f"Wrote {summary}, and a folder for each robot."]
    page = outputs["report"]
    files = f"Wrote {page} to read; beside it calibration.json, report.json for scripts"
    if not usable:
        return [f"{files}, and calibrated.urdf: do not load it, see above."]
    return [
        f"{files}, and calibrated.urdf: load it instead of the nominal URDF.",
        "Redo camera extrinsics, and poses taught in Cartesian space: they hold the old model's "
        "errors.",
    ]


def _kept(
    placement: recorder.Placement,
    robot: Robot,
    out: Path,
    terminal: Terminal,
) -> recorder.Placement:
    """Return a placement; of a table as the recording that is written beside the results."""
    if not placement.suggestion:
        return placement
    placement = placement.for_joints(robot.joint_names)
    data.measure(placement, robot)  # what is refused is not written
    folder = out / "recordings" / placement.name
    files = results.write_files(folder, recorder.own_files(placement)).values()
    terminal.say(*(f"Wrote {file}, the samples of your table" for file in files))
    return replace(placement, files=tuple(files), suggestion=None)
