"""Command lines that make a calibration again, or record for it, and notes of its recordings."""

import shlex
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any, cast

from ....recorder import (
    METADATA,
    RecordingError,
    placements_in,
    read_keys,
    read_sessions,
)
from ....solver.calibration import SolveOptions
from ....solver.identification.data import agreed_length, readings_of
from ....solver.identification.robot import BALL_LINK
from ....solver.results import CalibrationDocument, GivenArm, Role
from ...recording import driver_elsewhere

_LINKS = ("base", "tip", "flange")
"""Settings that name the links of a robot."""
_CHAIN = (*_LINKS, "ball")


def record_command(document: CalibrationDocument) -> str:
    """Return the command that records another placement, as the last one was recorded.

    It names no driver where that is a simulated arm with no base left.
    """
    driver, distance = _recorded(Path(document.data[-1].folder) / METADATA)
    readings = readings_of(document.settings.get("distance"))
    options = {
        "driver": driver_elsewhere(driver) or "NAME:ADDRESS",
        "distance": agreed_length(readings) if readings else distance,
        "robot_name": document.arm_name if document.arms else None,
        "out": _folder_beside(document),
    }
    return shlex.join(["mukca", "record", *one_robot(document), *as_options(options)])


def _folder_beside(document: CalibrationDocument) -> Path:
    """Return a folder for another placement, beside the recordings and of another name."""
    folders = [Path(row.folder) for row in document.data if row.files]
    first, *_ = folders or [Path("recordings", "first")]
    # The parent of "." is "." itself.
    parent = first.parent if first.name else Path("..")
    names = {folder.resolve().name for folder in folders}
    tries = ("another", *(f"another-{number}" for number in range(2, len(names) + 3)))
    return parent / next(name for name in tries if name not in names)


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
    settings_given: Mapping[str, object] | None = None,
    added: Mapping[str, Role] | None = None,
) -> str:
    """Return the command that makes the calibration again, changed.

    Args:
        document: The calibration.
        moves: Other roles of its placements by name; None leaves one out.
        settings_given: Settings that replace its own.
        added: Roles of folders that it did not use.
    """
    roles = moves or {}
    settings = {**document.settings, **(settings_given or {})}
    arms = document.arms.arms if document.arms else ()

    def folders(role: Role) -> list[str]:
        rows = [(row.folder, roles.get(row.name, row.role)) for row in document.data]
        rows += (added or {}).items()
        of_robot = list(dict.fromkeys(folder for folder, now in rows if now == role))
        if not arms:
            return _shortest(of_robot)
        words: list[str] = []
        for arm in arms:
            paths = of_robot if arm.name == document.arm_name else getattr(arm, role)
            words += [f"{arm.name}:{path}" for path in paths]
        return words

    robots = ["--robot", document.robot]
    if arms:
        settings = {key: value for key, value in settings.items() if key not in _CHAIN}
        robots = _robots(arms)
    words = ["mukca", "solve", *folders("train")]
    held_out = folders("test")
    if held_out:
        words += ["--test", *held_out]
    words += [*robots, *as_options(_unlike_defaults(document.method, settings))]
    if moves or settings_given or added:
        words += ["--out", "calibrated-again"]
    return shlex.join(words)


def _shortest(folders: Sequence[str]) -> list[str]:
    """Return the folder that holds these placements and no other; else these."""
    (parent, *parents) = {Path(folder).parent for folder in folders} or {Path()}
    with suppress(OSError):
        all_there = len(folders) > 1 and not parents
        if all_there and set(placements_in(parent)) == set(map(Path, folders)):
            return [str(parent)]
    return list(folders)


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
        if place := arm.options.get("ball"):
            x, *others = map(str, place)
            words += ["--ball", f"{arm.name}={x}", *others]
    return words


def _unlike_defaults(method: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings that differ from the defaults of a method, and the method itself."""
    default = SolveOptions()
    defaults = replace(default, method=cast("Any", method)).validated().as_dict()
    named = {} if method == default.method else {"method": method}
    return named | {k: v for k, v in settings.items() if v != defaults.get(k)}


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


def one_robot(document: CalibrationDocument) -> list[str]:
    """Return the options of a single robot, and of the links of its chain."""
    links = {key: document.settings.get(key) for key in _CHAIN}
    return ["--robot", document.robot, *as_options(links)]


NOTED = {
    "serial_number": "Serial number",
    "operator": "Operator",
    "temperature": "Temperature",
}
"""Titles of the notes by their keys in ``placement.json``."""


def session_notes(files: Iterable[str]) -> Mapping[str, str]:
    """Return notes by their titles, from where the recordings of some files still lie."""
    folders = dict.fromkeys(Path(file).parent / METADATA for file in files)
    sessions = list(chain.from_iterable(map(read_sessions, folders)))
    notes: dict[str, str] = {}
    for key, title in NOTED.items():
        values = dict.fromkeys(str(row[key]) for row in sessions if key in row)
        if values:
            notes[title] = ", ".join(values)
    return notes
