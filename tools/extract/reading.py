"""A log of any kind, read by its kind; a kept stream is read here."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ...recorder import read_stream_log
from .bags import read_bag, read_lerobot_log
from .csv_log import read_csv_log
from .log import ExtractError, Log, Question, needed_columns


def read_log(question: Question) -> Log:
    """Return the joint states of a log of any kind.

    Raises:
        ExtractError: There is nothing there, or nothing that can be read; see also the modules.
        RecordingError: A file is damaged.
    """
    read = _reader(question.path)
    if question.topic is not None and read is not read_bag:
        raise ExtractError("--topic is for bags")
    if question.units is not None and read is read_kept_stream:
        raise ExtractError("--units is for lerobot data sets, CSV logs and bags")
    log = read(question)
    if not len(log.stamps):
        raise ExtractError(f"{question.path}: no state in it can be used")
    return log


def _reader(path: Path) -> Callable[[Question], Log]:
    """Return what reads a log of a path's kind."""
    if not path.exists():
        raise ExtractError(f"{path}: no such file or folder")
    if path.is_dir() and (path / "meta" / "info.json").exists():
        return read_lerobot_log
    if path.suffix in (".csv", ".tsv", ".txt"):
        return read_csv_log
    streams = path.glob("*.stream") if path.is_dir() else ()
    if path.suffix == ".stream" or any(streams):
        return read_kept_stream
    if path.suffix in (".bag", ".db3", ".mcap") or (path / "metadata.yaml").exists():
        return read_bag
    raise ExtractError(
        f"{path}: nothing that can be read. Give a ROS bag (.bag, .db3, .mcap, or a folder with "
        "metadata.yaml), a lerobot data set, a CSV log, or a recording with a kept stream"
    )


def read_kept_stream(question: Question) -> Log:
    """Return the states of a kept stream, or of all in a placement's folder, one part each."""
    path = question.path
    files = [path]
    if path.is_dir():
        files = sorted(path.glob("*.stream"), key=lambda f: (len(f.name), f.name))
    nothing = np.empty((0, len(question.joints)))
    rows = [(np.empty(0), nothing, nothing, np.empty(0, dtype=int))]
    notes = list[str]()
    last = 0
    measured = True
    for file in files:
        stream = read_stream_log(file)
        columns = needed_columns(stream.joints, question)
        if not len(stream.stamps):
            continue
        notes += [f"read {file.name}, {len(stream.stamps)} states", *stream.remarks]
        efforts = stream.efforts
        if efforts is None:
            measured = False
            efforts = np.zeros_like(stream.positions)
        parts = stream.connections - stream.connections.min() + last
        last = int(parts.max()) + 1
        q, torques = stream.positions[:, columns], efforts[:, columns]
        rows.append((stream.stamps, q, torques, parts))
    fields = zip(*rows, strict=True)
    stamps, positions, torques, numbers = map(np.concatenate, fields)
    return Log(stamps, positions, torques if measured else None, numbers, tuple(notes))
