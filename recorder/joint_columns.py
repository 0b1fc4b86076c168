"""Columns that are a model's joints, by their names.

Programs call one joint ``elbow_joint``, ``left_elbow_joint``, ``Elbow Joint [deg]``,
``elbow_joint.pos`` and ``/joint_states/elbow_joint/position``. A name is split into words; a column
is a joint's if it holds the joint's words, and one way of writing holds for all joints.
"""

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from .recording_error import RecordingError
from .sample import Sample
from .words import (
    PENDANTS,
    WORDS,
    Names,
    Words,
    all_match,
    any_match,
    is_word,
    words_of,
)

_POSITION = WORDS["position"]
"""Words that may follow a joint's name where its position is meant."""
_POSITIONS = f"((?: (?:{_POSITION.pattern}))*)"
COMMANDS = WORDS["command"]
"""Words that tell where something was sent, not where it was."""
OTHER = re.compile(f"{WORDS['other'].pattern}|{COMMANDS.pattern}")
"""Words that tell of another quantity of a joint, or of what it was told to do."""


class ColumnError(RecordingError):
    """Columns of which several fit, so that nobody can tell; the message has no file yet."""

    def __init__(self, joint: str, columns: Names) -> None:
        super().__init__(f"{joint!r} may be any of {', '.join(columns)}")
        self.joint, self.columns = joint, columns


@dataclass(frozen=True)
class Match:
    """Positions of the joints among names, in chain order."""

    order: tuple[int, ...]
    note: str = ""
    """Remark for people, where columns are taken in order."""


def match_joints(
    names: Names,
    joints: Names,
    *,
    beside: Names = (),
    in_order: bool = True,
) -> Match | None:
    """Return where a model's joints stand among the names of columns; None where they do not.

    Columns ``beside`` those, behind them, are called like times, and count where joints are, too.
    With ``in_order``, columns that are only numbered, or that are just as many, are taken in order.

    Raises:
        ColumnError: Several columns may be one joint.
    """
    if beside:
        with suppress(ColumnError):
            if match := match_joints([*names, *beside], joints, in_order=False):
                return match
    joints = [joint.strip() for joint in joints]
    if set(joints) <= set(names):
        for joint in joints:
            if names.count(joint) > 1:
                raise ColumnError(joint, [joint] * names.count(joint))
        return Match(tuple(map(names.index, joints)))
    ways = _ways(names, joints)
    order = in_one_way(_without_zero(ways, names, joints), joints, names)
    if order and len(set(order)) == len(order):
        return Match(tuple(order))
    for pendant in PENDANTS:
        order = in_one_way(_ways(names, pendant), pendant, names)
        if order and len(order) == len(joints):
            called = ", ".join(names[i] for i in order)
            return Match(tuple(order), f"{called} are taken as a pendant's names")
    return _numbered(names, joints, some_named=bool(ways)) if in_order else None


def require_samples(labels: Names, joints: Names, file: Path | str) -> None:
    """Refuse a table whose lines are called like a model's joints, and not its columns."""
    if labels and joints and match_joints(labels, joints, in_order=False):
        raise RecordingError(
            f"{file}: its lines are joints ({','.join(labels):.60}); write a line for each sample "
            "and a column for each joint, as by transposing the table"
        )


def missing_joints(names: Names, joints: Names) -> list[str]:
    """Return the joints that no column is called like."""
    named = set(chain.from_iterable(_ways(names, joints).values()))
    return [joint for k, joint in enumerate(joints) if k not in named]


Ways = dict[tuple[Words, Words], dict[int, list[int]]]
"""By way of writing, the words before and after a name: the columns of each of some names."""


def in_one_way(ways: Ways, wanted: Names, columns: Names) -> list[int] | None:
    """Return the column of each of some names, if one way of writing has all; bare names do best.

    A ColumnError names one that several columns may be.
    """
    complete = [way for way, named in ways.items() if len(named) == len(wanted)]
    if ((), ()) in complete:
        complete = [((), ())]
    order: list[int] = []
    for k, name in enumerate(wanted if complete else ()):
        fitting = list(chain.from_iterable(ways[way][k] for way in complete))
        if len(fitting) > 1:
            raise ColumnError(name, [columns[i] for i in fitting])
        order += fitting
    return order or None


def _ways(names: Names, joints: Names) -> Ways:
    """Return the ways in which columns are called like joints."""
    ways: Ways = {}
    cores = [words_of(joint) for joint in joints]
    for i, name in enumerate(names):
        column = words_of(name)
        for k, joint in enumerate(cores):
            way = _way(column, joint)
            if way:
                ways.setdefault(way, {}).setdefault(k, []).append(i)
    return ways


def _without_zero(ways: Ways, names: Names, joints: Names) -> Ways:
    """Return ways without those whose numbers begin at 0 and the joints' at 1, as q0 .. q5."""
    cores = [words_of(joint) for joint in joints]
    numbered = all(len(core) == 1 and core[0].isdecimal() for core in cores)
    if not numbered or ("0",) in cores:
        return ways
    columns = {words_of(name) for name in names}
    return {(a, b): ways[a, b] for a, b in ways if (*a, "0", *b) not in columns}


def _way(column: Words, joint: Words) -> tuple[Words, Words] | None:
    """Return the words before and after a joint's name in a column's; None where it is no name.

    The column may lack what the joint's name begins with, or its last word ``joint``.
    """
    names = [joint] if joint else []
    if joint[-1:] == ("joint",) and any(map(is_word, joint[:-1])):
        names.append(joint[:-1])
    for name in names:
        pattern = rf"((?:\S+ )*){' '.join(name)}{_POSITIONS}"
        match = re.fullmatch(pattern, " ".join(column))
        before = match[1].split() if match else []
        if match and not any_match(OTHER, before):
            return tuple(before), tuple(match[2].split())
    core = column
    while core and _POSITION.fullmatch(core[-1]):
        core = core[:-1]
    size = len(core)
    is_partial = any(map(is_word, core)) and size < len(joint)
    if is_partial and joint[-size:] == core:
        return ("lacks", *joint[:-size]), column[size:]
    return None


def _numbered(names: Names, joints: Names, *, some_named: bool) -> Match | None:
    """Return columns like q1 .. q6, or all of as many as there are joints, in order.

    Where some are called like a joint, the others are not taken in order.
    """
    order = in_one_way(series_of(names), joints, names) or []
    taken = "the columns"
    if order:
        taken = f"{names[order[0]]} to {names[order[-1]]}"
    elif not some_named:
        order = [i for i, n in enumerate(names) if not any_match(OTHER, words_of(n))]
    if len(order) != len(joints):
        return None
    called = f"no column is called like a joint of the robot ({', '.join(joints)})"
    return Match(tuple(order), f"{called}; {taken} are taken in order")


def series_of(names: Names) -> Ways:
    """Return columns like q1, q2, .. or position[0], position[1], .., numbered from the first.

    Of columns with one number, as an angle in radians and again in degrees, the first one counts.
    """
    ways: Ways = {}
    for i, name in enumerate(names):
        words = words_of(name)
        numbers = [k for k, word in enumerate(words) if word.isdecimal()]
        last = max(numbers, default=0)
        before, after = words[:last], words[last + 1 :]
        is_angle = any_match(WORDS["numbered"], before) and all_match(_POSITION, after)
        if is_angle and not any_match(OTHER, words):
            ways.setdefault((before, after), {}).setdefault(int(words[last]), [i])
    series: Ways = {}
    for way, columns in ways.items():
        first = min(columns)
        if first in (0, 1) and max(columns) - first == len(columns) - 1:
            series[way] = {number - first: places for number, places in columns.items()}
    return series


def joint_order(
    columns: Names | None,
    joint_names: Names,
    samples: Sequence[Sample],
    file: Path | str,
    beside: Names = (),
    told: bool = False,
) -> Match | None:
    """Return where a model's joints stand; None where they are in the model's order already.

    Args:
        columns: Names in the files' header; None without one.
        joint_names: The model's joints, in chain order.
        samples: Samples of the placement, one or more.
        file: The first of its files, for messages; its name where it was made in memory.
        beside: Names of further columns, which count or date the rows.
        told: True where a user named the columns, in the model's order or like its joints.

    Raises:
        RecordingError: Another number of joints, a header that names only some of them, or several
            columns that may be one joint.
    """
    m = len(joint_names)
    count = len(samples[0].position)
    hint = ""
    if columns is not None:
        try:
            match = match_joints(columns, joint_names, beside=beside)
        except ColumnError as error:
            raise RecordingError(f"{file}: {error}; keep those of one arm") from None
        if told and count == m and (match is None or match.note):
            return None
        if match:
            return match
        absent = missing_joints(columns, joint_names)
        if len(absent) < m:
            lacking = (
                f"missing: {', '.join(absent)}" if absent else "no arm has all of them"
            )
            raise RecordingError(
                f"{file}: the header names {m - len(absent)} of the robot's {m} joints; {lacking}. "
                "Name all of them, or none (columns then go by order)"
            )
        if count == m:
            raise RecordingError(
                f"{file}: no column holds the positions of the robot's joints "
                f"({', '.join(joint_names)}); the header is {','.join(columns):.150}"
            )
        hint = f"; the header is {','.join(columns):.100}"
    elif count == m:
        return None
    elif count == 2 * m and not np.any(np.array([s.position for s in samples]) % 1):
        # 1,5,2,5 for 1.5 and 2.5: nobody could tell, but for the count.
        hint = "; these look like decimal commas: separate by semicolons"
    elif sum(sample.socket == samples[0].socket for sample in samples) == m:
        hint = "; a line is a sample: are these lines joints?"
    raise RecordingError(
        f"{samples[0].where or file}: {count} joint positions, but the robot's "
        f"chain has {m} actuated joints ({', '.join(joint_names)}){hint}"
    )
