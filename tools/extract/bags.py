"""ROS 1 and ROS 2 bags, through the package rosbags."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .log import ExtractError, Log, Question, columns_of, unknown_joints


@dataclass
class _Topic:
    """States of the model's joints on one topic."""

    stamps: list[float] = field(default_factory=list[float])
    positions: list[np.ndarray] = field(default_factory=list[np.ndarray])
    efforts: list[np.ndarray | None] = field(default_factory=list["np.ndarray | None"])
    skipped: int = 0
    """Messages without all joints, or with values that are no numbers."""


def read(question: Question) -> Log:
    """Return the joint states of a bag."""
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise ExtractError("bags need rosbags: pip install 'mukca[bags]'") from None
    store = get_typestore(Stores.ROS2_HUMBLE)
    try:
        with AnyReader([question.path], default_typestore=store) as reader:
            return _read(reader, question)
    except ExtractError:
        raise
    except Exception as error:  # whatever the reader stumbles over, the bag is to blame
        words = " ".join(str(error).split()) or type(error).__name__
        raise ExtractError(f"{question.path}: not a whole bag: {words}") from None


def _read(reader: Any, question: Question) -> Log:
    states = [c for c in reader.connections if c.msgtype.endswith("/JointState")]
    chosen = [c for c in states if question.topic in (None, c.topic)]
    if not chosen:
        offered = sorted({f"{c.topic} ({c.msgtype})" for c in states or reader.connections})
        raise ExtractError(
            f"{question.path}: no sensor_msgs/JointState"
            f"{f' on {question.topic}' if question.topic else ''}; it has "
            f"{', '.join(offered) or 'nothing'}"
        )
    orders: dict[tuple[str, ...], list[int] | None] = {}
    topics: dict[str, _Topic] = {}
    for connection, time, raw in reader.messages(connections=chosen):
        message = reader.deserialize(raw, connection.msgtype)
        names = tuple(message.name)
        if names not in orders:
            orders[names] = columns_of(names, question)
        _take(topics.setdefault(connection.topic, _Topic()), message, orders[names], time)
    best = max(topics, key=lambda topic: len(topics[topic].stamps), default=None)
    if best is None or not topics[best].stamps:
        named = dict.fromkeys(name for names in orders for name in names)
        raise unknown_joints(list(named), question)
    return _log(topics[best], _notes(best, topics), question)


def _take(topic: _Topic, message: Any, order: Sequence[int] | None, time: int) -> None:
    """Add a message's state, if it has all joints."""
    position = np.asarray(message.position, dtype=float)
    if order is None or len(position) != len(message.name) or not np.isfinite(position).all():
        topic.skipped += 1
        return
    stamp = message.header.stamp
    nanoseconds = stamp.sec * 1_000_000_000 + stamp.nanosec
    topic.stamps.append(1e-9 * (nanoseconds or time))
    topic.positions.append(position[order])
    effort = np.asarray(message.effort, dtype=float)
    whole = len(effort) == len(position) and bool(np.isfinite(effort).all())
    topic.efforts.append(effort[order] if whole else None)


def _notes(best: str, topics: dict[str, _Topic]) -> tuple[str, ...]:
    counts = Counter({name: len(topic.stamps) for name, topic in topics.items()})
    notes = [f"read {best}, {counts[best]} states"]
    if topics[best].skipped:
        notes.append(f"{topics[best].skipped} messages there lack a joint, and are left out")
    others = [f"{name} ({count})" for name, count in counts.items() if count and name != best]
    if others:
        notes.append(f"the same joints are on {', '.join(others)} too; --topic chooses")
    return tuple(notes)


def _log(topic: _Topic, notes: tuple[str, ...], question: Question) -> Log:
    """Return the states in order of their stamps, each once."""
    stamps, first = np.unique(np.array(topic.stamps), return_index=True)
    order: list[int] = first.tolist()
    efforts = [effort for i in order if (effort := topic.efforts[i]) is not None]
    known = question.efforts and len(efforts) == len(stamps)
    if question.efforts and not known:
        notes = (*notes, "its messages have no efforts, or not always")
    return Log(
        stamps,
        np.array([topic.positions[i] for i in order]),
        np.array(efforts, dtype=float) if known else None,
        np.zeros(len(stamps), dtype=int),
        notes,
    )
