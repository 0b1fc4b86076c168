"""``mukca solve``: calibrate a robot from recordings."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from .... import recorder
from ....solver import assessment, calibration, results
from ....solver.calibration import SolveOptions
from ... import report
from ...report import figures
from .. import (
    DetailsOptions,
    RobotsOptions,
    Terminal,
    argument,
    option,
    part,
    split_by_robot,
)
from .placement_errors import show_errors
from .solve_details import show_details

MORE = "--details shows limits, joints and choices"
"""Begin of the last line of the screen."""


class _CalibrateOptions(RobotsOptions, DetailsOptions):
    train: Sequence[Path] = argument("placements to fit", "TRAIN")
    test: Sequence[Path] = option((), "placements held out", "HELD_OUT")
    settings: SolveOptions = part(SolveOptions)


def run_solve(options: _CalibrateOptions, terminal: Terminal) -> int:
    """Calibrate, show the figures, and write the results."""
    options.check_out()
    found, left_out = calibrated(options, terminal)
    robots = found if isinstance(found, Mapping) else {"": found}
    for name, one in robots.items():
        if name:
            terminal.say(f"Robot {name}")
        report.show_answer(terminal.console, one.verdict)
        if options.details:
            show_details(terminal, one)
        else:
            show_errors(one.errors, terminal, short=True)
            terminal.say(assessment.distance_text(one.document.placements))
        if (parts := one.document.error_parts) is not None:
            terminal.say(parts.text if options.details else parts.brief)
        _warn(terminal, one.document)
    terminal.say(*left_out)
    refusals = list(filter(None, (one.refusal() for one in robots.values())))
    outputs: dict[str, str] = {}
    if options.out and not refusals:
        outputs = found.save(
            options.out, force=options.force, pages=report.report_files
        )
    for name, one in robots.items():
        saved = one.saved_in(options.out / name) if options.out and outputs else one
        result = saved.assessment
        todo = figures.steps(result)
        if name and (todo or options.details):
            terminal.say(f"Robot {name}")
        if options.details:
            report.show_limits(terminal.console, result.verdict, result.limits, todo)
        else:
            report.show_steps(terminal.console, todo)
    verdicts = {name: one.verdict for name, one in robots.items()}
    for reason in refusals:
        terminal.warn(reason)
        terminal.say("Nothing was written.")
    if isinstance(found, Mapping):
        terminal.say(*(pair.text for pair in found.document.between.values()))
    if not options.details:
        terminal.say(f"{MORE}; the report has all." if outputs else f"{MORE}.")
    if not refusals:
        usable = all(verdict.use for verdict in verdicts.values())
        terminal.say(*_closing_lines(outputs, usable=usable))
    said = {name: verdict.as_said() for name, verdict in verdicts.items()}
    if isinstance(found, Mapping):
        terminal.emit({**found.as_dict(), "outputs": outputs, "verdicts": said})
    else:
        terminal.emit(
            {**found.result.as_dict(), "outputs": outputs, "verdict": said[""]}
        )
    return assessment.worst(verdict.exit_status for verdict in verdicts.values())


def calibrated(
    options: _CalibrateOptions, terminal: Terminal
) -> "tuple[calibration.MultiRobotCalibration | calibration.Calibration, list[str]]":
    """Calibrate by the options; return remarks on the placements, too."""
    robots = options.load_robots()
    training, tested, left_out = split_by_robot(options.train, options.test, robots)
    settings = vars(options.settings)
    as_recorded = options.settings.as_recorded
    train: dict[str, list[recorder.Placement]] = {}
    test: dict[str, list[recorder.Placement]] = {}
    for name in robots:
        to_fit, held_out = _read(training[name], tested[name], as_recorded=as_recorded)
        train |= {name: to_fit} if to_fit else {}
        test |= {name: held_out} if held_out else {}
    with terminal.progress() as progress:
        if "" in robots:
            data = train.get("", []), test.get("", [])
            result = calibration.calibrate(robots[""], *data, progress, **settings)
        else:
            result = calibration.calibrate(robots, train, test, progress, **settings)
    return result, left_out


def _warn(terminal: Terminal, document: "results.CalibrationDocument") -> None:
    """Show what was set right, and what is wrong in the recordings."""
    terminal.warn(*document.warnings)
    for check in document.checks or ():
        if check.level != "note":  # the report has those
            terminal.warn(str(check), level=check.level)


def _read(
    training: Sequence[Path], tested: Sequence[Path], *, as_recorded: bool
) -> "tuple[list[recorder.Placement], list[recorder.Placement]]":
    """Return a robot's placements to train on and to test on; see :func:`mukca.read_placements`."""
    if not training and not tested:
        return [], []
    folders = {folder.resolve() for folder in recorder.find_placements(training)}
    train = list[recorder.Placement]()
    test = list[recorder.Placement]()
    for placement in recorder.read_placements(
        *training, *tested, as_recorded=as_recorded
    ):
        is_trained = placement.path is not None and placement.path.resolve() in folders
        (train if is_trained else test).append(placement)
    return (train, test) if train else (recorder.read_placements(*training), test)


def _closing_lines(outputs: dict[str, str], *, usable: bool) -> list[str]:
    if not outputs:
        return ["Nothing was written; add --out DIR to keep the calibrated URDF."]
    if "arms" in outputs:
        summary = (
            f"{outputs['urdf']}, all robots in one URDF"
            if "urdf" in outputs
            else outputs["arms"]
        )
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
