"""Alarms of a session: faults that its samples show, told so that a hand can cure them."""

from collections.abc import Sequence
from typing import Literal

from ...recorder import Placement
from ...recorder.session import Alarm
from ...solver.assessment import millimetres, repeatability_of
from ...solver.diagnostics import Fault, LiveCheck, is_coarse
from ...solver.robot import Robot
from .outlier_checks import wrong_model_check

CAUSES: dict[str, tuple[Literal["base", "ball", "socket", "other"], str]] = {
    "base_moved": ("base", "BASE MOVED"),
    "drift": ("other", "DRIFTS"),
    "ball_sample": ("ball", "NOT SEATED"),
    "ball_bent": ("other", "BALL MOVED"),
    "ball_loose": ("other", "LOOSE"),
    "zero_lost": ("other", "LOST A ZERO"),
    "socket": ("socket", "WRONG SOCKET"),
    "distance": ("other", "DISTANCE?"),
}
"""What a key cures, and a word or two, for each fault."""


class SessionAlarms:
    """Faults of the last of some placements, as alarms."""

    def __init__(self, robot: Robot) -> None:
        self._wrong_model = wrong_model_check(robot)
        repeats = repeatability_of(robot, None)
        self.coarse = is_coarse(repeats)
        """True for an arm of servos, whose zeros may be off by degrees."""
        self._check = LiveCheck(robot, repeats)

    def __call__(self, placements: Sequence[Placement]) -> tuple[Alarm, ...]:
        """Return the alarms, the most probable fault first."""
        here, last = placements[-1].samples, len(placements) - 1
        if here and (wrong := self._wrong_model(here)):
            return (Alarm("other", "WRONG ARM?", wrong),)
        found = [f for f in self._check.faults(placements) if f.placement == last]
        return tuple(_alarm(fault) for fault in found)


def _alarm(fault: Fault) -> Alarm:
    first, name = fault.samples[0], fault.hypothesis.name
    p = fault.hypothesis.parameters
    size = p.get("size")
    lengths = (p.get("likely"), p.get("given"))
    likely, given = (millimetres(x, 1) if isinstance(x, float) else "?" for x in lengths)
    mm = f"{1e3 * size:.1f} mm" if isinstance(size, float) else ""
    texts = {
        "base_moved": f"by {mm} since sample {first}",
        "drift": f"the base drifts, by {mm} so far; is it tight?",
        "ball_sample": f"sample {first} is {mm} off",
        "ball_bent": f"by {mm} on its flange since sample {first}; tight?",
        "ball_loose": "all samples scatter: are ball and base tight?",
        "zero_lost": f"{p.get('joint')} reads otherwise since sample {first}",
        "distance": f"the sockets come out {likely} apart, not {given} mm",
    }
    texts["socket"] = fault.hypothesis.text.partition(",")[0]
    cause, words = CAUSES[name]
    text = texts.get(name, fault.hypothesis.text)
    return Alarm(cause, words, text, fault.samples, fault.socket or 0)
