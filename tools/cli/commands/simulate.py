"""``mukca simulate``: the paper's experiments in simulation, with the model under test."""

import argparse
import importlib
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ....errors import MukcaError
from ....solver.results import refuse_existing, write_files
from .. import Terminal
from ..robot_arguments import UsageError
from .demo import DEMO_SEED, demo_arm

if TYPE_CHECKING:
    from ...experiments import (
        Drawing,
        ExperimentRun,
        Insertions,
        ModelTrials,
        Settings,
        SimulationDocument,
    )

EXAMPLE = """example:
  mukca simulate insertion --model nominal --hole-mm 16
  mukca simulate insertion --model calibrated --hole-mm 10.4 --cross 24
  mukca simulate drawing --out drawing

The arm moves by its true kinematics; its controller, Cartesian impedance control, knows only the
model that it is given: nominal, calibrated (from four placements recorded with this arm, made
now), true, or the file of a calibrated URDF of this arm. Goals are taught once, elbow up; each
trial starts with the elbow elsewhere. Needs the extra: pip install 'mukca[simulation]'"""
INSERTION = "put a peg into a hole from other postures than that in which it was taught"
DRAWING = "retrace a drawing from other postures than that in which it was shown"
REPORT, RESULT, PICTURE, ANIMATION = FILES = (
    "report.html",
    "simulation.json",
    "picture.png",
    "animation.gif",
)


class MissingExtra(MukcaError):  # noqa: N818 (the situation's name)
    """A package of the extra ``simulation`` is not installed."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    experiments = parser.add_subparsers(dest="experiment", metavar="EXPERIMENT", required=True)
    insertion = experiments.add_parser("insertion", help=INSERTION, description=INSERTION)
    insertion.add_argument(
        "--hole-mm", type=float, default=10.4, metavar="MM", help="its diameter; the peg has 10 mm"
    )
    insertion.add_argument(
        "--cross",
        type=int,
        default=0,
        metavar="N",
        help="then at N positions of an X of 25 mm steps, 24 at most (default: 0)",
    )
    drawing = experiments.add_parser("drawing", help=DRAWING, description=DRAWING)
    for experiment, trials in ((insertion, 20), (drawing, 6)):
        _add_common(experiment, trials)


def _add_common(parser: argparse.ArgumentParser, trials: int) -> None:
    parser.add_argument(
        "--model",
        default="calibrated",
        help="nominal, calibrated, true, or a URDF file (default: calibrated)",
    )
    parser.add_argument(
        "--trials", type=int, default=trials, metavar="N", help="(default: %(default)s)"
    )
    parser.add_argument("--arm", type=int, default=DEMO_SEED, metavar="SEED", help="which true arm")
    parser.add_argument("--seed", type=int, default=0, help="of recordings, teaching and starts")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="try the nominal model too (with --model nominal, the calibrated one), and write a "
        "report with both side by side",
    )
    parser.add_argument("--force", action="store_true", help="overwrite results in DIR")
    parser.add_argument("--json", action="store_true", help="print one JSON object, SI units")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Run the trials, and show what came of them."""
    settle(arguments)
    words, out = [arguments.model], arguments.out
    if out is not None:
        refuse_existing(out, FILES, force=arguments.force)
        words.insert(0, "calibrated" if arguments.model == "nominal" else "nominal")
    models = attempts(arguments, words, terminal)
    for model in models:
        for place, figures in trials_of(model.results):
            terminal.say(f"{model.results.model}, {place}: {spoken(arguments, figures)}")
    result = document_of(arguments, models)
    if out is not None:
        result = write(out, result, models, terminal)
    if arguments.json:
        terminal.emit(result)
    return 0


def document_of(
    arguments: argparse.Namespace, models: "Sequence[ExperimentRun]"
) -> "SimulationDocument":
    """Return the result of the model asked for, which is the last, beside the other one."""
    import msgspec

    from ...experiments import SimulationDocument

    *other, asked = models
    return SimulationDocument(
        experiment=arguments.experiment,
        arm=arguments.arm,
        seed=arguments.seed,
        hole=arguments.hole_mm / 1e3 if arguments.experiment == "insertion" else None,
        beside=other[0].results if other else None,
        **msgspec.structs.asdict(asked.results),
    )


def trials_of(model: "ModelTrials") -> "list[tuple[str, Insertions | Drawing]]":
    """Return the trials of a model, by the name of their place."""
    places = (("centre", model.centre), ("cross", model.cross), ("drawing", model.drawing))
    return [(name, trials) for name, trials in places if trials is not None]


def settle(arguments: argparse.Namespace) -> None:
    """See that the numbers can be.

    Raises:
        UsageError: One of them cannot, or an option would do nothing.
    """
    if arguments.force and arguments.out is None:
        raise UsageError("--force belongs to --out DIR; nothing is written without it")
    if arguments.arm < 0 or arguments.seed < 0:
        raise UsageError("--arm and --seed are at least 0")
    if arguments.experiment == "drawing":
        if arguments.trials < 2:
            raise UsageError(f"--trials {arguments.trials}: give 2 or more lines to hold together")
        return
    if not 10.1 <= arguments.hole_mm <= 40:
        raise UsageError(f"--hole-mm {arguments.hole_mm}: give 10.1 to 40; the peg has 10 mm")
    if arguments.trials < 1 or not 0 <= arguments.cross <= 24:
        raise UsageError("--trials is at least 1, --cross 0 to 24")


def attempts(
    arguments: argparse.Namespace, words: Sequence[str], terminal: Terminal
) -> "list[ExperimentRun]":
    """Try models on the arm, one after the other.

    Raises:
        MissingExtra: The packages are not installed.
    """
    _load_mujoco()
    from ...experiments import model_urdf, run_experiment

    settings = _settings(arguments)
    nominal, arm = demo_arm(arguments.arm, keep_size=False)
    with terminal.progress(settings.count * len(words)) as progress:
        return [
            run_experiment(
                settings, arm, word, model_urdf(word, nominal, arm, arguments.seed), progress
            )
            for word in words
        ]


def _load_mujoco() -> None:
    """Import what the experiments need.

    MuJoCo would load OpenGL with it, and fail with it; only pictures need that, later.

    Raises:
        MissingExtra: A package is not there.
    """
    wish = os.environ.get("MUJOCO_GL", "")
    os.environ["MUJOCO_GL"] = "disable"
    try:
        importlib.import_module("mujoco")
        importlib.import_module("pinocchio")
    except ImportError as error:
        raise _missing(error) from None
    finally:
        os.environ["MUJOCO_GL"] = wish


def _settings(arguments: argparse.Namespace) -> "Settings":
    from ...experiments import Settings

    if arguments.experiment == "drawing":
        return Settings(arguments.trials, arguments.seed)
    return Settings(arguments.trials, arguments.seed, arguments.hole_mm / 1e3, arguments.cross)


def _missing(error: ImportError) -> MissingExtra:
    return MissingExtra(
        f"{error.name} is not installed; install the extra: pip install 'mukca[simulation]'"
    )


def write(
    folder: Path,
    result: "SimulationDocument",
    models: "Sequence[ExperimentRun]",
    terminal: Terminal,
) -> "SimulationDocument":
    """Write the report, its figures, and pictures where this machine can make them."""
    import msgspec

    from ....solver.results import encode
    from ...report.page import simulation_page

    pictures = pictures_of(models, terminal)
    names = [REPORT, RESULT, *pictures]
    outputs = {name.split(".")[0]: str(folder / name) for name in names}
    result = msgspec.structs.replace(result, outputs=outputs)
    page = simulation_page(result, pictures).encode()
    write_files(folder, {REPORT: page, RESULT: encode(result) + b"\n", **pictures})
    terminal.say(f"Report: {folder / REPORT}")
    return result


def pictures_of(models: "Sequence[ExperimentRun]", terminal: Terminal) -> dict[str, bytes]:
    """Return the picture and the animation; none, with a warning, where nothing can render."""
    try:
        from ...experiments import PictureError, film
    except ImportError as error:
        terminal.warn(f"no pictures: {_missing(error)}")
        return {}
    try:
        made = film(models)
    except PictureError as error:
        terminal.warn(str(error))
        return {}
    return {PICTURE: made.picture, ANIMATION: made.animation}


def spoken(arguments: argparse.Namespace, trials: "Insertions | Drawing") -> str:
    """Return the results at one place for people."""
    from ...experiments import Drawing

    if isinstance(trials, Drawing):
        what = (
            f"{trials.retracings} lines apart by {1e3 * trials.spread:.2f} mm on average, "
            f"{1e3 * trials.max_spread:.2f} mm at most; off the figure by"
        )
    else:
        what = (
            f"{trials.inserted} of {trials.trials} into {arguments.hole_mm:g} mm; "
            "above the hole off by"
        )
    return (
        f"{what} {1e3 * trials.tracking_error:.2f} mm on average, "
        f"{1e3 * trials.max_tracking_error:.2f} mm at most; contact force "
        f"{trials.force.mean:.1f} N on average, {trials.peak_force.max:.1f} N at most"
    )
