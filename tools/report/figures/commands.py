"""Commands for the user to copy: each runs as it is printed."""

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from ....recorder import METADATA, RecordingError, read_keys, read_metadata
from ....solver.results import ArmsDocument, CalibrationDocument, Role
from ....solver.robot import BALL_LINK

_CHAIN = ("base", "tip", "flange", "ball")
"""Settings that name the links of a robot."""


def check_command(document: CalibrationDocument) -> str:
    """Return the command that looks at the recordings."""
    folders = [row.folder for row in document.data]
    same = {key: document.settings.get(key) for key in ("distance", "zeros")}
    return shlex.join(["mukca", "check", *folders, *_one_robot(document), *as_options(same)])


def record_command(document: CalibrationDocument) -> str:
    """Return the command that records another placement, as the last one was recorded."""
    driver, distance = _recorded(Path(document.data[0].folder) / METADATA)
    words = ["mukca", "record", *_one_robot(document), "--driver", driver or "NAME:ADDRESS"]
    words += as_options({"distance": document.settings.get("distance") or distance})
    if document.arms is None:
        return shlex.join([*words, "--out", "recordings/another"])
    beside = Path(document.data[0].folder).parent / "another"
    return shlex.join([*words, "--robot-name", document.arm_name, "--out", str(beside)])


def _recorded(file: Path) -> tuple[str, float | None]:
    """Return the driver of a placement's last session, and the distance that was measured [m]."""
    try:
        sessions: Any = read_metadata(file).get("sessions")
        keys = read_keys(file)
    except RecordingError:
        return "", None
    rows = cast("list[Any]", sessions) if isinstance(sessions, list) else []
    last = cast("dict[str, Any]", rows[-1]) if rows and isinstance(rows[-1], dict) else {}
    return str(last.get("driver") or ""), None if keys.distance_assumed else keys.distance


def solve_command(
    document: CalibrationDocument,
    *,
    moved: Mapping[str, Role | None] | None = None,
    given: dict[str, str] | None = None,
) -> str:
    """Return the command that makes the calibration again, by other roles (None: out), settings."""
    folders: dict[Role, list[str]] = {"train": [], "test": []}
    for row in document.data:
        role = row.role if moved is None or row.name not in moved else moved[row.name]
        if role is not None:
            folders[role].append(row.folder)
    settings = {**document.settings, **(given or {})}
    robots = ["--robot", document.robot]
    if document.arms is not None:
        folders = _of_all(document.arms, document.arm_name, folders)
        robots = _all_robots(document.arms)
        settings = {key: value for key, value in settings.items() if key not in _CHAIN}
    words = ["mukca", "solve", *folders["train"]]
    if folders["test"]:
        words += ["--test", *folders["test"]]
    words += [*robots, "--method", document.method, *as_options(settings)]
    if moved or given:
        words += ["--out", "calibrated-again"]
    return shlex.join(words)


def as_options(settings: Mapping[str, Any]) -> list[str]:
    """Return settings as options, those that were given."""
    words: list[str] = []
    for key, value in settings.items():
        if value not in (None, [], (), False) and (key, value) != ("tip", BALL_LINK):
            values = cast("list[Any]", value) if isinstance(value, list | tuple) else [value]
            words += [f"--{key.replace('_', '-')}", *([] if value is True else map(str, values))]
    return words


def _one_robot(document: CalibrationDocument) -> list[str]:
    chain = {key: document.settings.get(key) for key in _CHAIN}
    return ["--robot", document.robot, *as_options(chain)]


def _of_all(
    arms: ArmsDocument, own: str, folders: Mapping[Role, list[str]]
) -> dict[Role, list[str]]:
    """Return whose each folder is, ``NAME:PATH``, those of one robot as they are to be now."""
    roles: tuple[Role, Role] = ("train", "test")
    return {
        role: [
            f"{arm.name}:{folder}"
            for arm in arms.arms
            for folder in (folders[role] if arm.name == own else getattr(arm, role))
        ]
        for role in roles
    }


def _all_robots(arms: ArmsDocument) -> list[str]:
    words: list[str] = []
    for arm in arms.arms:
        words += ["--robot", f"{arm.name}={arm.robot}"]
    for arm in arms.arms:
        links = {key: arm.options.get(key) for key in _CHAIN[:-1]}
        words += as_options({key: f"{arm.name}={link}" for key, link in links.items() if link})
    balls = [ball for arm in arms.arms if (ball := arm.options.get("ball"))]
    return [*words, *as_options({"ball": balls[0] if balls else None})]
