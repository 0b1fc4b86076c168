"""Topics of a bag that have the same joints: which one says what was measured."""

import re
from collections.abc import Mapping

import numpy as np

from .joint_messages import JointStates
from .log import ExtractError, Question

COMMANDED = re.compile(
    "command|commands|commanded|cmd|desired|goal|target|reference|ref|setpoint|planned|fake|gui"
)
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
    words = re.split(r"[\W_]+", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", topic).lower())
    return any(map(pattern.fullmatch, words))


def _rank(topic: str, states: JointStates) -> tuple[bool, bool, bool]:
    """Return whether a topic is of commands, is not said to be measured, and stood still."""
    stood = not np.ptp(states.positions, axis=0).any()
    return _says(COMMANDED, topic), not _says(MEASURED, topic), stood


def _difference(first: JointStates, second: JointStates) -> float:
    """Return the typical difference of two topics at the second's moments, of the worst joint."""
    order = np.argsort(first.stamps)
    times = first.stamps[order]
    differences: list[float] = []
    for joint in range(first.positions.shape[1]):
        readings = first.positions[order, joint]
        at_moments: np.ndarray = np.interp(second.stamps, times, readings)
        offsets = second.positions[:, joint] - at_moments
        differences.append(float(np.median(np.abs(offsets))))
    return max(differences)
