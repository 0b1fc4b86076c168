"""Faults of a session, as alarms with the words and keys that an operator needs."""

import json
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from ...recorder import Placement
from ...recorder.session import DRIFTS, Alarm, Alarms, Cause
from ...solver import assessment, diagnostics
from ...solver.assessment import millimetres
from ...solver.identification.robot import Robot
from ...solver.results import Hypothesis
from .checks import BEYOND, wrong_distance
from .pose_pool import Captures
from .wrong_readings import FAR, wrong_joint, wrong_model, wrong_signs, wrong_zero


class _Form(NamedTuple):
    """Words for a fault, with the numbers of its hypothesis in braces."""

    cause: Cause
    """Kind of key that cures it."""
    words: str
    """It in a word or two."""
    line: str
    """It in a line for the operator."""
    also: str = ""
    """It as a second cause that fits as well; empty where it is told as none."""


_TABLE = json.loads(Path(__file__).with_name("alarms.json").read_text())
FORMS = {name: _Form(**entry) for name, entry in _TABLE.items()}
"""Words for each fault, by the name of its hypothesis."""
AROUND = "by {size} mm around {joint} since sample {first}, or that reads otherwise"
"""No sample tells a base that turned around the first joint from that joint's zero."""
BEYOND_WORDS = "{metres} m off since sample {first}"
JOINTS = "JOINTS?"
"""Words for joints that read so otherwise that the ball would be far away."""
AGAIN = 2
"""Short placements before this one, each of which ended as the base moved: it is loose."""
TOOL = 0.01
"""A ball that moved farther on its flange is that of another tool [m]."""


class SessionAlarms:
    """Faults of the last of some placements, as alarms."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        repeats = assessment.repeatability_of(robot, None)
        self.coarse = diagnostics.is_coarse(repeats)
        """True for an arm of servos, whose zeros may be off by degrees."""
        self._check = diagnostics.LiveCheck(robot, repeats)

    def __call__(
        self, placements: Sequence[Placement], doubted: Captures = ()
    ) -> Alarms:
        """Return the alarms, the most probable fault first.

        Samples that alarms took back are evidence as well: two that are off by the same vector tell
        of a base, not of a ball. What concerns them alone was answered.
        """
        *before, placement = placements
        numbers = {sample.number for sample in doubted}
        samples = sorted(
            [*placement.samples, *doubted], key=lambda sample: sample.number
        )
        if wrong := self._wrong_from_the_start(placement):
            return (wrong,)
        joined = replace(placement, samples=tuple(samples))
        faults = self._check.faults([*before, joined])
        joint = _lost_twice(faults)
        slips = joint or any(fault.hypothesis.name == "slips" for fault in faults)
        if slips and before:
            # The joint may be mended since: then earlier samples tell nothing of it.
            return self([placement], doubted)
        if joint:
            cause, words, form, _ = FORMS["slips"]
            return (Alarm(cause, words, form.format(joint=joint)),)
        here = [fault for fault in faults if fault.placement == len(before)]
        is_far = any(_is_of_joints(f) and _size(f.hypothesis) > FAR for f in here)
        if is_far and (wrong := self._wrong_since(samples)):
            return (wrong,)
        oldest = min((s.number for s in placement.samples), default=math.inf)
        moves = sum(is_short(earlier) for earlier in before)
        return tuple(
            _with_cure(self._alarm(fault, doubted), oldest, moves)
            for fault in here
            if not set(fault.samples) <= numbers and not _is_another_ball(fault)
        )

    def _wrong_from_the_start(self, placement: Placement) -> Alarm | None:
        """Return an alarm that the model, signs or distance are not this arm's, before any fit."""
        robot, samples = self._robot, placement.samples
        if not samples:
            return None
        if complaint := wrong_model(robot, samples):
            return Alarm("model", "WRONG ARM?", complaint)
        if complaint := wrong_signs(robot, samples):
            return Alarm("model", "WRONG SIGNS?", complaint)
        if not self.coarse and (complaint := wrong_zero(robot, samples)):
            return Alarm("model", "WRONG ZERO?", complaint)
        given = placement.distance
        if not given or not (likely := wrong_distance(robot, given, samples)):
            return None
        numbers = {"likely": millimetres(likely, 0), "given": millimetres(given, 0)}
        cause, words, form, _ = FORMS["distance"]
        return Alarm(cause, words, form.format_map(numbers))

    def _wrong_since(self, samples: Captures) -> Alarm | None:
        """Return an alarm that a joint reads far otherwise since a sample."""
        if not (wrong := wrong_joint(self._robot, samples)):
            return None
        first, joint = wrong
        numbers = tuple(sample.number for sample in samples[first:])
        text = f"{joint} reads far otherwise since sample {numbers[0]}"
        return Alarm("joint", JOINTS, text, numbers)

    def _alarm(self, fault: diagnostics.Fault, doubted: Captures) -> Alarm:
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
        if is_repeated or (size > BEYOND and _is_of_joints(fault)):
            text = BEYOND_WORDS.format(first=first, metres=f"{size:.1f}")
            return Alarm("joints", JOINTS, text, concerned)
        cause, words, form, _ = FORMS[hypothesis.name]
        if hypothesis.name == "ball_bent" and size > TOOL:
            words = "TOOL CHANGED?"
            cause = "joints"  # earlier placements have another tool than the one to calibrate
        of_first = hypothesis.parameters.get("joint") == self._robot.joint_names[0]
        if of_first and hypothesis.name == "zero_lost":
            cause = "base"
            words = "BASE MOVED"
            form = AROUND
        sentence = hypothesis.text.partition(",")[0]
        names = {"first": first, "last": fault.samples[-1], "text": sentence}
        text = form.format_map(_shown(hypothesis) | names)
        # The second cause of samples since one that fits as well, if it is told.
        rivals = [
            r for r in fault.rivals if (f := FORMS.get(r.hypothesis.name)) and f.also
        ]
        if not rivals or not FORMS[hypothesis.name].also or form == AROUND:
            return Alarm(cause, words, text, fault.samples, fault.socket or 0)
        rival = rivals[0]
        rival_hypothesis = rival.hypothesis
        statement = text.partition(";")[0]  # without the question that follows
        form = FORMS[rival_hypothesis.name].also
        text = f"{statement}; as likely {form.format_map(_shown(rival_hypothesis))}"
        if rival_hypothesis.name != "base_moved" or words == DRIFTS:
            return Alarm(cause, words, text, fault.samples)
        return Alarm("base", words, text, rival.samples)


def _is_another_ball(fault: diagnostics.Fault) -> bool:
    """Return whether a fault may be a ball that was put on anew before a placement.

    A solving has an unknown for that, so no key would cure it, nor what may as well be one.
    """
    return any(
        f.hypothesis.name == "ball_bent" and f.hypothesis.parameters.get("throughout")
        for f in (fault, *fault.rivals)
    )


def _with_cure(alarm: Alarm, oldest: float, moves: int) -> Alarm:
    """Return an alarm with the cause whose keys cure it here.

    Args:
        alarm: The fault as it looks by its samples alone.
        oldest: Number of the placement's oldest sample.
        moves: Number of short placements before, each of which ended as the base moved.
    """
    if alarm.cause == "base" and moves >= AGAIN:
        text = f"it moved {moves + 1} times, now {alarm.text}"
        alarm = replace(alarm, cause="again", words="LOOSE BASE", text=text)
    stays = oldest < min(alarm.samples, default=0)
    if alarm.words == JOINTS and not stays:
        # no sound sample stays: one is taken back, more are the arm's own
        one = len(alarm.samples) == 1
        alarm = replace(alarm, cause="ball" if one else "model")
    return replace(alarm, stays=stays)


def _is_of_joints(fault: diagnostics.Fault) -> bool:
    """Return whether a fault, if it is large, may as well be a joint that reads wrongly."""
    return fault.socket is None and fault.hypothesis.name != "distance"


def _lost_twice(faults: Sequence[diagnostics.Fault]) -> str | None:
    """Return the joint that lost its zero, and then the new one; None without such a joint."""
    lost = [f.hypothesis for f in faults if f.hypothesis.name == "zero_lost"]
    joints = Counter(str(hypothesis.parameters["joint"]) for hypothesis in lost)
    return next((joint for joint, count in joints.items() if count > 1), None)


def is_short(placement: Placement) -> bool:
    """Return True for a placement with too few samples, as where it ended by an alarm."""
    return len(placement.samples) < 2 * assessment.LEAST_SAMPLES


def _size(hypothesis: Hypothesis) -> float:
    """Return how far off balls come out by a fault [m]."""
    numbers = {k: v for k, v in hypothesis.parameters.items() if isinstance(v, float)}
    difference = abs(numbers.get("likely", 0.0) - numbers.get("given", 0.0))
    scatter = 3 * numbers.get("noise", 0.0) if hypothesis.name == "ball_loose" else 0.0
    return max(numbers.get("size", 0.0), difference, scatter)


def _shown(hypothesis: Hypothesis) -> dict[str, Any]:
    """Return the numbers of a hypothesis as they are shown, lengths in millimetres."""
    numbers = {"likely": "?", "given": "?", "size": "?", **hypothesis.parameters}
    return {
        key: millimetres(value, 1) if isinstance(value, float) else value
        for key, value in numbers.items()
    }
