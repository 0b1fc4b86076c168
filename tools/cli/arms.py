"""Arms of a command line: their placements, and a verb for each of them in turn."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, replace
from functools import wraps
from pathlib import Path
from typing import Any, NamedTuple

from ... import recorder
from ...errors import MukcaError
from ...solver import assessment, calibration, tables
from ...solver.calibration import SolveOptions, UsageError
from ...solver.identification import data
from .console import Terminal

OUTPUTS = ("out", "certificate")
"""Options that name what is written; of several robots each has its own."""


class ArmError(MukcaError):
    """A verb refuses one of several arms; the line names that arm first."""


def one_arm(file: Path) -> Path:
    """Return the ``calibration.json`` of a single robot; several are a UsageError."""
    files = calibration.calibration_files(file)
    if "" not in files:
        folders = ", ".join(str(path.parent) for path in files.values())
        raise UsageError(f"{file}: holds several robots; name one of {folders}")
    return files[""]


def warn_of_use(calibrated: "calibration.Calibration", terminal: Terminal) -> None:
    """Warn of a calibration whose verdict is not to load it."""
    with suppress(MukcaError):  # not every file can be judged
        verdict = calibrated.verdict
        if not verdict.use:
            terminal.warn(f"{calibrated.source}: {verdict.title}: do not use it yet")


def for_each_arm(run: Callable[[Any, Terminal], int]) -> Callable[[Any, Terminal], int]:
    """Verb that runs for each robot of a calibration, and returns the worst exit status.

    Each has placements of its own, ``NAME:PATH``, and writes what is named after it. An ArmError
    names the robot that is refused.
    """

    @wraps(run)
    def run_all(options: Any, terminal: Terminal) -> int:
        files = calibration.calibration_files(options.calibration)
        if "" in files:
            return run(replace(options, calibration=files[""]), terminal)
        has_data = hasattr(options, "data")
        recordings = paths_by_robot(options.data, files) if has_data else {}
        results = dict[str, Any]()
        statuses = list[int]()
        for name, file in files.items():
            settings = {"calibration": file, **_outputs_of_arm(options, name)}
            if has_data:
                settings["data"] = recordings[name]
            if not has_data or recordings[name]:
                kept = list[Any]()
                of_arm = replace(terminal, heading=f"Robot {name}", kept=kept)
                statuses.append(
                    _run_arm(run, name, replace(options, **settings), of_arm)
                )
                results[name] = kept[-1] if kept else None
        terminal.emit({"robots": results})
        return assessment.worst(statuses)

    return run_all


def _run_arm(
    run: Callable[[Any, Terminal], int], name: str, options: Any, terminal: Terminal
) -> int:
    try:
        return run(options, terminal)
    except MukcaError as error:
        refusal = ArmError(f"{name}: {error}")
        refusal.failed = error.failed
        raise refusal from None


def _outputs_of_arm(options: Any, name: str) -> dict[str, Any]:
    """Return folders and files to write, named after an arm.

    A dot begins the ending of a file, unless a digit follows, as in ``results-1.0``.
    """
    outputs: dict[str, Any] = {}
    for entry in fields(options):
        path = getattr(options, entry.name)
        if entry.name not in OUTPUTS or path is None:
            continue
        if path.suffix[1:2].isalpha() and entry.metadata["metavar"] != "DIR":
            outputs[entry.name] = path.with_name(f"{path.stem}_{name}{path.suffix}")
        else:
            outputs[entry.name] = path / name
    return outputs


class _Placement(NamedTuple):
    """A placement that a path stands for."""

    path: Path
    folder: Path
    """The same without links."""
    is_named: bool
    """True where the path is its own, and not that of a folder of placements."""


def _placements(paths: Sequence[Path]) -> list[_Placement]:
    """Return the placements that paths stand for."""
    placements: list[_Placement] = []
    for path in paths:
        for folder in recorder.find_placements([path]):
            placements.append(_Placement(folder, folder.resolve(), folder == path))
    return placements


def split_by_robot(
    train: Sequence[Path], test: Sequence[Path], sources: Mapping[str, object]
) -> tuple[dict[str, list[Path]], dict[str, list[Path]], list[str]]:
    """Return placements to train on and to test on by robot, and a line for each left out.

    A path is ``NAME:PATH`` where there are several robots, or the recording names the robot; one of
    no robot, or named both to train on and for the test, is a UsageError. A placement that is named
    counts before one that a folder stands for.
    """
    training = paths_by_robot(train, sources)
    test_folders = paths_by_robot(test, sources)
    tested: dict[str, list[Path]] = {name: [] for name in sources}
    held_out: list[str] = []
    trained: list[str] = []
    unread: list[str] = []
    for name, paths in test_folders.items():
        unread += recorder.unread(paths)
        tests = _placements(paths)
        named = {test.folder for test in tests if test.is_named}
        placements = _placements(training[name])
        remaining = [p for p in placements if p.is_named or p.folder not in named]
        if placements and not remaining:
            raise UsageError(f"{paths[0]}: held out, so nothing is left to train on")
        if len(remaining) < len(placements):
            unread += recorder.unread(training[name])
            training[name] = [placement.path for placement in remaining]
            held_out += [p.path.name for p in placements if p not in remaining]
        folders_trained = {placement.folder for placement in remaining}
        for path, folder, is_named in tests:
            if folder not in folders_trained:
                tested[name].append(path)
            elif is_named:
                raise UsageError(
                    f"{path}: trained on, so it cannot be held out as well"
                )
            else:
                trained.append(path.name)
    lines = {
        "only tested on": held_out,
        "only trained on": trained,
    }
    remarks = [f"{', '.join(names)}: {why}" for why, names in lines.items() if names]
    return training, tested, [*remarks, *dict.fromkeys(unread)]


def paths_by_robot(
    paths: Sequence[Path], sources: Mapping[str, object]
) -> dict[str, list[Path]]:
    """Return placements by robot, as :func:`split_by_robot` reads them."""
    if "" in sources:
        return {"": list(paths)}
    by_robot: dict[str, list[Path]] = {name: [] for name in sources}
    for path in paths:
        name, _, path_after_name = str(path).partition(":")
        if path_after_name and name in sources:
            by_robot[name].append(Path(path_after_name))
            continue
        if path_after_name and not path.exists() and Path(path_after_name).exists():
            raise UsageError(
                f"{path}: no robot is called {name!r}; there are: {', '.join(sources)}"
            )
        for folder in recorder.find_placements([path]):
            metadata = recorder.read_metadata(folder / recorder.METADATA)
            owner = str(metadata.get("robot_name") or "")
            if owner not in sources:
                first, *_ = sources
                problem = f"of robot {owner!r}" if owner else "which robot recorded it?"
                raise UsageError(
                    f"{folder}: {problem}; write {first}:{folder}; the robots are "
                    f"{', '.join(sources)}"
                )
            by_robot[owner].append(folder)
    return by_robot


def read_data(
    paths: Sequence[Path],
    settings: SolveOptions,
    table: Mapping[str, Any] | None = None,
) -> "list[recorder.Placement]":
    """Read all placements that paths stand for, without what is left out by hand."""
    placements = recorder.read_placements(
        *paths, as_recorded=settings.as_recorded, **(table or {})
    )
    tables.check_left_out(placements, settings.leave_out)
    placements = tables.without(placements, settings.leave_out)
    settings.payloads.check(placements)
    if not placements:
        raise UsageError("--leave-out: no placement is left")
    return data.as_flange_poses(placements) if settings.flange_poses else placements
