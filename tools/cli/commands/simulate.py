"""``mukca simulate`` and ``demo``: the experiments, and the whole job, on simulated arms."""

import importlib
import os
import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

from .... import recorder
from ....errors import MukcaError
from ....solver.calibration import load_calibration
from ....solver.results import OutputError, encode, refuse_existing, write_files
from ... import experiments, simulation
from .. import JsonOption, Terminal
from .main import run_verb
from .verbs import build_parser

REPORT, RESULT, PICTURE, ANIMATION = FILES = (
    "report.html",
    "simulation.json",
    "picture.png",
    "animation.gif",
)


class _ExperimentOptions(JsonOption):
    model: str = "calibrated"
    arm: int | None = None
    seed: int = 0
    out: Path | None = None
    force: bool = False


class InsertionOptions(_ExperimentOptions):
    """Options of ``mukca simulate insertion``."""

    experiment: ClassVar = "insertion"
    line: ClassVar = (
        "put a peg into a hole from other postures than that in which it was taught"
    )
    hole_mm: float = 10.4
    cross: int = 0
    trials: int = 20


class DrawingOptions(_ExperimentOptions):
    """Options of ``mukca simulate drawing``."""

    experiment: ClassVar = "drawing"
    line: ClassVar = (
        "retrace a drawing from other postures than that in which it was shown"
    )
    hole_mm: ClassVar = None
    cross: ClassVar = 0
    trials: int = 6


Experiment = InsertionOptions | DrawingOptions


def run_simulate(options: Experiment, terminal: Terminal) -> int:
    """Run the trials, and show their results."""
    words = [options.model]
    out = options.out
    if out:
        refuse_existing(out, FILES, force=options.force)
        words.insert(0, "calibrated" if options.model == "nominal" else "nominal")
    _load_mujoco()
    hole = None if options.hole_mm is None else options.hole_mm / 1e3
    seed = simulation.DEMO_SEED if options.arm is None else options.arm
    nominal, arm = simulation.demo_arm(seed, keep_size=False)
    settings = experiments.Settings(options.trials, options.seed, hole, options.cross)
    with terminal.progress(settings.count * len(words)) as progress:
        urdfs = {
            word: experiments.model_urdf(word, nominal, arm, options.seed)
            for word in words
        }
        models = [
            experiments.run_experiment(settings, arm, word, urdf, progress)
            for word, urdf in urdfs.items()
        ]
    *other, asked = (model.results for model in models)
    for results in (*other, asked):
        lines = _lines(results, options.hole_mm)
        terminal.say(*(f"{results.model}, {line}" for line in lines))
    result = experiments.SimulationDocument.filled(
        asked,
        experiment=options.experiment,
        arm=seed,
        seed=options.seed,
        hole=hole,
        beside=other[0] if other else None,
    )
    if out:
        result = _write(out, result, models, terminal)
    terminal.emit(result)
    return 0


def _load_mujoco() -> None:
    """Import MuJoCo without OpenGL, which only pictures need, and Pinocchio."""
    before = os.environ.get("MUJOCO_GL", "")
    os.environ["MUJOCO_GL"] = "disable"
    try:
        for module in ("mujoco", "pinocchio"):
            importlib.import_module(module)
    except ImportError as error:
        raise _missing(error) from None
    finally:
        os.environ["MUJOCO_GL"] = before


def _missing(error: ImportError) -> MukcaError:
    return MukcaError(
        f"{error.name} is not installed; install the extra: pip install 'mukca[simulation]'"
    )


def _write(
    folder: Path,
    result: "experiments.SimulationDocument",
    models: "Sequence[experiments.ExperimentRun]",
    terminal: Terminal,
) -> "experiments.SimulationDocument":
    """Write the report, its figures, and pictures where this machine can make them."""
    from msgspec import structs

    pictures: dict[str, bytes] = {}
    try:
        films = experiments.film(models)
        pictures = dict(zip((PICTURE, ANIMATION), films, strict=True))
    except ImportError as error:
        terminal.warn(f"no pictures: {_missing(error)}")
    except MukcaError as error:
        terminal.warn(str(error))
    names = [REPORT, RESULT, *pictures]
    outputs = {name.split(".")[0]: str(folder / name) for name in names}
    result = structs.replace(result, outputs=outputs)
    html = experiments.simulation_page(result, pictures).encode()
    write_files(folder, {REPORT: html, RESULT: encode(result) + b"\n", **pictures})
    terminal.say(f"Report: {folder / REPORT}")
    return result


def _lines(results: "experiments.ModelTrials", hole_mm: float | None) -> list[str]:
    """Return the results at each place for people."""
    places: list[tuple[str, str, experiments.Insertions | experiments.Drawing]] = []
    for name, trials in (("centre", results.centre), ("cross", results.cross)):
        if trials:
            done = f"{trials.inserted} of {trials.trials} into {hole_mm:g} mm"
            places.append((name, f"{done}; above the hole off by", trials))
    if drawn := results.drawing:
        apart = f"{1e3 * drawn.spread:.2f} mm on average, {1e3 * drawn.max_spread:.2f} mm at most"
        done = f"{drawn.retracings} lines apart by {apart}; off the figure by"
        places.append(("drawing", done, drawn))
    return [
        f"{name}: {done} {1e3 * trials.tracking_error:.2f} mm on average, "
        f"{1e3 * trials.max_tracking_error:.2f} mm at most; contact force "
        f"{trials.force.mean:.1f} N on average, {trials.peak_force.max:.1f} N at most"
        for name, done, trials in places
    ]


NEXT = """
To lead a session yourself, with a simulated hand that follows what the screen says:
  mukca record --robot panda --driver 'mock:{hand}?follow' --distance 0.1 --out {hand}-led

Next, with an arm of your own (`mukca drivers` lists which): print the base and the ball, measure
the distance of the sockets' centres in metres, record at two places or more, and solve as above.
  mukca print-parts --out parts
  mukca record --robot panda --driver franka:172.16.0.2 --distance 0.1001 --out recordings/front"""
DISTANCE = 0.1
"""Between the sockets of the printed base [m]."""
SPEED = 10
"""Speed of the hand against a person's, and of the recorder with it."""
KEYS = "keys.txt"


class _DemoOptions(JsonOption):
    out: Path = Path("demo")
    force: bool = False


def run_demo(options: _DemoOptions, terminal: Terminal) -> int:
    """Record three placements of the demo arm, and calibrate on them."""
    from ...simulation import SimulatedTime, demo_bases, simulate_hand

    out = options.out
    refuse_existing(out, force=options.force)
    recordings = out / "recordings"
    calibrated = out / "calibrated"
    names = [base.name for base in demo_bases(DISTANCE)]
    for name in names:
        _remove_simulated(recordings / name)
    simulate_hand(out / "hand", out / KEYS, DISTANCE)
    part = replace(terminal, kept=[])  # the demo has JSON of its own
    brief = replace(part, brief=True, verbose=False)
    for name in names:
        driver = f"mock:{out / 'hand' / name}?follow&rate=100&speed={SPEED}&move=0.6"
        words = ["record", "--robot", "panda", "--driver", driver]
        words += ["--distance", str(DISTANCE)]
        words += ["--out", str(recordings / name), "--keys", str(out / KEYS)]
        # A busy computer is no fault of the arm.
        time = SimulatedTime(paced=terminal.console.is_terminal)
        with time.running():
            status = _typed(words, brief)
        if status != 0:
            return status
    words = ["solve", str(recordings), "--robot", "panda", "--out", str(calibrated)]
    status = _typed([*words, "--force"] if options.force else words, part)
    if status == 0:
        terminal.say(
            f"Recordings:      {recordings}",
            f"Calibrated URDF: {calibrated / 'calibrated.urdf'}",
            f"Report:          {calibrated / 'report.html'}",
            NEXT.format(hand=out / "hand" / names[0]),
        )
        summary = load_calibration(calibrated).errors.summary.left_out
        assert summary  # there are three placements
        before = summary.before.mean_absolute_error
        now = summary.loaded.mean_absolute_error
        report = calibrated / "report.html"
        terminal.say(
            "",
            f"It was: {1e3 * before:.2f} mm, the mean error at places left out, ball refitted.",
            f"It is:  {1e3 * now:.3f} mm there; {calibrated / 'calibrated.urdf'} is by all places.",
            f"Open:   {report}",
        )
        terminal.emit({"before": before, "now": now, "report": str(report)})
    return status


def _remove_simulated(folder: Path) -> None:
    """Remove an earlier demo's recording, which a recorder would else continue."""
    if (folder / recorder.SAMPLES).exists():
        file = folder / recorder.METADATA
        recorder.read_metadata(file)  # a damaged file is told by its name
        sessions = recorder.read_sessions(file)
        drivers = [str(session.get("driver")) for session in sessions]
        if not drivers or not all(name.startswith("mock:") for name in drivers):
            raise OutputError(
                f"{folder}: holds a recording of a real arm; choose another --out"
            )
    for name in (recorder.SAMPLES, recorder.METADATA):
        (folder / name).unlink(missing_ok=True)


def _typed(words: list[str], terminal: Terminal) -> int:
    """Run another verb, and show its command line."""
    terminal.say(f"\n$ {shlex.join(['mukca', *words])}\n")
    return run_verb(build_parser(words[0]).parse_args(words), terminal)
