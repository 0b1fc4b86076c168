"""The raw stream that ``mukca record --keep-stream`` left beside its samples."""

import numpy as np

from ...recorder import read_stream_log
from .log import Log, Question, needed_columns


def read(question: Question) -> Log:
    """Return the states of a file, or of all files in a placement's folder, one part each."""
    path, m = question.path, len(question.joints)
    files = sorted(path.glob("*.stream"), key=lambda f: (len(f.name), f.name))
    stamps, positions, efforts = [np.empty(0)], [np.empty((0, m))], [np.empty((0, m))]
    parts, notes = [np.empty(0, dtype=int)], list[str]()
    for file in files if path.is_dir() else [path]:
        kept = read_stream_log(file)
        columns = needed_columns(kept.joints, question)
        if not len(kept.stamps):
            continue
        notes += [f"read {file.name}, {len(kept.stamps)} states", *kept.remarks]
        stamps.append(kept.stamps)
        positions.append(kept.positions[:, columns])
        if kept.efforts is not None:
            efforts.append(kept.efforts[:, columns])
        first = parts[-1].max(initial=-1) + 1
        parts.append(kept.connections - kept.connections.min() + first)
    measured = len(efforts) == len(positions)
    return Log(
        np.concatenate(stamps),
        np.concatenate(positions),
        np.concatenate(efforts) if measured else None,
        np.concatenate(parts),
        tuple(notes),
    )
