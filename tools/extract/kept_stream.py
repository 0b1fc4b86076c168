"""The raw stream that ``mukca record --keep-stream`` left beside its samples."""

import numpy as np

from ...recorder import read_stream_log
from .log import Log, Question, columns_of, merged, unknown_joints


def read(question: Question) -> Log:
    """Return the states of a file, or of all files in a placement's folder, one part each."""
    path = question.path
    files = sorted(path.glob("*.stream"), key=lambda f: (len(f.name), f.name))
    logs: list[Log] = []
    for file in files if path.is_dir() else [path]:
        kept = read_stream_log(file)
        columns = columns_of(kept.joints, question)
        if columns is None:
            raise unknown_joints(kept.joints, question)
        efforts = None if kept.efforts is None else kept.efforts[:, columns]
        if len(kept.stamps):
            note = f"read {file.name}, {len(kept.stamps)} states"
            parts = kept.connections - kept.connections.min()
            logs.append(
                Log(kept.stamps, kept.positions[:, columns], efforts, parts, (note, *kept.remarks))
            )
    if not logs:
        empty = np.empty(0)
        return Log(empty, np.empty((0, len(question.joints))), None, empty.astype(int))
    return merged(logs)
