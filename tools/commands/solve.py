"""``mukca solve``: calibrate a robot from recordings."""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...solver.robot.urdf import Robot
from ..arguments import (
    load_of,
    measure_all,
    robot_of,
    split_test,
)
from ..files import refuse_existing, write_files
from ..solve_options import COMMON, ONLY_AUTO, ONLY_PAPER, add_options, settle
from ..terminal import Terminal

if TYPE_CHECKING:
    from ...solver.data.measurements import Measurement
    from ...solver.data.observations import KnownDistance
    from ..outcome import Outcome

EXAMPLE = """example:
  mukca solve recordings/front --test recordings --robot panda --out calibrated

A placement is a folder with a recording, or with hole_0.csv and hole_1.csv; a folder of
placements stands for all of them."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    add_options(parser)


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Calibrate, show the figures, and write the results."""
    settle(arguments)
    if arguments.out is not None:
        refuse_existing(arguments.out, force=arguments.force)
    robot = robot_of(arguments)
    test_paths, left_out = split_test(arguments.train, arguments.test)
    sockets = 1 if arguments.method == "auto" else 2
    train = measure_all(arguments.train, robot, arguments.distance, sockets=sockets)
    test = measure_all(test_paths, robot, arguments.distance, sockets=sockets)
    train, looked, said = look_at(robot, train, test, arguments)
    warnings = [*left_out, *(line for m in (*train, *test) for line in m.warnings)]
    for line in [*warnings, *said]:
        terminal.warn(line)
    outcome = calibrate(robot, train, test, arguments, terminal)
    result = outcome.result
    result.update(looked, warnings=warnings)
    show(terminal, result)
    status = 0
    if outcome.distorted and not arguments.accept_distorted:
        terminal.warn(
            f"refused: the calibrated model does not reproduce the sockets' distance at "
            f"{', '.join(outcome.distorted)}; it has shrunk or bent to bring the samples together. "
            "Check --distance, that sockets are not mixed up, and the data; --accept-distorted "
            "exports it"
        )
        status = 1
    elif arguments.out is not None:
        result["outputs"] = write(arguments.out, outcome, train, test)
        report(arguments.out, terminal)
    if arguments.json:
        terminal.emit(result)
    if status == 0:
        for line in last_words(result["outputs"]):
            terminal.say(line)
    return status


def look_at(
    robot: Robot,
    train: "list[Measurement]",
    test: "list[Measurement]",
    arguments: argparse.Namespace,
) -> "tuple[list[Measurement], dict[str, Any], list[str]]":
    """Look at all placements; what is held out is looked at here and never by the fit.

    Returns:
        The placements to train on, split where a base moved if asked for; ``checks`` and
        ``next_placement`` of the result, where the data could be checked; a line for each
        finding.
    """
    from ...solver.checks.changes import split_at
    from ...solver.checks.inspection import inspect_all, next_placement
    from ...solver.data.measurements import check_distinct
    from ...solver.paper.optimizers import NotConverged
    from ...solver.robot.parameters import choose_parameters

    check_distinct([*train, *test])
    load = load_of(arguments)
    try:
        seen = inspect_all(robot, choose_parameters(robot), [*train, *test], load)
    except NotConverged as error:
        if arguments.split_moved:
            raise
        return train, {}, [f"the data could not be checked: {error}"]
    findings = [finding for one in seen for finding in one.findings]
    if arguments.split_moved:
        alone = inspect_all(robot, choose_parameters(robot), train, load) if test else seen
        train = [split_at(one.measured, one.changes) for one in alone]
    looked = {
        "checks": [finding.as_dict() for finding in findings],
        "next_placement": {"text": next_placement(robot, seen)},
    }
    return train, looked, list(map(str, findings))


def calibrate(
    robot: Robot,
    train: "list[Measurement]",
    test: "list[Measurement]",
    arguments: argparse.Namespace,
    terminal: Terminal,
) -> "Outcome":
    """Return the outcome of the method asked for."""
    from ...solver.robot.parameters import choose_parameters
    from ..outcome import AutoSettings, calibrate_by_auto, calibrate_by_paper, provenance

    parameters = choose_parameters(robot, arguments.free, arguments.fix)
    if arguments.method == "paper":
        outcome = calibrate_by_paper(
            robot,
            parameters,
            train,
            test,
            optimizer=arguments.optimizer,
            regularization=arguments.regularization,
            max_iterations=arguments.max_iterations,
        )
    else:
        settings = AutoSettings(
            known_distances(arguments.known),
            arguments.distance_deviation,
            load_of(arguments),
            tuple(arguments.without),
        )
        with terminal.progress() as progress:
            outcome = calibrate_by_auto(robot, parameters, train, test, settings, progress)
    names = (*COMMON, *(ONLY_PAPER if arguments.method == "paper" else ONLY_AUTO))
    outcome.result.update(
        robot=arguments.robot,
        settings={name: getattr(arguments, name) for name in names},
        provenance=provenance(robot, [*train, *test]),
        outputs={},
    )
    return outcome


def known_distances(words: Sequence[str]) -> "tuple[KnownDistance, ...]":
    """Return known distances from words, each one distance or a file of them.

    Raises:
        KnownError: A distance that cannot be understood.
    """
    from ...solver.data.observations import parse_known

    lines: list[str] = []
    for word in words:
        file = Path(word)
        if file.is_file():
            text = file.read_text(encoding="utf-8")
            lines += [line for line in text.splitlines() if line.split("#")[0].strip()]
        else:
            lines.append(word)
    return tuple(parse_known(line.split("#")[0]) for line in lines)


def show(terminal: Terminal, result: dict[str, Any]) -> None:
    """Print the figures for people."""
    import msgspec

    from ..console_tables import metrics_table, parameters_table
    from ..documents.calibration import Result

    typed = msgspec.convert(result, Result)
    terminal.console.print(metrics_table(typed.placements, typed.summary))
    terminal.console.print(parameters_table(typed.parameters))
    for line in spoken(result):
        terminal.say(line)


def spoken(result: dict[str, Any]) -> list[str]:
    """Return what the tables do not say."""
    lines = [
        f"{result['optimizer']}: {result['iterations']} iterations in "
        f"{1e3 * result['solve_seconds']:.0f} ms."
    ]
    held_out = result["summary"]["test"]
    summary = held_out or result["summary"]["train"]
    if "ball_refitted" in summary:
        error = 1e3 * summary["ball_refitted"]["mean_absolute_error"]
        lines.append(
            f"With only the ball refitted, the nominal model stands at {error:.3f} mm MAE."
        )
    lines += result.get("choices", [])
    if "geometric" in summary:
        full = 1e3 * summary["calibrated"]["mean_absolute_error"]
        alone = 1e3 * summary["geometric"]["mean_absolute_error"]
        lines.append(
            f"The full model, with joint deflections, stands at {full:.3f} mm; the exported URDF, "
            f"geometry alone, at {alone:.3f} mm."
        )
    if "uncertainty" in result:
        distance = result["uncertainty"]["distance_deviation"]
        lines.append(
            f"Predicted error of distances in the workspace, 1 sigma: median "
            f"{1e3 * distance['median']:.2f} mm, worst {1e3 * distance['worst']:.2f} mm."
        )
        lines += [f"Not seen: {text}." for text in result["uncertainty"]["cannot_see"]]
    if held_out is None:
        lines.append("Not validated: no placement was held out. Add one by --test.")
    return lines


def write(
    folder: Path,
    outcome: "Outcome",
    train: "list[Measurement]",
    test: "list[Measurement]",
) -> dict[str, str]:
    """Write the calibrated URDF and calibration.json; return their paths."""
    from ...solver.calibrated import FORMAT
    from ...solver.result import samples

    calibration = outcome.calibration
    contents = {"calibrated.urdf": calibration.urdf(folder)}
    outputs = {"urdf": str(folder / "calibrated.urdf")}
    if calibration.exported is not None:
        contents["compensated.urdf"] = calibration.urdf(folder, compensated=True)
        outputs["compensated_urdf"] = str(folder / "compensated.urdf")
    outputs["calibration"] = str(folder / "calibration.json")
    outputs["report"] = str(folder / "report.html")
    document = {
        "format": FORMAT,
        **calibration.as_dict(),
        **outcome.result,
        "data": [
            *(samples(m, "train", outcome.weights.get(m.name)) for m in train),
            *(samples(m, "test") for m in test),
        ],
        "outputs": outputs,
    }
    contents["calibration.json"] = json.dumps(document, indent=1, allow_nan=False).encode()
    write_files(folder, contents)
    return outputs


def report(folder: Path, terminal: Terminal) -> None:
    """Write the report of the calibration in a folder, and show its verdict."""
    from ..documents.calibration import read_calibration
    from ..report.build import build_report
    from ..report.console import show_verdict

    file = folder / "calibration.json"
    made = build_report(read_calibration(file), str(file))
    write_files(folder, made.files)
    show_verdict(terminal.console, made.figures)


def last_words(outputs: dict[str, str]) -> list[str]:
    """Return what to do with the result."""
    if not outputs:
        return ["Nothing was written; add --out DIR to keep the calibrated URDF."]
    lines = [
        f"Wrote {outputs['calibration']}, and {outputs['report']} to read",
        f"Wrote {outputs['urdf']}: load it instead of the nominal URDF, in robot_state_publisher, "
        "MoveIt, Pinocchio, Drake, or whatever computes the arm's kinematics.",
    ]
    if "compensated_urdf" in outputs:
        lines.append(
            f"Wrote {outputs['compensated_urdf']}: only for joint positions that are corrected "
            "first, see docs/model.md."
        )
    lines.append(
        "Redo camera extrinsics, and poses taught in Cartesian space: they hold the old model's "
        "errors."
    )
    return lines
