"""``mukca solve``: calibrate a robot from recordings."""

import argparse
import hashlib
import json
import platform
from datetime import datetime, timezone
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...solver.urdf import Chain
from ..arguments import UsageError, add_robot, chain_of, measure_all, split_test
from ..files import refuse_existing, write_files
from ..terminal import Terminal

if TYPE_CHECKING:
    from ...solver.calibrate import Fit
    from ...solver.calibration import Calibration
    from ...solver.measurements import Measurement

EXAMPLE = """example:
  mukca solve recordings/front --test recordings --robot panda --out calibrated

A placement is a folder with a recording, or with hole_0.csv and hole_1.csv; a folder of
placements stands for all of them."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    parser.add_argument("train", nargs="+", type=Path, metavar="TRAIN", help="placements to fit")
    parser.add_argument(
        "--test", nargs="+", type=Path, default=[], metavar="HELD_OUT", help="placements held out"
    )
    add_robot(parser)
    fit = parser.add_argument_group("fit")
    fit.add_argument("--method", choices=("paper",), default="paper", help="Eq. (5) of the paper")
    fit.add_argument(
        "--optimizer",
        choices=("gauss-newton", "ipopt"),
        default="gauss-newton",
        help="both reach the same minimum; ipopt is the paper's (default: %(default)s)",
    )
    fit.add_argument(
        "--distance",
        type=float,
        metavar="M",
        help="distance of the sockets' centres in metres (default: the recording's, or 0.05)",
    )
    fit.add_argument(
        "--regularization", type=float, default=1e-4, metavar="L", help="lambda (default: 1e-4)"
    )
    words = "joint names, JOINT.x .. JOINT.yaw, JOINT.xyz or JOINT.rpy; * stands for any text"
    fit.add_argument("--free", nargs="+", default=[], metavar="P", help=f"what is free: {words}")
    fit.add_argument("--fix", nargs="+", default=[], metavar="P", help="what is not, likewise")
    fit.add_argument("--max-iterations", type=int, default=200, metavar="N", help="steps allowed")
    fit.add_argument(
        "--accept-distorted",
        action="store_true",
        help="export even a model that does not reproduce the sockets' distance",
    )
    output = parser.add_argument_group("output")
    output.add_argument("--out", type=Path, metavar="DIR", help="write the results to this folder")
    output.add_argument("--force", action="store_true", help="overwrite results in DIR")
    output.add_argument("--json", action="store_true", help="print one JSON object, SI units")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Calibrate, show the figures, and write the results."""
    if arguments.max_iterations < 1:
        raise UsageError(f"--max-iterations {arguments.max_iterations}: at least 1 is needed")
    if arguments.out is not None:
        refuse_existing(arguments.out, force=arguments.force)
    chain = chain_of(arguments)
    test_paths, left_out = split_test(arguments.train, arguments.test)
    train = measure_all(arguments.train, chain, arguments.distance)
    test = measure_all(test_paths, chain, arguments.distance)
    warnings = [*left_out, *(line for m in (*train, *test) for line in m.warnings)]
    for line in warnings:
        terminal.warn(line)
    calibration, result, distorted = solve(chain, train, test, arguments, warnings)
    show(terminal, result)
    status = 0
    if distorted and not arguments.accept_distorted:
        terminal.warn(
            f"refused: the calibrated model does not reproduce the sockets' distance at "
            f"{', '.join(distorted)}; it has shrunk or bent to bring the samples together. Check "
            "--distance, that sockets are not mixed up, and the data; --accept-distorted exports it"
        )
        status = 1
    elif arguments.out is not None:
        result["outputs"] = write(arguments.out, calibration, result, train, test)
    if arguments.json:
        terminal.emit(result)
    if status == 0:
        for line in last_words(result["outputs"]):
            terminal.say(line)
    return status


def solve(
    chain: Chain,
    train: "list[Measurement]",
    test: "list[Measurement]",
    arguments: argparse.Namespace,
    warnings: list[str],
) -> "tuple[Calibration, dict[str, Any], list[str]]":
    """Return the calibration, its machine-readable result, and placements it distorts."""
    from ...solver.calibrate import build_problem, calibrate, refit_ball
    from ...solver.calibration import Calibration
    from ...solver.measurements import check_distinct
    from ...solver.parameters import choose_parameters
    from ...solver.result import figures, history, models_of
    from ...solver.validate import evaluate, is_distorted

    check_distinct([*train, *test])
    problem = build_problem(
        chain,
        train,
        parameters=choose_parameters(chain, arguments.free, arguments.fix),
        regularization=arguments.regularization,
    )
    fit = calibrate(problem, arguments.optimizer, arguments.max_iterations)
    calibration = Calibration(chain, problem.parameters, fit.x)
    distorted = [
        m.name for m in train if is_distorted(evaluate(calibration.ball(m.positions), m), m)
    ]
    result: dict[str, Any] = {
        "robot": arguments.robot,
        "method": arguments.method,
        **fit_summary(fit),
        **figures(models_of(calibration, refit_ball(problem)), train, test),
        "distorted": distorted,
        "parameters": calibration.table(),
        "history": history(fit, test),
        "settings": {
            "distance": arguments.distance,
            "regularization": arguments.regularization,
            "free": arguments.free,
            "fix": arguments.fix,
            "max_iterations": arguments.max_iterations,
        },
        "warnings": warnings,
        "provenance": provenance(chain, train, test),
        "outputs": {},
    }
    return calibration, result, distorted


def fit_summary(fit: "Fit") -> dict[str, Any]:
    """Return how the optimizer arrived."""
    return {
        "optimizer": fit.optimizer,
        "iterations": fit.solution.iterations,
        "converged": True,
        "solve_seconds": fit.seconds,
    }


def provenance(
    chain: Chain, train: "list[Measurement]", test: "list[Measurement]"
) -> dict[str, Any]:
    """Return what the result was made from and with: digests, versions, time."""
    return {
        "created": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "model_sha256": chain.sha256,
        "data_sha256": {
            str(file): hashlib.sha256(file.read_bytes()).hexdigest()
            for measured in (*train, *test)
            for file in measured.placement.files
        },
        "versions": {
            "python": platform.python_version(),
            **{name: version(name) for name in ("mukca", "casadi", "numpy", "yourdfpy")},
        },
    }


def show(terminal: Terminal, result: dict[str, Any]) -> None:
    """Print the figures for people."""
    from ..tables import metrics_table, parameters_table

    terminal.console.print(metrics_table(result))
    terminal.console.print(parameters_table(result["parameters"]))
    refitted = result["summary"]["test"] or result["summary"]["train"]
    terminal.say(
        f"{result['optimizer']}: {result['iterations']} iterations in "
        f"{1e3 * result['solve_seconds']:.0f} ms. With only the ball refitted, the nominal model "
        f"would stand at {1e3 * refitted['ball_refitted']['mean_absolute_error']:.3f} mm MAE."
    )
    if result["summary"]["test"] is None:
        terminal.say("Not validated: no placement was held out. Add one by --test.")


def write(
    folder: Path,
    calibration: "Calibration",
    result: dict[str, Any],
    train: "list[Measurement]",
    test: "list[Measurement]",
) -> dict[str, str]:
    """Write the calibrated URDF and calibration.json; return their paths."""
    from ...solver.calibration import FORMAT
    from ...solver.result import samples

    outputs = {
        "urdf": str(folder / "calibrated.urdf"),
        "calibration": str(folder / "calibration.json"),
    }
    document = {
        "format": FORMAT,
        **result,
        **calibration.as_dict(),
        "data": [*(samples(m, "train") for m in train), *(samples(m, "test") for m in test)],
        "outputs": outputs,
    }
    write_files(
        folder,
        {
            "calibrated.urdf": calibration.urdf(folder),
            "calibration.json": json.dumps(document, indent=1, allow_nan=False).encode(),
        },
    )
    return outputs


def last_words(outputs: dict[str, str]) -> list[str]:
    """Return what to do with the result."""
    if not outputs:
        return ["Nothing was written; add --out DIR to keep the calibrated URDF."]
    return [
        f"Wrote {outputs['calibration']}",
        f"Wrote {outputs['urdf']}: load it instead of the nominal URDF, in robot_state_publisher, "
        "MoveIt, Pinocchio, Drake, or whatever computes the arm's kinematics.",
        "Redo camera extrinsics, and poses taught in Cartesian space: they hold the old model's "
        "errors.",
    ]
