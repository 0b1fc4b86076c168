"""Hypotheses on what changed: a distance, a joint's zero, the tool, the base, the whole arm."""

from itertools import chain, product

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
    joints, begin = prior.robot.joint_names, prior.zeros.start
    base = list(chain.from_iterable(task.places[k].tolist() for k in task.known))
    share = PRIOR["joint"] / len(joints)
    some = [(name, share, [begin + j]) for j, name in enumerate(joints)]
    if task.distances:
        lengths = list(range(task.size, task.size + len(task.distances)))
        some.insert(0, (LENGTHS, PRIOR[LENGTHS], lengths))
    if prior.ball[0] not in task.free:
        some.append(("tool", PRIOR["tool"], prior.ball.tolist()))
    if base:
        some.append(("base", PRIOR["base"], base))
    candidates = [
        Explanation(name, p / len(TYPICAL), task.free | dict.fromkeys(indices, width))
        for (name, p, indices), width in product(some, TYPICAL)
    ]
    everything = Explanation(EVERYTHING, PRIOR[EVERYTHING], task.free | geometry_changes(task))
    return [Explanation(NOTHING, PRIOR[NOTHING], task.free), *candidates, everything]
