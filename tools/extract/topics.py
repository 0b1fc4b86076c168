"""Topics of a bag that have the same joints: which one says what was measured."""

import re
from collections.abc import Mapping, Sequence

import numpy as np

from .log import ExtractError, Question

State = tuple[float, np.ndarray, "np.ndarray | None"]
"""Stamp [s], positions, and efforts if all are known."""
COMMANDED = frozenset(
    {
        "command",
        "commands",
        "commanded",
        "cmd",
        "desired",
        "goal",
        "target",
        "reference",
    }
    | {"ref", "setpoint", "planned", "fake", "gui"}
)
"""Words of topics that say where the joints should be."""
MEASURED = {"measured", "actual", "feedback", "encoder", "encoders"}
"""Words of those that say where they are."""
ALIKE = 2e-3
"""Typical difference of positions below which two topics say the same [rad], [m]."""


def chosen_topic(
    states: Mapping[str, Sequence[State]], question: Question
) -> tuple[str, list[str]]:
    """Return the topic that says what was measured, and remarks on the others.

    Names of commands come last, those of measurements first; then what moved, and the most states.

    Args:
        states: The states of each topic, of at least one some.
        question: The log.

    Raises:
        ExtractError: Two topics are as good by their names, and say different things.
    """
    used = [topic for topic, some in states.items() if some]
    best, *others = sorted(
        used, key=lambda topic: (*_rank(topic, states), -len(states[topic]))
    )
    remarks: list[str] = []
    if _is_commanded(best):
        remarks.append(
            f"{best} is called like commands, which an arm follows by a degree or so; record what "
            "its joints measured"
        )
    listed = ", ".join(f"{topic} ({len(states[topic])})" for topic in others)
    if others:
        remarks.append(f"the same joints are on {listed} too; --topic chooses")
    for other in others:
        doubtful = _rank(best, states) == _rank(other, states)
        difference = _difference(states[best], states[other])
        if doubtful and difference > ALIKE:
            raise ExtractError(
                f"{question.path}: {best} and {other} have the same joints, {difference:.2g} rad "
                "apart: say which was measured, by --topic"
            )
    return best, remarks


def _words(topic: str) -> set[str]:
    return set(re.split(r"[\W_]+", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", topic).lower()))


def _is_commanded(topic: str) -> bool:
    return not COMMANDED.isdisjoint(_words(topic))


def _rank(topic: str, states: Mapping[str, Sequence[State]]) -> tuple[bool, bool, bool]:
    """Return whether a topic is of commands, is not said to be measured, and stood still."""
    positions = np.array([position for _, position, _ in states[topic]])
    stood = not np.ptp(positions, axis=0).any()
    return _is_commanded(topic), MEASURED.isdisjoint(_words(topic)), stood


def _difference(first: Sequence[State], second: Sequence[State]) -> float:
    """Return the typical difference of two topics at the second's moments, of the worst joint."""
    times = np.array([stamp for stamp, _, _ in first])
    moments = np.array([stamp for stamp, _, _ in second])
    positions = np.array([position for _, position, _ in first])[np.argsort(times)]
    others = np.array([position for _, position, _ in second])
    times.sort()
    differences: list[float] = []
    for joint in range(others.shape[1]):
        at_moments = np.interp(moments, times, positions[:, joint])
        differences.append(float(np.median(np.abs(others[:, joint] - at_moments))))
    return max(differences)
