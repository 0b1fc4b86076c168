"""Covariances of who knows how simulated arms differ: no estimate by the same samples is closer.

Spreads of origins, sizes of effects and noise are known as arms are drawn by them; the arm is not.
Errors are linear about the true arm.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mukca.recorder import Placement
from mukca.solver.design import ParameterCovariance, Workspace
from mukca.solver.identification.data import CALIPER_DEVIATION, STANDARD_LOAD, Samples
from mukca.solver.identification.effects import EFFECTS, JOINT_OFFSET
from mukca.solver.identification.model import Noise, extend
from mukca.solver.identification.robot import Robot, all_parameters
from mukca.tools.simulation import Imperfection

from . import SIZES, TRANSLATION, TURN

GAUSSIAN, ANYWHERE, LOST = 1e9, 1.0, 0.2
"""nu of Gaussian noise; standard deviations of a new tool's place [m] and of lost zeros [rad]."""


class AtBest:
    """Covariance of an arm's unknowns after its calibration."""

    def __init__(
        self, nominal: Robot, arm: Robot, how: Imperfection, train: Sequence[Placement]
    ) -> None:
        parameters = list(all_parameters(nominal))
        model = extend(nominal, parameters, (JOINT_OFFSET.name, *SIZES))
        off = model.ball.parameters_at(arm.origins) - model.ball.nominal
        zeros = np.zeros(len(arm.joint_names))
        x = np.concatenate([off, zeros, *how.deflection.coefficients])
        widths = [TRANSLATION if p.unit == "m" else TURN for p in parameters]
        for name, place in zip(SIZES, model.slices[1:], strict=True):
            low, high = SIZES[name]
            even = (
                high - low
            ) ** 2 / 12  # a coefficient's variance, or that of its size
            width = even if EFFECTS[name].non_negative else even + (low + high) ** 2 / 4
            widths += [width**0.5] * (place.stop - place.start)
        S = np.diag(
            np.concatenate([widths[: len(off)], zeros, widths[len(off) :]]) ** 2
        )
        larger = S @ model.by_scale()  # arms are drawn with the nominal size
        S -= np.outer(larger, larger) / (model.by_scale() @ larger)
        self.ball = [i for i, p in enumerate(parameters) if p.of_ball and p.unit == "m"]
        self.zeros = model.slices[0]
        S[self.ball, self.ball] += ANYWHERE**2
        known = ParameterCovariance(model, x, Noise(how.noise, 0.0, GAUSSIAN), S)
        for placement in train:
            known = _after(known, placement)
        self.known = known

    def off_zeros(self, since: Placement, *, exact: bool = False) -> np.ndarray:
        """Return standard deviations of the zeros but the first and last, all lost at once [rad].

        With ``exact`` all else of the arm is known.
        """
        known, own = (
            self._held(exact),
            np.arange(self.zeros.start + 1, self.zeros.stop - 1),
        )
        known.covariance[own, own] += LOST**2
        slopes = np.eye(known.model.size)[own]
        return _after(known, since).deviations(Workspace(slopes, np.zeros(len(own))))

    def scatter(
        self, touches: Placement, noise: float, q: np.ndarray, *, exact: bool = False
    ) -> float:
        """Return a new tool's scatter about points elsewhere, at q of shape (K, N, m) [m]."""
        known = self._held(exact)
        known.covariance[self.ball, self.ball] += ANYWHERE**2
        known = _after(replace(known, noise=Noise(noise, 0.0, GAUSSIAN)), touches)
        rows = q.reshape(-1, q.shape[-1])
        slopes = known.linearise(_loaded(known, rows))[1]
        slopes = slopes.reshape(*q.shape[:2], 3, -1)
        apart = slopes - slopes.mean(axis=1, keepdims=True)
        squares = np.einsum("knai,ij,knaj->kn", apart, known.covariance, apart)
        return float(np.mean(squares)) ** 0.5

    def with_ball(self, place: np.ndarray) -> None:
        """Put a tool of another length on the flange, so much beyond the ball [m]."""
        self.known.x[self.ball] += place

    def _held(self, exact: bool) -> ParameterCovariance:
        return replace(
            self.known, covariance=(0.0 if exact else 1.0) * self.known.covariance
        )


def _after(known: ParameterCovariance, placement: Placement) -> ParameterCovariance:
    """Return what is known of the arm after samples at a new placement."""
    size, centres = known.model.size, list[np.ndarray]()
    for k in range(int(placement.sockets.max()) + 1):
        q = placement.positions[placement.sockets == k]
        samples = _loaded(known, q)
        known = known.with_sockets(1).with_samples(samples, k)
        centres.append(known.linearise(samples)[0].mean(axis=0))
    if len(centres) == 2:
        away = (centres[1] - centres[0]) / np.linalg.norm(centres[1] - centres[0])
        known = known.with_lengths({0: -away, 1: away}, CALIPER_DEVIATION)
    return replace(known, covariance=known.covariance[:size, :size].copy())


def _loaded(known: ParameterCovariance, q: np.ndarray) -> Samples:
    return STANDARD_LOAD.at(known.model.robot, q)
