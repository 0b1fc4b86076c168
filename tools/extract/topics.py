"""Topics of a bag: their messages as numbers, and the one of several that says what was measured.

A message takes kilobytes of memory, a number 8 bytes.
"""

import re
from array import array
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from ...recorder import COMMANDS, words_of
from .log import ExtractError, Question

_LEADING = 3
"""Numbers of a message before its positions."""


@dataclass(frozen=True)
class JointStates:
    """The states of one topic, which have all the joints, as they came."""

    stamps: np.ndarray
    """Shape (N,) [s]."""
    positions: np.ndarray
    """In the order of the joints, shape (N, m) [rad], [m] for a prismatic joint."""
    efforts: np.ndarray
    """Shape (N, m) [N m], NaN where a message lacks them; (N, 0) if they were not asked for."""
    remarks: tuple[str, ...]
    """On stamps, and on messages that are no state, for people."""


class JointMessages:
    """The numbers of one topic's messages, apart for each list of joint names in them."""

    def __init__(self, *, efforts: bool) -> None:
        self._efforts = efforts
        self._count = 0
        self._rows: defaultdict[tuple[str, ...], array[float]]
        """By the names: a message's number, stamp, time [s], positions, efforts if asked for."""
        self._rows = defaultdict(lambda: array("d"))
        self._unsound = Counter[tuple[str, ...]]()

    @property
    def names(self) -> list[str]:
        """The names of all joints, each once."""
        return list(dict.fromkeys(chain.from_iterable(self._rows)))

    def add(self, message: Any, time: int) -> None:
        """Take a message that was logged at a time [ns], which is for one without a stamp.

        Efforts that a message lacks are NaN.
        """
        names = tuple(message.name)
        rows = self._rows[names]
        position = np.asarray(message.position, dtype=float)
        if len(position) != len(names) or not np.isfinite(position).all():
            self._unsound[names] += 1
            return
        stamp = message.header.stamp
        nanoseconds = stamp.sec * 1_000_000_000 + stamp.nanosec
        rows.extend((self._count, nanoseconds / 1e9, time / 1e9))
        rows.frombytes(position.tobytes())
        if self._efforts:
            effort = np.asarray(message.effort, dtype=float)
            if len(effort) != len(names):
                effort = np.full(len(names), np.nan)
            rows.frombytes(effort.tobytes())
        self._count += 1

    def states(self, joints: Sequence[str]) -> JointStates:
        """Return the states that have all the joints.

        The time when a message was logged stands for a stamp of 0, and for stamps that are all of
        whole seconds.
        """
        m = len(joints)
        parts: list[np.ndarray] = []
        for names, rows in self._rows.items():
            if set(joints) <= set(names) and rows:
                table = np.frombuffer(rows).reshape(-1, self._width(names))
                columns = [_LEADING + names.index(joint) for joint in joints]
                if self._efforts:
                    columns += [column + len(names) for column in columns]
                parts.append(table[:, [*range(_LEADING), *columns]])
        if len(parts) == 1:  # in order, as mostly: a copy would take as much again
            (states,) = parts
        else:
            none = np.empty((0, _LEADING + m * (1 + self._efforts)))
            states = np.concatenate([none, *parts])
            states = states[states[:, 0].argsort()]
        stamps, times = states[:, 1], states[:, 2]
        remarks = self._left_out(joints)
        if not (stamps % 1).any():
            if stamps.any():
                remarks.insert(
                    0, "its stamps are whole seconds; the bag's times are taken"
                )
            stamps = times
        positions, efforts = np.split(states[:, _LEADING:], [m], axis=1)
        seconds = np.where(stamps == 0, times, stamps)
        return JointStates(seconds, positions, efforts, tuple(remarks))

    def _width(self, names: Sequence[str]) -> int:
        return _LEADING + len(names) * (1 + self._efforts)

    def _left_out(self, joints: Sequence[str]) -> list[str]:
        """Return remarks on the messages that are no state."""
        kinds = Counter({"lack a joint": 0})
        for names, rows in self._rows.items():
            count = self._unsound[names]
            if not set(joints) <= set(names):
                count += len(rows) // self._width(names)
            of_arm = not set(joints).isdisjoint(names)
            kind = "lack a joint" if of_arm else f"are of {', '.join(names):.90}"
            kinds[kind] += count
        return [
            f"{count} messages there {kind}, and are left out"
            for kind, count in kinds.items()
            if count
        ]


COMMANDED = re.compile(COMMANDS.pattern + "|fake|gui")
"""Words of topics that say where the joints should be."""
MEASURED = re.compile("measured|actual|feedback|encoders?")
"""Words of those that say where they are."""
ALIKE = 2e-3
"""Typical difference of positions below which two topics say the same [rad], [m]."""


def chosen_topic(
    states: Mapping[str, JointStates], question: Question
) -> tuple[str, list[str]]:
    """Return the topic that says what was measured, and remarks on the others.

    Names of commands come last, those of measurements first; then what moved, and the most states.

    Args:
        states: The states of each topic, at least one of each.
        question: The log.

    Raises:
        ExtractError: Two topics are as good by their names, and say different things.
    """
    counts = {topic: len(some.stamps) for topic, some in states.items()}
    ranks = {topic: _rank(topic, some) for topic, some in states.items()}
    best, *others = sorted(states, key=lambda topic: (*ranks[topic], -counts[topic]))
    remarks: list[str] = []
    if _says(COMMANDED, best):
        remarks.append(
            f"{best} is called like commands, which an arm follows by a degree or so; record what "
            "its joints measured"
        )
    listed = ", ".join(f"{topic} ({counts[topic]})" for topic in others)
    if others:
        remarks.append(f"the same joints are on {listed} too; --topic chooses")
    for other in others:
        difference = _difference(states[best], states[other])
        if ranks[best] == ranks[other] and difference > ALIKE:
            raise ExtractError(
                f"{question.path}: {best} and {other} have the same joints, {difference:.2g} rad "
                "apart: say which was measured, by --topic"
            )
    return best, remarks


def _says(pattern: re.Pattern[str], topic: str) -> bool:
    """Return whether one of a topic's words is of a pattern."""
    return any(map(pattern.fullmatch, words_of(topic)))


def _rank(topic: str, states: JointStates) -> tuple[bool, bool, bool]:
    """Return whether a topic is of commands, is not said to be measured, and stood still."""
    stood = not np.ptp(states.positions, axis=0).any()
    return _says(COMMANDED, topic), not _says(MEASURED, topic), stood


def _difference(first: JointStates, second: JointStates) -> float:
    """Return the typical difference of two topics at the second's moments, of the worst joint."""
    order = np.argsort(first.stamps)
    times = first.stamps[order]
    readings = first.positions[order].T
    at_moments: list[np.ndarray] = [
        np.interp(second.stamps, times, column) for column in readings
    ]
    offsets = np.abs(second.positions.T - at_moments)
    return float(np.median(offsets, axis=1).max())
