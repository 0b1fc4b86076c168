"""Order of a model's joints among the columns of a placement's files."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .joint_columns import ColumnError, Match, match_joints, missing_joints
from .recording_error import RecordingError
from .sample import Sample


def joint_order(
    columns: Sequence[str] | None,
    joint_names: Sequence[str],
    samples: Sequence[Sample],
    file: Path | str,
    placement: str,
    beside: Sequence[str] = (),
) -> Match | None:
    """Return where a model's joints stand; None where they are in the model's order already.

    Args:
        columns: Names in the files' header; None without one.
        joint_names: The model's joints, in chain order.
        samples: Samples of the placement, one or more.
        file: The first of its files, for messages.
        placement: Its name, for messages where it was made in memory.
        beside: Names of further columns, which count or date the rows.

    Raises:
        RecordingError: Another number of joints, a header that names only some of them, or several
            columns that may be one joint.
    """
    try:
        match = None
        if columns is not None:
            match = match_joints(columns, joint_names, beside=beside)
    except ColumnError as error:
        raise RecordingError(f"{file}: {error}; keep those of one arm") from None
    if match is not None:
        return match
    m = len(joint_names)
    count = len(samples[0].position)
    hint = ""
    if columns is not None:
        _require_no_joint(columns, joint_names, file)
        if count == m:
            raise RecordingError(
                f"{file}: no column holds the positions of the robot's joints "
                f"({', '.join(joint_names)}); the header is {','.join(columns):.150}"
            )
        hint = f"; the header is {','.join(columns):.100}"
    elif count == 2 * m and _are_whole(samples):
        # 1,5,2,5 for 1.5 and 2.5: nobody could tell, but for the count.
        hint = "; these look like decimal commas: separate by semicolons"
    elif sum(sample.socket == samples[0].socket for sample in samples) == m:
        hint = "; a line is a sample: are these lines joints?"
    if count != m:
        raise RecordingError(
            f"{samples[0].where or placement}: {count} joint positions, but the robot's "
            f"chain has {m} actuated joints ({', '.join(joint_names)}){hint}"
        )
    return None


def _require_no_joint(
    columns: Sequence[str], joint_names: Sequence[str], file: Path | str
) -> None:
    """Refuse a header that names some of the joints.

    Raises:
        RecordingError: It does; the message says which are missing.
    """
    absent = missing_joints(columns, joint_names)
    m = len(joint_names)
    if len(absent) == m:
        return
    lacking = f"missing: {', '.join(absent)}" if absent else "no arm has all of them"
    raise RecordingError(
        f"{file}: the header names {m - len(absent)} of the robot's {m} joints; {lacking}. "
        "Name all of them, or none (columns then go by order)"
    )


def _are_whole(samples: Sequence[Sample]) -> bool:
    """Return whether all positions are whole numbers."""
    positions = np.array([sample.position for sample in samples])
    return not np.any(positions % 1)
