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

from .columns import Words, all_match, is_word, words_of
from .recording_error import RecordingError

_POSITION = re.compile(
    "pos|positions?|angles?|q|values?|act|actual|measured|meas|msr|state|present|reading|encoder|"
    "joint|data|feedback|fbk|ist"
)
"""Words that may follow a joint's name where its position is meant."""
_POSITIONS = f"((?: (?:{_POSITION.pattern}))*)"
COMMANDS = re.compile(
    "target|commands?|commanded|cmd|desired|des|goal|setpoint|planned|plan|nominal|soll|reference|ref"
)
"""Words that tell where something was sent, not where it was."""
_OTHER = re.compile(
    "velocity|velocities|vel|speed|qd|dq|efforts?|torques?|tau|moment|currents?|acceleration|acc|qdd|"
    "ddq|temperature|temp|voltage|force|pwm|spread|std|error|" + COMMANDS.pattern
)
"""Words that tell of another quantity of a joint, or of what it was told to do."""
_STEM = re.compile(
    "q|j|jt|a|joints?|axis|axes|achsen?|gelenk|pos|positions?|angles?|theta|th|θ"
)
"""Words before the number of a joint, where the number alone tells which."""


_PENDANTS = (
    ("base", "shoulder", "elbow", "wrist 1", "wrist 2", "wrist 3"),
    ("s", "l", "u", "r", "b", "t"),
    ("s", "l", "e", "u", "r", "b", "t"),
)
"""Joints as pendants call them, base to tip: Universal Robots', and Yaskawa's."""


class ColumnError(RecordingError):
    """Columns of which several fit, so that nobody can tell; the message has no file yet."""

    def __init__(self, joint: str, columns: Sequence[str]) -> None:
        super().__init__(f"{joint!r} may be any of {', '.join(columns)}")
        self.joint, self.columns = joint, columns


@dataclass(frozen=True)
class Match:
    """Positions of the joints among names, in chain order."""

    order: tuple[int, ...]
    note: str = ""
    """Remark for people, where columns are taken in order."""


def match_joints(
    names: Sequence[str],
    joints: Sequence[str],
    *,
    beside: Sequence[str] = (),
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
            match = match_joints([*names, *beside], joints, in_order=False)
            if match is not None:
                return match
    joints = [joint.strip() for joint in joints]
    if set(joints) <= set(names):
        for joint in joints:
            if names.count(joint) > 1:
                raise ColumnError(joint, [joint] * names.count(joint))
        return Match(tuple(map(names.index, joints)))
    ways = _ways(names, joints)
    order = in_one_way(_without_zero(ways, names, joints), joints, names)
    if order is not None and len(set(order)) == len(order):
        return Match(tuple(order))
    for pendant in _PENDANTS:
        order = in_one_way(_ways(names, pendant), pendant, names)
        if order is not None and len(order) == len(joints):
            called = ", ".join(names[i] for i in order)
            return Match(tuple(order), f"{called} are taken as a pendant's names")
    return _numbered(names, joints, some_named=bool(ways)) if in_order else None


def require_samples(
    labels: Sequence[str], joints: Sequence[str], file: Path | str
) -> None:
    """Refuse a table whose lines are called like a model's joints, and not its columns."""
    if labels and joints and match_joints(labels, joints, in_order=False):
        raise RecordingError(
            f"{file}: its lines are joints ({','.join(labels):.60}); write a line for each sample "
            "and a column for each joint, as by transposing the table"
        )


def missing_joints(names: Sequence[str], joints: Sequence[str]) -> list[str]:
    """Return the joints that no column is called like."""
    named = set(chain.from_iterable(_ways(names, joints).values()))
    return [joint for k, joint in enumerate(joints) if k not in named]


Ways = dict[tuple[Words, Words], dict[int, list[int]]]
"""By way of writing, the words before and after a name: the columns of each of some names."""


def in_one_way(
    ways: Ways, wanted: Sequence[str], columns: Sequence[str]
) -> list[int] | None:
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


def _ways(names: Sequence[str], joints: Sequence[str]) -> Ways:
    """Return the ways in which columns are called like joints."""
    ways: Ways = {}
    cores = [words_of(joint) for joint in joints]
    for i, name in enumerate(names):
        column = words_of(name)
        for k, joint in enumerate(cores):
            way = _way(column, joint)
            if way is not None:
                ways.setdefault(way, {}).setdefault(k, []).append(i)
    return ways


def _without_zero(ways: Ways, names: Sequence[str], joints: Sequence[str]) -> Ways:
    """Return ways without those whose numbers begin at 0 and the joints' at 1, as q0 .. q5."""
    cores = [words_of(joint) for joint in joints]
    numbered = all(len(core) == 1 and core[0].isdecimal() for core in cores)
    if not numbered or ("0",) in cores:
        return ways
    columns = {words_of(name) for name in names}
    remaining = [(a, b) for a, b in ways if (*a, "0", *b) not in columns]
    return {way: ways[way] for way in remaining}


def _way(column: Words, joint: Words) -> tuple[Words, Words] | None:
    """Return the words before and after a joint's name in a column's; None where it is no name.

    The column may lack what the joint's name begins with, or its last word ``joint``.
    """
    without_last = joint[:-1]
    names = [joint] if joint else []
    if joint[-1:] == ("joint",) and any(map(is_word, without_last)):
        names.append(without_last)
    text = " ".join(column)
    for name in names:
        match = re.fullmatch(rf"((?:\S+ )*){' '.join(name)}{_POSITIONS}", text)
        before = match[1].split() if match else []
        if match and not _any(_OTHER, before):
            return tuple(before), tuple(match[2].split())
    core = column
    while core and _POSITION.fullmatch(core[-1]):
        core = core[:-1]
    size = len(core)
    is_partial = any(map(is_word, core)) and size < len(joint)
    if is_partial and joint[-size:] == core:
        return ("lacks", *joint[:-size]), column[size:]
    return None


def _numbered(
    names: Sequence[str], joints: Sequence[str], *, some_named: bool
) -> Match | None:
    """Return columns like q1 .. q6, or all of as many as there are joints, in order.

    Where some are called like a joint, the others are not taken in order.
    """
    order = in_one_way(_series(names), joints, names)
    taken = "the columns"
    if order is not None:
        taken = f"{names[order[0]]} to {names[order[-1]]}"
    elif not some_named:
        order = [i for i, name in enumerate(names) if not _any(_OTHER, words_of(name))]
    if order is None or len(order) != len(joints):
        return None
    called = f"no column is called like a joint of the robot ({', '.join(joints)})"
    return Match(tuple(order), f"{called}; {taken} are taken in order")


def _series(names: Sequence[str]) -> Ways:
    """Return columns like q1, q2, .. or position[0], position[1], .., numbered from the first.

    Of columns with one number, as an angle in radians and again in degrees, the first one counts.
    """
    ways: Ways = {}
    for i, name in enumerate(names):
        words = words_of(name)
        numbers = [k for k, word in enumerate(words) if word.isdecimal()]
        last = numbers[-1] if numbers else 0
        before = words[:last]
        after = words[last + 1 :]
        if (
            _any(_STEM, before)
            and not _any(_OTHER, words)
            and all_match(_POSITION, after)
        ):
            way = ways.setdefault((before, after), {})
            way.setdefault(int(words[last]), [i])
    series: Ways = {}
    for way, columns in ways.items():
        first = min(columns)
        if first in (0, 1) and max(columns) - first == len(columns) - 1:
            series[way] = {number - first: places for number, places in columns.items()}
    return series


def _any(kind: re.Pattern[str], words: Sequence[str]) -> bool:
    return any(map(kind.fullmatch, words))
