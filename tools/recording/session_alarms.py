"""Faults of a session, as alarms with the words and keys that an operator needs."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ...recorder import Placement, Sample
from ...recorder.session import Alarm, Cause
from ...solver import assessment, diagnostics
from ...solver.results import Hypothesis
from ...solver.robot import Robot
from .checks import BEYOND, FAR, wrong_model

CAUSES: dict[str, tuple[Cause, str, str]] = {
    "base_moved": ("base", "BASE MOVED", "by {size} mm since sample {first}"),
    "drift": ("other", "DRIFTS", "the base drifts, by {size} mm so far; is it tight?"),
    "ball_sample": ("ball", "NOT SEATED", "sample {first} is {size} mm off"),
    "ball_bent": (
        "other",
        "BALL MOVED",
        "by {size} mm on its flange since sample {first}; tight?",
    ),
    "ball_loose": ("other", "LOOSE", "all samples scatter: are ball and base tight?"),
    "zero_lost": (
        "other",
        "LOST A ZERO",
        "{joint} reads otherwise since sample {first}",
    ),
    "socket": ("socket", "WRONG SOCKET", "{text}"),
    "distance": (
        "distance",
        "DISTANCE?",
        "the sockets come out {likely} apart, not {given} mm",
    ),
}
"""For each fault, the kind of key that cures it, a word or two, and a line for the operator."""
ALSO = {
    "base_moved": "the base moved by {size} mm",
    "drift": "the base drifts",
    "ball_bent": "the ball moved on its flange",
    "zero_lost": "{joint} reads otherwise",
}
"""Words for a second cause that fits as well."""
AROUND = "by {size} mm around {joint} since sample {first}, or that reads otherwise"
"""No sample tells a base that turned around the first joint from that joint's zero."""
BEYOND_WORDS = "{metres} m off since sample {first}"


class SessionAlarms:
    """Faults of the last of some placements, as alarms."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        repeats = assessment.repeatability_of(robot, None)
        self.coarse = diagnostics.is_coarse(repeats)
        """True for an arm of servos, whose zeros may be off by degrees."""
        self._check = diagnostics.LiveCheck(robot, repeats)

    def __call__(
        self, placements: Sequence[Placement], doubted: Sequence[Sample] = ()
    ) -> tuple[Alarm, ...]:
        """Return the alarms, the most probable fault first.

        Samples that alarms took back are evidence as well: two that are off by the same vector tell
        of a base, not of a ball. What concerns them alone was answered.
        """
        *before, placement = placements
        if placement.samples and (
            complaint := wrong_model(self._robot, placement.samples)
        ):
            return (Alarm("other", "WRONG ARM?", complaint),)
        numbers = {sample.number for sample in doubted}
        samples = sorted(
            [*placement.samples, *doubted], key=lambda sample: sample.number
        )
        faults = self._check.faults(
            [*before, replace(placement, samples=tuple(samples))]
        )
        alarms = [
            self._alarm(fault, doubted)
            for fault in faults
            if fault.placement == len(before) and not set(fault.samples) <= numbers
        ]
        return tuple(_curable(alarm, placement.samples) for alarm in alarms)

    def _alarm(self, fault: diagnostics.Fault, doubted: Sequence[Sample]) -> Alarm:
        """Return a fault as an alarm.

        Nobody seats a ball far off twice in a row: then the joints read wrongly.
        """
        hypothesis = fault.hypothesis
        first = fault.samples[0]
        size = _size(hypothesis)
        concerned = fault.samples
        is_repeated = hypothesis.name == "ball_sample" and size > FAR and doubted
        if is_repeated:
            first = doubted[0].number
            concerned = (*(sample.number for sample in doubted), *concerned)
        if is_repeated or (size > BEYOND and fault.socket is None):
            text = BEYOND_WORDS.format(first=first, metres=f"{size:.1f}")
            return Alarm("joints", "JOINTS?", text, concerned)
        cause, words, form = CAUSES[hypothesis.name]
        if hypothesis.parameters.get("joint") == self._robot.joint_names[0]:
            cause = "base"
            words = "BASE MOVED"
            form = AROUND
        sentence = hypothesis.text.partition(",")[0]
        text = form.format_map(_shown(hypothesis) | {"first": first, "text": sentence})
        rival = _rival(fault)
        if rival is None or form == AROUND:
            return Alarm(cause, words, text, fault.samples, fault.socket or 0)
        rival_hypothesis = rival.hypothesis
        statement = text.partition(";")[0]  # without the question that follows
        form = ALSO[rival_hypothesis.name]
        text = f"{statement}; as likely {form.format_map(_shown(rival_hypothesis))}"
        if rival_hypothesis.name != "base_moved":
            return Alarm(cause, words, text, fault.samples)
        # its cure moves the samples since then: a drift concerns all
        return Alarm("base", words, text, rival.samples)


def _curable(alarm: Alarm, samples: Sequence[Sample]) -> Alarm:
    """Return an alarm whose cure leaves some of the samples: a new placement takes no whole one."""
    moves = alarm.cause in ("base", "joints")
    stays = any(sample.number < min(alarm.samples) for sample in samples)
    return replace(alarm, cause="other") if moves and not stays else alarm


def _size(hypothesis: Hypothesis) -> float:
    """Return how far off balls come out by a fault [m]."""
    numbers = {k: v for k, v in hypothesis.parameters.items() if isinstance(v, float)}
    difference = abs(numbers.get("likely", 0.0) - numbers.get("given", 0.0))
    scatter = 3 * numbers.get("noise", 0.0) if hypothesis.name == "ball_loose" else 0.0
    return max(numbers.get("size", 0.0), difference, scatter)


def _rival(fault: diagnostics.Fault) -> diagnostics.Fault | None:
    """Return the second cause of samples since one that fits as well, if any."""
    rivals = [rival for rival in fault.rivals if rival.hypothesis.name in ALSO]
    return rivals[0] if rivals and fault.hypothesis.name in ALSO else None


def _shown(hypothesis: Hypothesis) -> dict[str, Any]:
    """Return the numbers of a hypothesis as they are shown, lengths in millimetres."""
    numbers = {"likely": "?", "given": "?", "size": "?", **hypothesis.parameters}
    return {
        key: assessment.millimetres(value, 1) if isinstance(value, float) else value
        for key, value in numbers.items()
    }
