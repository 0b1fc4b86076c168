"""``mukca solve``: calibrate a robot from recordings."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from .... import recorder
from ....solver import assessment, calibration, results
from ....solver.assessment import millimetres
from ....solver.calibration import SolveOptions
from ... import report
from ...report import figures
from .. import OutputOptions, RobotsOptions, Terminal, argument, part, split_by_robot
from .check import show_errors


class _CalibrateOptions(RobotsOptions, OutputOptions):
    train: Sequence[Path] = argument()
    test: Sequence[Path] = ()
    settings: SolveOptions = part(SolveOptions)


def run_solve(options: _CalibrateOptions, terminal: Terminal) -> int:
    """Calibrate, show the figures, and write the results."""
    options.check_out()
    found = calibrated(options, terminal)
    robots = found if isinstance(found, Mapping) else {"": found}
    for name, one in robots.items():
        terminal.say(*([f"Robot {name}"] if name else []))
        report.show_answer(terminal.console, one.verdict)
        _show(terminal, one)
    refused = [reason for one in robots.values() if (reason := one.refusal())]
    outputs: dict[str, str] = {}
    if options.out and not refused:
        outputs = found.save(options.out, force=options.force, pages=report.report_files)
    for name, one in robots.items():
        terminal.say(*([f"Robot {name}"] if name else []))
        judged = one.assessment
        report.show_limits(terminal.console, judged.verdict, judged.limits, figures.steps(judged))
    verdicts = [one.verdict for one in robots.values()]
    for reason in refused:
        terminal.warn(reason)
        terminal.say("Nothing was written.")
    if isinstance(found, Mapping):
        terminal.say(*(pair.text for pair in found.document.between.values()))
    usable = all(verdict.use for verdict in verdicts)
    terminal.say(*_closing_lines(outputs, usable=usable) if not refused else ())
    each = {name: one.verdict.as_said() for name, one in robots.items()}
    if isinstance(found, Mapping):
        terminal.emit({**found.as_dict(), "outputs": outputs, "verdicts": each})
    else:
        terminal.emit({**found.result.as_dict(), "outputs": outputs, "verdict": each[""]})
    return assessment.worst(verdict.exit_status for verdict in verdicts)


def calibrated(
    options: _CalibrateOptions, terminal: Terminal
) -> "calibration.MultiRobotCalibration | calibration.Calibration":
    """Calibrate by the options, and print the warnings."""
    robots = options.load_robots()
    trained, tested, left_out = split_by_robot(options.train, options.test, robots)
    settings = vars(options.settings)
    as_recorded = options.settings.as_recorded
    read = {name: _read(trained[name], tested[name], as_recorded=as_recorded) for name in robots}
    train, test = ({name: own[part] for name, own in read.items() if own[part]} for part in (0, 1))
    with terminal.progress() as progress:
        if "" in robots:
            data = train.get("", []), test.get("", [])
            found = calibration.calibrate(robots[""], *data, progress, **settings)
        else:
            found = calibration.calibrate(robots, train, test, progress, **settings)
    terminal.say(*left_out)
    for one in found.values() if isinstance(found, Mapping) else [found]:
        terminal.warn(*one.document.warnings)
        for check in one.document.checks or ():
            if check.level != "note":  # the report has those
                terminal.warn(str(check), level=check.level)
    return found


def _read(
    trained: Sequence[Path], tested: Sequence[Path], *, as_recorded: bool
) -> "tuple[list[recorder.Placement], list[recorder.Placement]]":
    """Return a robot's placements to train on and to test on; see :func:`mukca.read_placements`."""
    if not trained and not tested:
        return [], []
    folders = {folder.resolve() for folder in recorder.find_placements(trained)}
    train, test = list[recorder.Placement](), list[recorder.Placement]()
    for placement in recorder.read_placements(*trained, *tested, as_recorded=as_recorded):
        own = placement.path is not None and placement.path.resolve() in folders
        (train if own else test).append(placement)
    return (train, test) if train else (recorder.read_placements(*trained), test)


def _show(terminal: Terminal, one: "calibration.Calibration") -> None:
    """Print the figures of one robot."""
    terminal.say(assessment.distance_text(one.document.placements))
    if one.document.scale is not None:
        terminal.say(f"Size: {assessment.scale_text(one.document.scale)}.")
    show_errors(one.errors, terminal)
    _show_parameters(one.result.parameters, terminal)
    terminal.say(*_remarks(one.document))


def _show_parameters(rows: "Sequence[results.ParameterValue]", terminal: Terminal) -> None:
    """Show the changes of the joint origins in mm and mrad, one line a joint."""
    from ....solver.robot import COMPONENTS

    changes = {(row.joint, row.component): f"{1e3 * row.change:+.3f}" for row in rows}
    joints = dict.fromkeys(row.joint for row in rows)
    cells = [[joint, *(changes.get((joint, c), "fixed") for c in COMPONENTS)] for joint in joints]
    title = "change of the joint origins, in mm and mrad"
    terminal.tabulate(title, ("joint", *COMPONENTS), cells, no_wrap=True)


def _remarks(result: "results.CalibrationDocument") -> list[str]:
    """Return lines on the fit that the tables do not have."""
    lines = [
        f"{result.optimizer}: {result.iterations} iterations in "
        f"{1e3 * result.solve_seconds:.0f} ms."
    ]
    lines += result.choices or ()
    lines += _frame_lines(result.frames or ())
    if result.uncertainty is not None:
        distance = result.uncertainty.distance_deviation
        alone = "" if distance.alone is None else f"; the URDF alone {1e3 * distance.alone:.2f} mm"
        lines.append(
            f"Predicted error of distances in the workspace, 1 sigma: median "
            f"{1e3 * distance.median:.2f} mm, worst {1e3 * distance.worst:.2f} mm{alone}."
        )
        lines += [f"Not seen: {text}." for text in result.uncertainty.cannot_see]
    return lines


def _frame_lines(frames: "Sequence[results.FramePose]") -> list[str]:
    """Pose of each frame and its deviation, a line each."""
    lines: list[str] = []
    for frame in frames:
        error = ""
        if frame.socket_error is not None:
            sockets = f"{frame.sockets} socket{'s are' if frame.sockets > 1 else ' is'}"
            error = f"; its {sockets} {millimetres(frame.socket_error)} mm off (rms)"
        if frame.name == "base":
            lines.append(f"Frame base: the robot's own{error}.")
        elif not frame.turn_known:
            lines.append(
                f"Frame {frame.name}: direction unknown{error}; it needs three places or more that "
                "are not on one line."
            )
        else:
            position = " ".join(f"{1e3 * v:+.2f}" for v in frame.xyz)
            rotation = " ".join(f"{math.degrees(v):+.3f}" for v in frame.rpy)
            lines.append(
                f"Frame {frame.name} stands at {position} mm "
                f"(+- {millimetres(max(frame.xyz_deviation))}), turned {rotation} deg "
                f"(+- {math.degrees(max(frame.turn_deviation)):.3f}) in the base{error}."
            )
    return lines


def _closing_lines(outputs: dict[str, str], *, usable: bool) -> list[str]:
    if not outputs:
        return ["Nothing was written; add --out DIR to keep the calibrated URDF."]
    if "arms" in outputs:
        together = (
            f"{outputs['urdf']}, all robots in one URDF" if "urdf" in outputs else outputs["arms"]
        )
        return [f"Wrote {together}, and a folder for each robot."]
    written = (
        f"Wrote {outputs['calibration']}, and {outputs['report']} to read; report.json beside it "
        "holds the same figures for scripts"
    )
    if not usable:
        return [written, f"Wrote {outputs['urdf']}: do not load it, see above."]
    return [
        written,
        f"Wrote {outputs['urdf']}: load it instead of the nominal URDF, in robot_state_publisher, "
        "MoveIt, Pinocchio, Drake, or whatever computes the arm's kinematics.",
        "Redo camera extrinsics, and poses taught in Cartesian space: they hold the old model's "
        "errors.",
    ]
