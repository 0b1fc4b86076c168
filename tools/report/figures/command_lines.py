"""Command lines that make a calibration again, and that record another placement for it."""

import shlex
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
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

_LINKS = ("base", "tip", "flange")
"""Settings that name the links of a robot."""
_CHAIN = (*_LINKS, "ball")


def record_command(document: CalibrationDocument) -> str:
    """Return the command that records another placement, as the last one was recorded."""
    driver, distance = _recorded(Path(document.data[0].folder) / METADATA)
    words = [
        "mukca",
        "record",
        *one_robot(document),
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
    arms = () if document.arms is None else document.arms.arms

    def folders(role: Role) -> list[str]:
        rows = [(row.folder, roles.get(row.name, row.role)) for row in document.data]
        rows += (added or {}).items()
        own = list(dict.fromkeys(folder for folder, now in rows if now == role))
        if not arms:
            return _shortest(own)
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


def one_robot(document: CalibrationDocument) -> list[str]:
    """Return the options of a single robot, and of the links of its chain."""
    chain = {key: document.settings.get(key) for key in _CHAIN}
    return ["--robot", document.robot, *as_options(chain)]
