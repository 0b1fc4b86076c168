"""Steps to do where the verdict is not PASS, the most useful first, each with a command."""

import shlex
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any, cast

from ....errors import MukcaError
from ....recorder import METADATA, RecordingError, read_keys, read_sessions
from ....solver.assessment import Assessment, PlacementReport, joined, joints_wrong, mm
from ....solver.calibration import SolveOptions
from ....solver.data import (
    CALIPER_DEVIATION,
    DEFAULT_DISTANCE,
    SAMPLES_ADVISED,
    Measurement,
    agreed_length,
    evaluate,
    readings_of,
    whole_name,
)
from ....solver.paper import build_problem, solve
from ....solver.results import CalibrationDocument, GivenArm, Role
from ....solver.robot import BALL_LINK
from .answers import farthest_held_out, placements_with_errors
from .types import Step

_SPAN = 0.5
"""A distance in the workspace [m]."""


def steps(result: Assessment) -> list[Step]:
    """Return the next step for a calibration; none where the verdict is PASS."""
    return list(islice(_steps(result), 1))


def _steps(result: Assessment) -> Iterator[Step]:
    """Yield steps, the most useful first."""
    verdict = result.verdict
    placements = result.placements
    if verdict.status == "pass":
        return
    document = result.predictions.document
    status = verdict.status_of
    if status("data_checks") != "pass":
        yield from _leave_out(result)
        text = "See what is wrong in the recordings; mend it, or leave it out by solve --leave-out"
        words = "figures that can be believed"
        folders = list(dict.fromkeys(row.folder for row in document.data))
        keys = ("distance", "known", "zeros")
        same = as_options({key: document.settings.get(key) for key in keys})
        command = shlex.join(["mukca", "check", *folders, *_one_robot(document), *same])
        yield Step(text, command, words)
    if {status("scale"), status("distance_given")} != {"pass"}:
        yield from _measure(document, placements)
    held_out = sum(row.role == "test" for row in placements)
    rows = (*verdict.limits, *verdict.reasons)
    open_ = not verdict.use or any(row.status in ("fail", "not enough") for row in rows)
    if open_ and held_out > 1 and (farthest := farthest_held_out(result)):
        best, gap = farthest
        name = placements[best].name
        short = whole_name(result.predictions.names[best])
        text = f"Train on {short} too: recorded already, {gap:.2f} m from the nearest trained on"
        yield _forecast(
            document, name, text, solve_command(document, moves={name: "train"})
        )
    yield from _corrected_joints(result)
    if all(row.kind == "points" for row in placements):
        if result.limits.repeatability is None:
            yield _repeatability(document)
        text = "Measure more points, in poses as varied as can be"
        words = ""
        if not held_out:
            text += ", and hold some of them out by solve --test"
            words = "an error that nothing was fitted to"
        yield Step(text, solve_command(document), words)
        return
    if result.limits.repeatability is None and held_out and verdict.use:
        yield _repeatability(document)
    text = (
        f"Record another placement far from the others, all varied, {SAMPLES_ADVISED}"
    )
    if document.arms is not None:
        text += ", with each of the arms, into folders of one name"
    text += ", and train on it too" if held_out else ", and hold it out by solve --test"
    yield _forecast(document, None, text, record_command(document))


def _corrected_joints(result: Assessment) -> Iterator[Step]:
    """Yield the step to correct joint positions, where the full model keeps all limits."""
    verdict = result.verdict
    missed = [row for row in verdict.limits if row.status in ("fail", "not enough")]
    if (
        not verdict.use
        or not missed
        or any(row.full_status != "pass" for row in missed)
    ):
        return
    first = missed[0]
    before = cast("float", first.found)
    after = cast("float", first.full)
    text = "Command corrected joint positions where the limits matter; no rigid URDF keeps them"
    words = f"{first.title}: {mm(after, 3)} in place of {mm(before, 3)}"
    file = result.predictions.document.outputs.get("calibration")
    folder = "DIR" if file is None else str(Path(file).parent)
    command = shlex.join(
        ["mukca", "command", folder, "poses.csv", "--out", "joints.csv"]
    )
    yield Step(text, command, words, before, after)


def _repeatability(document: CalibrationDocument) -> Step:
    """Return the step that says how well the arm repeats, without which there are no limits."""
    text = "Say how well the arm repeats, from its data sheet"
    command_line = solve_command(document, settings_given={"repeatability_mm": "MM"})
    return Step(
        text, command_line, "limits to hold the errors against, not a smaller error"
    )


def _measure(
    document: CalibrationDocument, placements: Sequence[PlacementReport]
) -> Iterator[Step]:
    """Yield the step to measure the sockets' distance, unless joints come before it."""
    scale = document.scale
    if not any(row.distance for row in placements) or joints_wrong(document.checks):
        return
    text = "Measure the sockets' distance, and type what you read"
    command = solve_command(document, settings_given={"distance": "MEASURED"})
    if scale is None:
        yield Step(text, command, "an arm of the right size")
        return
    deviation = scale.deviation or CALIPER_DEVIATION / DEFAULT_DISTANCE
    before = abs(scale.value) * _SPAN
    after = deviation * _SPAN
    words = f"a distance of {_SPAN:g} m is known to {mm(after)}"
    if before > after:
        words = (
            f"if it was wrong, the error of a distance of {_SPAN:g} m falls from {mm(before)} to "
            f"{mm(after)}; if you read the same, a length of the model is wrong"
        )
    yield Step(text, command, words, before, after)


def _forecast(
    document: CalibrationDocument, name: str | None, text: str, command: str
) -> Step:
    """Return a step with what the posterior forecasts of it, where it does."""
    rows = () if document.outlook is None else document.outlook.forecasts
    forecasts = {row.placement: row.distance_deviation for row in rows}
    if document.uncertainty is None or name not in forecasts:
        why = "only --method auto makes one"
        if document.method == "auto":
            why = "none of the places that were tried for it is within the arm's reach"
        return Step(text, command, f"no forecast: {why}")
    accuracy = document.uncertainty.distance_deviation
    before = accuracy.median
    after = forecasts[name]
    # several arms have a workspace each
    workspace = f" in {document.arm_name}'s own workspace" if document.arm_name else ""
    falls = f"falls from {mm(before)} to {mm(after)}"
    words = f"the predicted error of distances{workspace}, trained on it too, {falls}"
    return Step(text, command, words, before, after)


def _leave_out(result: Assessment) -> Iterator[Step]:
    """Yield the step to leave out placements with errors, with what Eq. (5) expects of it."""
    predictions = result.predictions
    bad = placements_with_errors(result)
    faulty = {result.placements[i].name for i in bad}
    paired = [p for p in predictions.placements if p.measured.has_distance]
    training = [p.measured for p in paired if p.role == "train"]
    remaining = [m for m in training if m.name not in faulty]
    judges = [p.measured for p in paired if p.role == "test" and p.name not in faulty]
    if not remaining or not judges or len(remaining) == len(training):
        return

    def held_out(train: Sequence[Measurement]) -> float:
        problem = build_problem(predictions.robot, train)
        x = solve(problem).x
        errors = (evaluate(problem.model.points(x, m.positions), m) for m in judges)
        return sum(error.mean_absolute_error for error in errors) / len(judges)

    with suppress(MukcaError):
        before = held_out(training)
        after = held_out(remaining)
        text = f"Leave out {joined([result.predictions.names[i] for i in bad])}"
        command = solve_command(
            predictions.document, moves=dict.fromkeys(sorted(faulty))
        )
        words = (
            f"the held-out error by Eq. (5) goes from {mm(before, 3)} to {mm(after, 3)}"
        )
        yield Step(text, command, words, before, after)


_LINKS = ("base", "tip", "flange")
"""Settings that name the links of a robot."""
_CHAIN = (*_LINKS, "ball")


def record_command(document: CalibrationDocument) -> str:
    """Return the command that records another placement, as the last one was recorded."""
    driver, distance = _recorded(Path(document.data[0].folder) / METADATA)
    words = [
        "mukca",
        "record",
        *_one_robot(document),
        "--driver",
        driver or "NAME:ADDRESS",
    ]
    words += as_options({"distance": _distance(document) or distance})
    if document.arms is not None:
        words += ["--robot-name", document.arm_name]
    return shlex.join([*words, "--out", str(_folder_beside(document))])


def _folder_beside(document: CalibrationDocument) -> Path:
    """Return a folder for another placement, beside the recordings and of another name."""
    folders = [Path(row.folder) for row in document.data if row.files]
    first = folders[0] if folders else Path("recordings", "first")
    # The parent of "." is "." itself.
    parent = first.parent if first.name else Path("..")
    names = {folder.resolve().name for folder in folders}
    tries = ("another", *(f"another-{number}" for number in range(2, len(names) + 3)))
    return parent / next(name for name in tries if name not in names)


def _distance(document: CalibrationDocument) -> float | None:
    """Return the distance that was given, by however many readings [m]."""
    readings = readings_of(document.settings.get("distance"))
    return agreed_length(readings) if readings else None


def _recorded(file: Path) -> tuple[str, float | None]:
    """Return the driver of a placement's last session, and the distance that was measured [m]."""
    sessions = read_sessions(file)
    driver = str(sessions[-1].get("driver") or "") if sessions else ""
    with suppress(RecordingError):
        keys = read_keys(file)
        return driver, None if keys.distance_assumed else keys.distance
    return driver, None


def solve_command(
    document: CalibrationDocument,
    *,
    moves: Mapping[str, Role | None] | None = None,
    settings_given: Mapping[str, str] | None = None,
) -> str:
    """Return the command that makes the calibration again, by other roles (None: out), settings."""
    roles = {whole_name(name): now for name, now in (moves or {}).items()}
    settings = {**document.settings, **(settings_given or {})}
    arms = () if document.arms is None else document.arms.arms

    def folders(role: Role) -> list[str]:
        rows = [
            (row.folder, roles.get(whole_name(row.name), row.role))
            for row in document.data
        ]
        own = list(dict.fromkeys(folder for folder, now in rows if now == role))
        if not arms:
            return own
        folders_by_arm = {arm.name: getattr(arm, role) for arm in arms} | {
            document.arm_name: own
        }
        return [
            f"{name}:{path}" for name, paths in folders_by_arm.items() for path in paths
        ]

    robots = ["--robot", document.robot]
    if arms:
        settings = {key: value for key, value in settings.items() if key not in _CHAIN}
        robots = _robots(arms)
    words = ["mukca", "solve", *folders("train")]
    held_out = folders("test")
    if held_out:
        words += ["--test", *held_out]
    words += [*robots, *as_options(_unlike_defaults(document.method, settings))]
    if moves or settings_given:
        words += ["--out", "calibrated-again"]
    return shlex.join(words)


def _robots(arms: Sequence[GivenArm]) -> list[str]:
    """Return the options of several robots, and of the links that each names."""
    words: list[str] = []
    for arm in arms:
        words += ["--robot", f"{arm.name}={arm.robot}"]
    for arm in arms:
        for key in _LINKS:
            link = arm.options.get(key)
            if link and (key, link) != ("tip", BALL_LINK):
                words += [f"--{key}", f"{arm.name}={link}"]
    balls = [arm.options["ball"] for arm in arms if arm.options.get("ball")]
    return words + as_options({"ball": next(iter(balls), None)})


def _unlike_defaults(method: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings that differ from the defaults of a method, and the method itself."""
    default = SolveOptions()
    defaults = replace(default, method=cast("Any", method)).validated().as_dict()
    differences = {
        key: value for key, value in settings.items() if value != defaults.get(key)
    }
    return (
        differences if method == default.method else {"method": method, **differences}
    )


def as_options(settings: Mapping[str, Any]) -> list[str]:
    """Return settings as options, those that were given."""
    words: list[str] = []
    for key, value in settings.items():
        if value in (None, [], (), False) or (key, value) == ("tip", BALL_LINK):
            continue
        values = (
            cast("list[Any]", value) if isinstance(value, list | tuple) else [value]
        )
        option = f"--{key.replace('_', '-')}"
        if value is True:
            words.append(option)
        elif key == "distance":  # each reading by itself
            for reading in values:
                words += [option, str(reading)]
        else:
            words += [option, *map(str, values)]
    return words


def _one_robot(document: CalibrationDocument) -> list[str]:
    chain = {key: document.settings.get(key) for key in _CHAIN}
    return ["--robot", document.robot, *as_options(chain)]
