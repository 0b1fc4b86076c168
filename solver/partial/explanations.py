"""Hypotheses on what changed: a distance, a joint's zero, the tool, the base, the whole arm."""

from collections.abc import Sequence

from .evidence import Explanation, geometry_changes
from .task import Task

NOTHING, LENGTHS, EVERYTHING = "nothing", "distance", "everything"
PRIOR = {NOTHING: 0.5, LENGTHS: 0.05, "joint": 0.3, "tool": 0.1, "base": 0.1, EVERYTHING: 0.1}
"""Prior probabilities; that of ``joint`` is shared among all joints."""
TYPICAL = (1e-3, 2e-2)
"""Typical changes of a joint's zero [rad], of a tool's or base's place [m]."""


def explanations(task: Task) -> list[Explanation]:
    """Return the hypotheses: nothing, a wrong distance, a joint, the tool, the base, everything."""
    prior = task.prior
    joints = prior.robot.joint_names
    lengths = range(task.size, task.size + len(task.distances))
    ball = [i for i in prior.ball if i not in task.free]
    base = task.places[task.known].ravel()
    share = PRIOR["joint"] / len(joints)
    candidates = [Explanation(NOTHING, PRIOR[NOTHING], {})]
    candidates += changes_of(LENGTHS, PRIOR[LENGTHS], lengths)
    for joint, zero in zip(joints, prior.zeros, strict=True):
        candidates += changes_of(joint, share, [zero])
    candidates += changes_of("tool", PRIOR["tool"], ball)
    candidates += changes_of("base", PRIOR["base"], base.tolist())
    return [*candidates, Explanation(EVERYTHING, PRIOR[EVERYTHING], geometry_changes(task))]


def changes_of(name: str, prior: float, unknowns: Sequence[int]) -> list[Explanation]:
    """Return the hypotheses that unknowns changed by what is typical; none without unknowns."""
    share = prior / len(TYPICAL)
    widths = TYPICAL if unknowns else ()
    return [Explanation(name, share, dict.fromkeys(unknowns, width)) for width in widths]
