"""``mukca solve``: calibrate a robot from recordings."""

import argparse
from typing import TYPE_CHECKING, Any

from ....solver.results import refuse_existing
from .. import (
    Terminal,
    add_options,
    placements_by_robot,
    placements_of,
    robots_of,
    split_by_robot,
    split_test,
)

if TYPE_CHECKING:
    from ....solver.assessment import Verdict
    from ....solver.calibration import ArmsCalibration, Calibration

EXAMPLE = """example:
  mukca solve recordings/front --test recordings --robot panda --distance 0.0501 --out calibrated

A placement is a folder with a recording, or with hole_0.csv and hole_1.csv; a folder of
placements stands for all of them. Two arms that recorded at the same bases:
  mukca solve left:session/left right:session/right --robot left=panda --robot right=fr3"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    add_options(parser)


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Calibrate, show the figures, and write the results."""
    from ....solver.calibration import ArmsCalibration
    from ...report import report_files

    if arguments.out is not None:
        refuse_existing(arguments.out, force=arguments.force)
    calibration = calibrated(arguments, terminal)
    if isinstance(calibration, ArmsCalibration):
        return _run_several(calibration, arguments, terminal)
    show(terminal, calibration)
    outputs = dict[str, str]()
    verdict: dict[str, Any] = {"status": "fail", "title": "FAIL", "text": calibration.distortion}
    if not _refused(calibration, arguments, terminal):
        if arguments.out is not None:
            outputs = calibration.save(
                arguments.out,
                force=arguments.force,
                accept_distorted=arguments.accept_distorted,
                pages=report_files,
            )
        verdict = judge(calibration, terminal).as_dict()
        for line in last_words(outputs):
            terminal.say(line)
    if arguments.json:
        verdict = {key: verdict[key] for key in ("status", "title", "text")}
        result = calibration.result.as_dict()
        terminal.emit({**result, "outputs": outputs, "verdict": verdict})
    return 1 if verdict["status"] == "fail" else 0


def _refused(calibration: "Calibration", arguments: argparse.Namespace, terminal: Terminal) -> bool:
    """Say so where a model does not reproduce the sockets' distance, and is not to be used."""
    if not calibration.document.distorted or arguments.accept_distorted:
        return False
    terminal.warn(calibration.distortion)
    terminal.say("Verdict: FAIL, the sockets' distance is not reproduced. Nothing was written.")
    return True


def judge(calibration: "Calibration", terminal: Terminal) -> "Verdict":
    """Print the verdict, and return it."""
    from ...report import show_verdict
    from ...report.figures import steps

    found = calibration.assessment
    todo = steps(found.predictions, found.placements, found.verdict)
    show_verdict(terminal.console, found.verdict, found.limits, todo)
    return found.verdict


def _run_several(
    calibrations: "ArmsCalibration", arguments: argparse.Namespace, terminal: Terminal
) -> int:
    """Show and write the calibrations of several robots, and where they stand."""
    from ...report import report_files

    for name, calibration in calibrations.items():
        terminal.say(f"Robot {name}")
        show(terminal, calibration)
    refused = [_refused(one, arguments, terminal) for one in calibrations.values()]
    failed, outputs = any(refused), dict[str, str]()
    if not any(refused):
        if arguments.out is not None:
            outputs = calibrations.save(
                arguments.out,
                force=arguments.force,
                accept_distorted=arguments.accept_distorted,
                pages=report_files,
            )
        for name, calibration in calibrations.items():
            terminal.say(f"Robot {name}")
            verdict = judge(calibration, terminal)
            failed |= verdict.status == "fail"
    for pair in calibrations.document.between.values():
        terminal.say(pair.text)
    if outputs:
        terminal.say(
            f"Wrote {outputs['urdf']}, all robots in one URDF, and a folder for each robot."
        )
    else:
        terminal.say("Nothing was written; add --out DIR to keep the calibrated URDFs.")
    if arguments.json:
        terminal.emit({**calibrations.as_dict(), "outputs": outputs})
    return 1 if failed else 0


def calibrated(
    arguments: argparse.Namespace, terminal: Terminal
) -> "Calibration | ArmsCalibration":
    """Return the calibration that the arguments ask for, and say what to heed."""
    from ....solver.calibration import calibrate, option_table

    robot = robots_of(arguments)
    with terminal.progress() as progress:
        options = {name: getattr(arguments, name) for name in option_table()}
        if isinstance(robot, dict):
            mine, others, left_out = split_by_robot(arguments.train, arguments.test, robot)
            train, test = placements_by_robot(mine), placements_by_robot(others)
            calibration = calibrate(robot, train, test, progress, **options)
            every = list(calibration.values())
        else:
            held_out, left_out = split_test(arguments.train, arguments.test)
            train, test = placements_of(arguments.train), placements_of(held_out)
            calibration = calibrate(robot, train, test, progress, **options)
            every = [calibration]
    for line in left_out:
        terminal.say(line)
    for document in (one.document for one in every):
        for line in document.warnings:
            terminal.warn(line)
        for finding in document.checks or ():
            terminal.warn(str(finding), finding.level)
    return calibration


def show(terminal: Terminal, calibration: "Calibration") -> None:
    """Print the figures for people."""
    from ....solver.assessment import distance_text, scale_text
    from .. import metrics_table, parameters_table

    terminal.say(distance_text(calibration.document.placements))
    if calibration.document.scale is not None:
        words = scale_text(calibration.document.scale)
        terminal.say(f"Size: {words}.")
    errors = calibration.errors
    terminal.console.print(metrics_table(errors.placements, errors.summary))
    terminal.console.print(parameters_table(calibration.result.parameters))
    for line in spoken(calibration):
        terminal.say(line)


def spoken(calibration: "Calibration") -> list[str]:
    """Return what the tables do not say."""
    from .. import frame_lines

    result = calibration.document
    lines = [
        f"{result.optimizer}: {result.iterations} iterations in "
        f"{1e3 * result.solve_seconds:.0f} ms."
    ]
    summary = result.summary.test or result.summary.train
    if summary is not None and summary.ball_refitted is not None:
        error = 1e3 * summary.ball_refitted.mean_absolute_error
        lines.append(
            f"With only the ball refitted, the nominal model stands at {error:.3f} mm MAE."
        )
    lines += result.choices or ()
    lines += frame_lines(result.frames or ())
    if result.uncertainty is not None:
        distance = result.uncertainty.distance_deviation
        lines.append(
            f"Predicted error of distances in the workspace, 1 sigma: median "
            f"{1e3 * distance.median:.2f} mm, worst {1e3 * distance.worst:.2f} mm."
        )
        lines += [f"Not seen: {text}." for text in result.uncertainty.cannot_see]
    if result.summary.test is None:
        lines.append("Not validated: no placement was held out. Add one by --test.")
    return lines


def last_words(outputs: dict[str, str]) -> list[str]:
    """Return what to do with the result."""
    if not outputs:
        return ["Nothing was written; add --out DIR to keep the calibrated URDF."]
    lines = [
        f"Wrote {outputs['calibration']}, and {outputs['report']} to read; report.json beside it "
        "holds the same figures for scripts",
        f"Wrote {outputs['urdf']}: load it instead of the nominal URDF, in robot_state_publisher, "
        "MoveIt, Pinocchio, Drake, or whatever computes the arm's kinematics.",
    ]
    if "compensated_urdf" in outputs:
        lines.append(
            f"Wrote {outputs['compensated_urdf']}: only for joint positions that are corrected "
            "first, as mukca export --to c and mukca.load_calibration(..).ball do."
        )
    lines.append(
        "Redo camera extrinsics, and poses taught in Cartesian space: they hold the old model's "
        "errors."
    )
    return lines
