"""Messages of joint states as numbers: a message takes kilobytes of memory, a number 8 bytes."""

from array import array
from collections import Counter, defaultdict
from collections.abc import Sequence
from itertools import chain
from typing import Any

import numpy as np


class JointMessages:
    """The numbers of one topic's messages, apart for each list of joint names in them."""

    def __init__(self, *, efforts: bool) -> None:
        self._efforts = efforts
        self._count = 0
        self._rows: defaultdict[tuple[str, ...], array[float]]
        """By the names: a message's number, its stamp [s], positions, and efforts if asked for."""
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
        rows.extend((self._count, 1e-9 * (nanoseconds or time)))
        rows.frombytes(position.tobytes())
        if self._efforts:
            effort = np.asarray(message.effort, dtype=float)
            if len(effort) != len(names):
                effort = np.full(len(names), np.nan)
            rows.frombytes(effort.tobytes())
        self._count += 1

    def count(self, joints: Sequence[str]) -> int:
        """Return the number of states, which have all the joints."""
        return sum(
            len(rows) // self._width(names)
            for names, rows in self._rows.items()
            if set(joints) <= set(names)
        )

    def states(self, joints: Sequence[str]) -> np.ndarray:
        """Return stamp, positions and efforts of each state as it came, shape (N, 1 + m or 1 + 2m).

        Positions [rad] and efforts [N m] are in the order of the joints.
        """
        parts: list[np.ndarray] = []
        for names, rows in self._rows.items():
            if set(joints) <= set(names):
                table = np.frombuffer(rows).reshape(-1, self._width(names))
                columns = [2 + names.index(joint) for joint in joints]
                if self._efforts:
                    columns += [column + len(names) for column in columns]
                parts.append(table[:, [0, 1, *columns]])
        states = np.concatenate(parts) if len(parts) > 1 else parts[0]
        order = states[:, 0].argsort()
        return states[order, 1:]

    def _width(self, names: Sequence[str]) -> int:
        return 2 + len(names) * (1 + self._efforts)

    def left_out(self, joints: Sequence[str]) -> list[str]:
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
