"""What changed since a calibration: nothing, a joint, the tool, the base, or everything."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ...recorder import Placement
from ..assessment import FEWEST_SAMPLES, Verdict, judge, limit_row, too_few
from ..calibration import Calibration, as_list
from ..data import measure
from .evidence import Explanation, probabilities
from .fit import Task, fit
from .prior import prior_of
from .sockets import socket_task

NOTHING = "nothing"
PRIOR = {NOTHING: 0.5, "joint": 0.3, "tool": 0.1, "base": 0.1, "everything": 0.1}
"""Probabilities before the samples; that of the joints is shared among them."""
ZEROS, PLACES = (1e-3, 2e-2), (1e-3, 2e-2)
"""Typical changes of a joint's zero [rad], of a tool's or base's place [m]."""
EVERYTHING = {"m": 1e-3, "rad": 3e-3}
"""Typical change of each number of the geometry after a crash."""
VALID = 0.1
"""Probability that nothing changed down to which the calibration counts as valid: nine to one."""
_NEXT = {
    "tool": "the ball or tool was moved: find the tool by mukca tool, or mukca rezero --ball-moved",
    "base": "the base was moved: leave out --stood",
    "everything": "no single change explains it: record placements, and mukca solve again",
}


@dataclass(frozen=True)
class Validity:
    """What changed since a calibration, by samples recorded since."""

    probabilities: dict[str, float]
    """Of each explanation: ``nothing``, each joint, ``tool``, ``base``, ``everything``."""
    samples: int

    @property
    def likeliest(self) -> str:
        """The most probable explanation."""
        return max(self.probabilities, key=self.probabilities.__getitem__)

    @property
    def verdict(self) -> Verdict:
        """The verdict, by the one judge."""
        nothing = self.probabilities[NOTHING]
        status = "pass" if nothing >= VALID else "fail"
        status = "not enough" if self.samples < FEWEST_SAMPLES else status
        return judge([limit_row("validity", "validity", status, self.text, text=self.text)])

    @property
    def text(self) -> str:
        """What changed, with its probability, and the next step."""
        nothing, likely = self.probabilities[NOTHING], self.likeliest
        if self.samples < FEWEST_SAMPLES:
            return too_few(self.samples)
        share = f"{100 * self.probabilities[likely]:.1f} %"
        if likely == NOTHING:
            return f"still valid: nothing changed, with a probability of {share}"
        if nothing >= VALID:
            return f"not sure to have changed: {likely} may have ({share}); record more samples"
        step = _NEXT.get(likely, f"mukca rezero --joint {likely} finds its zero")
        return f"changed: {likely}, with a probability of {share}; {step}"


def what_changed(
    calibration: Calibration,
    data: Placement | Sequence[Placement],
    stood: str = "",
    distance: float | None = None,
) -> Validity:
    """Tell what changed since a calibration, by samples with the ball in sockets.

    ``calibration.validate`` says how large the errors are; this says what they come from.

    Args:
        calibration: The calibration.
        data: Samples recorded since, 6 in each of two sockets, say.
        stood: Placement of the calibration whose base still stands where it stood, or should.
        distance: Between the sockets' centres [m]; None for the recording's.

    Raises:
        UsageError: No such placement, or a calibration that leaves no posterior.
        MeasurementError: Samples of another arm.
    """
    prior = prior_of(calibration)
    measured = [measure(p, prior.robot, distance, sockets=1) for p in as_list(data)]
    task = socket_task(prior, measured, stood)
    explanations = _explanations(task)
    single = [one for one in explanations if one.name != "everything"]
    wide = {i: w for one in single for widths in one.widths for i, w in widths.items()}
    found = probabilities(fit(replace(task, free=wide)), explanations).tolist()
    names = [one.name for one in explanations]
    return Validity(dict(zip(names, found, strict=True)), len(task.rows.q))


def _explanations(task: Task) -> list[Explanation]:
    prior = task.prior
    joints, begin = prior.robot.joint_names, prior.zeros.start
    base = [i for k in task.known for i in task.place(k).tolist()]
    geometry = {
        i: EVERYTHING[p.unit] for i, p in enumerate(prior.model.parameters) if not p.of_ball
    }
    ball = prior.ball.tolist()
    each = PRIOR["joint"] / len(joints)
    found = [Explanation(NOTHING, PRIOR[NOTHING], [{}])]
    found += [
        Explanation(name, each, [{begin + j: width} for width in ZEROS])
        for j, name in enumerate(joints)
    ]
    found.append(Explanation("tool", PRIOR["tool"], [dict.fromkeys(ball, w) for w in PLACES]))
    if base:
        found.append(Explanation("base", PRIOR["base"], [dict.fromkeys(base, w) for w in PLACES]))
    return [*found, Explanation("everything", PRIOR["everything"], [geometry])]
