"""Pose selection: the predicted error of a calibration on the samples, and the best next pose."""

from collections import Counter
from collections.abc import Sequence
from itertools import takewhile

import numpy as np

from ...recorder import Configuration, Placement
from ...recorder.session import BLOCK, NO_ANSWERS, SLIPS, Advice, Alarms, Answers
from ...solver import design
from ...solver.assessment import LEAST_SAMPLES
from ...solver.identification.inference import Posterior
from ...solver.identification.robot import Robot
from .checks import goal_for
from .pose_pool import SEAT, Captures, PosePool, positions_in
from .session_alarms import SessionAlarms, is_short
from .sufficiency import StoppingRule, Sufficiency, rigid_fit, sufficiency_of, with_fit

MIN_FITTED = 6
"""Samples in each of two sockets from which on a fit is tried."""
SHARE = 12
"""Samples in a socket from which on a placement can be exhausted."""
MOST = 36
"""Samples in two sockets after which another placement teaches more, unless a goal was given.
Those of placements that ended early count as well."""
CURVES = 3
"""Placements before this one, with which joint error curves are known as well as they may be."""
MORE = 12
"""Further samples in each socket that may still be worth taking to reach the goal."""
MIN_GAIN = 0.03
"""Share of the predicted error: if the best next sample gains less, the placement is exhausted."""
PLATEAU, PLATEAU_SAMPLES = 0.06, 3
"""It is also exhausted if the last few samples gained less than this share."""


_NO_ROUTE: tuple[list[int], np.ndarray] = ([], np.zeros((0, 0)))
"""Sockets of the samples to come, and their poses, shape (N, m), where none are planned."""


class PoseSelector:
    """Selection of poses at one placement, after earlier ones of the same arm.

    The distance is between sockets 0 and 1 [m]; the goal of the predicted error of distances [m],
    None for what ``mukca solve`` asks; ``turn`` the farthest that a joint is led from the session's
    begin [rad]; ``lost`` the samples of the session that tell nothing of this placement.
    """

    def __init__(
        self,
        robot: Robot,
        distance: float,
        goal: float | None = None,
        sockets: int = 2,
        parts: Sequence[Placement] = (),
        turn: float = np.inf,
        lost: int = 0,
    ) -> None:
        self._robot = robot
        self._lost = lost
        self._distance = distance
        self._given, self._goal = goal, goal_for(robot) if goal is None else goal
        self._sockets, self._curved = sockets, bool(design.curve_advice(robot))
        self._pool = PosePool(robot, turn)
        self._model = self._pool.model
        self._alarms = SessionAlarms(robot)
        self._last_alarms: tuple[object, Alarms] = None, ()
        self._earlier = tuple(parts)
        self._history: dict[int, float] = {}
        self._rule = StoppingRule(near_suffices=goal is None)
        self._route = _NO_ROUTE
        self._solved: Sufficiency | None = None

    def alarms(self, samples: Captures, answers: Answers = NO_ANSWERS) -> Alarms:
        """Return the faults that the operator has not answered, the most probable first.

        It takes under a second.
        """
        self._distance = answers.distance or self._distance
        evidence = tuple(samples), answers.doubted, self._distance
        if self._last_alarms[0] != evidence:
            placements = [*self._earlier, self._placement(samples)]
            self._last_alarms = evidence, self._alarms(placements, answers.doubted)
        return answers.open_alarms(self._last_alarms[1])

    def advise(
        self,
        samples: Captures,
        socket: int,
        position: Sequence[float] | None = None,
        answers: Answers = NO_ANSWERS,
    ) -> Advice:
        """Return advice for the active socket and the arm's configuration [rad], [m]."""
        self._pool.heed(answers)
        alarms = self.alarms(samples, answers)
        posterior = self._fitted(samples)
        state = self._covariance(samples, posterior)
        where = design.workspace_of(self._model, state.x)
        rigid = state.error(where)
        self._history[len(samples)] = rigid if posterior is not None else np.inf
        order = self._order(samples, socket)
        target, gain = self._next(state, where, samples, order, position)
        counts = self._counts(samples)[:2]
        fewest = min(counts) if self._sockets > 1 else 0
        solved = None
        if posterior or fewest >= LEAST_SAMPLES:
            placements = [*self._earlier, self._placement(samples, answers)]
            zeros = self._alarms.coarse
            solved = sufficiency_of(self._model, placements, zeros=zeros)
        self._solved = solved
        predicted = (solved and solved.predicted) or rigid
        goal = self._given or (solved and solved.asked) or self._goal
        reserve = goal * rigid / predicted
        lost = self._lost
        lost += sum(len(part.samples) for part in self._earlier if is_short(part))
        is_at_bound = sum(counts) + lost >= MOST and fewest >= LEAST_SAMPLES
        exhausted = is_at_bound and self._given is None
        exhausted |= fewest >= SHARE and self._exhausted(
            state, where, samples, gain, reserve
        )
        exhausted |= fewest >= LEAST_SAMPLES and _mends_nothing(solved, answers)
        reaches_goal = predicted <= goal
        end = self._rule.end(
            None if alarms else solved, exhausted=exhausted, reaches_goal=reaches_goal
        )
        block_done = self._sockets > 1 and _run(samples, socket) >= BLOCK
        stays = bool(samples) and samples[-1].socket == order[0]
        lift = bool(target) and stays and self._pool.lifted(samples, position, target)
        steps = zip(self._route[0], self._route[1].tolist(), strict=False)
        advice = Advice(
            count=len(samples),
            socket=socket,
            predicted=predicted,
            goal=goal,
            leave=block_done and not (end.enough or end.exhausted),
            **end._asdict(),
            target=target,
            lift=lift,
            alone=not self._earlier,
            alarms=alarms,
            fails=solved.fails if solved and not alarms else "",
            route=tuple((k, tuple(q)) for k, q in steps),
        )
        return with_fit(advice, posterior, samples) if posterior else advice

    def _exhausted(
        self,
        state: design.ParameterCovariance,
        where: design.Workspace,
        samples: Captures,
        gain: float,
        goal: float,
    ) -> bool:
        """Return whether more samples here would hardly help, and not reach the goal either."""
        count = len(samples)
        before = self._history.get(count - PLATEAU_SAMPLES, np.inf)
        plateau = before < np.inf and self._history[count] > (1 - PLATEAU) * before
        if gain >= MIN_GAIN and not plateau:
            return False
        for socket in (0, 1):
            poses = self._pool.candidates(samples, socket)[:MORE]
            if len(poses):
                state = state.with_samples(poses, socket)
        return state.error(where) > goal

    def _counts(self, samples: Captures) -> list[int]:
        """Return the number of samples in each socket."""
        counts = Counter(sample.socket for sample in samples)
        return [counts[k] for k in range(self._sockets)]

    def _fitted(self, samples: Captures) -> Posterior | None:
        if self._sockets < 2 or min(self._counts(samples)[:2]) < MIN_FITTED:
            return None
        return rigid_fit(self._model, [*self._earlier, self._placement(samples)])

    def _placement(self, samples: Captures, answers: Answers = NO_ANSWERS) -> Placement:
        """Return the samples as a solving reads them."""
        texts = tuple(alarm.text for alarm in answers.kept)
        names = self._robot.joint_names
        return Placement(
            "here", tuple(samples), names, self._distance, kept_alarms=texts
        )

    def _covariance(
        self, samples: Captures, posterior: Posterior | None
    ) -> design.ParameterCovariance:
        """Return the parameters' covariance by the fit, or without one by the poses alone.

        Poses of earlier placements of the arm count as well: a new one begins with what they tell.
        """
        if posterior:
            return design.from_fit(posterior)
        state, taken = self._prior(samples)
        for q, socket in taken:
            state = state.with_samples(q, socket)
        return state

    def _prior(
        self, samples: Captures
    ) -> tuple[design.ParameterCovariance, list[tuple[np.ndarray, int]]]:
        """Return the covariance before all samples of all placements, and these by socket."""
        recorded = [samples, *(part.samples for part in self._earlier)]
        count = self._sockets
        state = design.from_prior(self._model, SEAT, count * len(recorded))
        taken: list[tuple[np.ndarray, int]] = []
        for i, some in enumerate(recorded):
            if count > 1:
                state = self._pool.with_distance(state, some, count * i)
            sockets = [(positions_in(some, k), count * i + k) for k in range(count)]
            taken += [(q, k) for q, k in sockets if len(q)]
        return state, taken

    def closing(self, samples: Captures) -> tuple[str, ...]:
        """Return the gain of another placement, in words; this takes some seconds.

        The error now is that of the last advice.
        """
        if self._sockets != 2 or min(self._counts(samples)) == 0:
            return ()
        state = self._covariance(samples, self._fitted(samples))
        centres = [self._pool.centre(samples, k) for k in (0, 1)]
        base = np.array([c for c in centres if c is not None])
        place = self._pool.place_beside([samples, *(p.samples for p in self._earlier)])
        now = self._solved and self._solved.error
        where = design.workspace_of(self._model, state.x)
        reach = self._pool.reach
        distance = self._distance
        lines = design.next_base_advice(state, where, reach, base, distance, place, now)
        if self._curved and len(self._earlier) < CURVES:
            return (*lines, design.curve_advice(self._robot))
        return tuple(lines)

    def _order(self, samples: Captures, socket: int) -> list[int]:
        """Return the sockets of the samples to come: the rest of a block, and further blocks."""
        count = max(SHARE * self._sockets - len(samples), BLOCK)
        begun = min(_run(samples, socket), BLOCK)
        return [(socket + (begun + i) // BLOCK) % self._sockets for i in range(count)]

    def _next(
        self,
        state: design.ParameterCovariance,
        where: design.Workspace,
        samples: Captures,
        order: list[int],
        position: Sequence[float] | None,
    ) -> tuple[Configuration | None, float]:
        """Return the next pose of a short way, and the gain of the pose that teaches most."""
        # a socket without a sample is near the others, in the order or not
        sockets = dict.fromkeys([*order, *range(self._sockets)])
        pools = {k: self._pool.candidates(samples, k) for k in sockets}
        reached = [pool for pool in pools.values() if len(pool)]
        if not reached:
            self._route = _NO_ROUTE
            return None, 0.0
        pools = {k: pools[k] if len(pools[k]) else reached[0] for k in order}
        start = None if position is None else np.array(position)
        route = self._rest(order)
        if self._curved:
            prior = self._prior(samples)
            way = design.CurveAnnealing(*prior, pools, order, start).way(route)
        else:
            way = design.plan_poses(state, where, pools, order, start, route)
        self._route = order, way
        socket = order[0]
        with_scale, by_shape = state.variance_reduction(pools[socket], socket, where)
        gain = with_scale[int(np.argmax(by_shape))]
        # of variance; of the deviation it is half as much
        return tuple(way[0].tolist()), 1 - float(np.sqrt(1 - gain))

    def _rest(self, order: list[int]) -> np.ndarray | None:
        """Return the rest of the previous route; None where the sockets to come have changed."""
        before, way = self._route
        for done in (0, 1):
            remainder = before[done:]
            if remainder and remainder == order[: len(remainder)]:
                return way[done:]
        return None


def _run(samples: Captures, socket: int) -> int:
    return len(list(takewhile(lambda s: s.socket == socket, reversed(samples))))


def _mends_nothing(solved: Sufficiency | None, answers: Answers) -> bool:
    """Return whether more samples would mend no fault that is kept, nor what solve refuses."""
    if any(alarm.words == SLIPS for alarm in answers.kept):
        return True
    if solved is None or not solved.fails:
        return False
    return bool(answers.kept) or solved.predicted is None
