"""Pose selection for the zeros of a calibrated arm's joints, without calibrating again."""

from collections.abc import Sequence
from itertools import chain

import numpy as np

from ...recorder.session import NO_ANSWERS, Advice, Alarms, Answers
from ...solver.calibration import Calibration
from ...solver.design import ParameterCovariance
from ...solver.partial import identifiable_zeros, zero_covariance
from .guidance import PoseSelector
from .pose_pool import Captures


class ZeroSelector(PoseSelector):
    """Selection of a number of poses in each socket that identify the joints' zeros best.

    What is predicted is the root mean square of the zeros' standard deviations [rad], and the goal
    what the poses to come would leave of it.
    """

    def __init__(
        self,
        calibration: Calibration,
        distance: float,
        target: int,
        sockets: int = 2,
        turn: float = np.inf,
    ) -> None:
        super().__init__(calibration.robot, distance, sockets=sockets, turn=turn)
        self._target = target
        self._curved = False
        self._first = zero_covariance(calibration, sockets)

    def alarms(self, samples: Captures, answers: Answers = NO_ANSWERS) -> Alarms:
        """Return none: zeros that are off would look like faults."""
        return ()

    def advise(
        self,
        samples: Captures,
        socket: int,
        position: Sequence[float] | None = None,
        answers: Answers = NO_ANSWERS,
    ) -> Advice:
        """Return advice for the active socket and the arm's configuration [rad], [m]."""
        self._pool.heed(answers)
        state = self._known(samples)
        order = self._order(samples, socket)
        pools = {k: self._pool.candidates(samples, k) for k in range(self._sockets)}
        pools = {k: pool for k, pool in pools.items() if len(pool)}
        where = identifiable_zeros(self._known(()), pools)
        target = None
        after = state
        if order and len(where.slopes):
            target, _ = self._next(state, where, samples, order, position)
            for k, q in zip(*self._route, strict=True):
                after = after.with_samples(q[None], k)
        predicted = goal = np.inf
        if len(where.slopes):
            predicted = float(np.sqrt(np.mean(state.deviations(where) ** 2)))
            goal = float(np.sqrt(np.mean(after.deviations(where) ** 2)))
        return Advice(
            count=len(samples),
            socket=socket,
            predicted=predicted,
            goal=goal,
            unit="mrad",
            leave=bool(order) and order[0] != socket,
            enough=not order,
            target=target,
            lift=target is not None and self._pool.lifted(samples, position, target),
        )

    def _known(self, samples: Captures) -> ParameterCovariance:
        state = self._first
        if self._sockets > 1:
            state = self._pool.with_distance(state, samples)
        for sample in samples:
            state = state.with_samples(np.array([sample.position]), sample.socket)
        return state

    def _order(self, samples: Captures, socket: int) -> list[int]:
        """Return the sockets of the samples to come: the rest in this one, then in the others."""
        counts = self._counts(samples)
        sockets = [k for k in range(self._sockets) if k != socket]
        return list(
            chain(*([k] * (self._target - counts[k]) for k in (socket, *sockets)))
        )

    def closing(self, samples: Captures) -> tuple[str, ...]:
        """Return nothing: the verdict comes at the end."""
        return ()
