"""The kinds of logs that can be read, told by what they look like."""

import importlib
from collections.abc import Callable

from .log import ExtractError, Log, Question


def read_log(question: Question) -> Log:
    """Return the joint states of a log of any kind.

    Raises:
        ExtractError: There is nothing there, or nothing that can be read; see also the modules.
        RecordingError: A file is damaged.
    """
    name = _kind(question)
    read: Callable[[Question], Log] = importlib.import_module(f".{name}", __package__).read
    if question.topic is not None and name != "bags":
        raise ExtractError("--topic is for bags")
    if question.units is not None and name not in ("lerobot", "csv_log"):
        raise ExtractError("--units is for lerobot data sets and CSV logs")
    log = read(question)
    if not len(log.stamps):
        raise ExtractError(f"{question.path}: no state in it can be used")
    return log


def _kind(question: Question) -> str:
    """Return the module that reads a path."""
    path = question.path
    if not path.exists():
        raise ExtractError(f"{path}: no such file or folder")
    if path.is_dir() and (path / "meta" / "info.json").exists():
        return "lerobot"
    if path.suffix in (".csv", ".tsv", ".txt"):
        return "csv_log"
    if path.suffix == ".stream" or (path.is_dir() and any(path.glob("*.stream"))):
        return "kept_stream"
    if path.suffix in (".bag", ".db3", ".mcap") or (path / "metadata.yaml").exists():
        return "bags"
    raise ExtractError(
        f"{path}: nothing that can be read: give a ROS bag (.bag, .db3, .mcap, or a folder with "
        "metadata.yaml), a lerobot data set, a CSV log, or a recording with a kept stream"
    )
