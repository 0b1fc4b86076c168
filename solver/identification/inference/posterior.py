"""The result of the default method: the most probable unknowns, and how well they are known."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..data import Observations, Pose, Samples, SourceKind
from ..model import (
    Deflection,
    Difference,
    ExtendedModel,
    Gaussian,
    Noise,
    Prediction,
    PriorGroup,
    check,
    prior_covariance,
    submatrix,
)
from .objective import Objective
from .state import State
from .width_averaging import over_widths


@dataclass(frozen=True, eq=False)
class Posterior:
    """The posterior of one robot's unknowns, as a Gaussian."""

    model: ExtendedModel
    data: Observations
    x: np.ndarray
    """The most probable unknowns: changes of the geometry from nominal, then the extensions'
    coefficients, shape (model.size,)."""
    centres: np.ndarray
    """Socket centres in the robot's base, shape (S, 3) [m]."""
    covariance: np.ndarray
    """Covariance of x and the centres, in the robot's base as well, (size + 3 S, size + 3 S)."""
    groups: tuple[PriorGroup, ...]
    """The priors, with the widths that the data gave them."""
    noises: Mapping[SourceKind, Noise]
    """Noise of each kind of samples."""
    points: np.ndarray
    """Ball centres of the samples, shape (N, 3) [m]."""
    weights: np.ndarray
    """Robust weight of each sample, shape (N,): near 1, and towards 0 far from its socket."""
    log_evidence: float
    """Logarithm of the evidence: how probable the data are under the model, averaged over all
    values that the prior allows for its unknowns."""
    iterates: tuple[np.ndarray, ...]
    """x after each iteration, the start first."""
    moved: np.ndarray | None = None
    """How far the place of each sample has moved, in the robot's base, shape (N, 3) [m]; None for
    places that stood still."""
    by_differences: np.ndarray | None = None
    """Derivatives of these by the unknowns of what differs, shape (N, 3, U)."""

    def __post_init__(self) -> None:
        check(self.covariance)

    @property
    def noise(self) -> Noise:
        """Noise of samples in sockets, or, where there is none, of measured balls."""
        return self.noises.get("sockets") or self.noises["points"]

    @property
    def active(self) -> tuple[str, ...]:
        """Names of its groups that are not held at zero, but curves."""
        return active_of(self.groups)

    @property
    def prior_covariance(self) -> np.ndarray:
        """Prior covariance of the model's unknowns but error curves, shape (scalars, scalars)."""
        groups = [group for group in self.groups if group.length is None]
        return prior_covariance(groups, self.model.scalars, widened=True)

    @property
    def values(self) -> np.ndarray:
        """The geometric parameters, shape (geometry,) [m, rad]."""
        return self.model.values(self.x)

    @property
    def deflection(self) -> Deflection:
        """The calibrated elasticity and transmission errors."""
        return self.model.deflection(self.x)

    @property
    def residuals(self) -> np.ndarray:
        """Predicted ball centre minus its socket's, of samples in sockets, shape (N, 3) [m]."""
        points = self.points
        if self.moved is not None:
            points = points - self.moved
        data = self.data
        return points[data.seated] - self.centres[data.seated_sockets]

    @property
    def of_unknowns(self) -> np.ndarray:
        """Covariance of x, shape (size, size)."""
        size = self.model.size
        return self.covariance[:size, :size]

    def linearise(self, samples: Samples) -> Prediction:
        """Return balls at x and their derivatives, see :meth:`.ExtendedModel.linearise`."""
        return self.model.linearise(self.x, samples)

    def predict(self, samples: Samples) -> np.ndarray:
        """Return the ball's centres, shape (N, 3) [m]."""
        return self.model.predict(self.x, samples)


def active_of(groups: Sequence[PriorGroup]) -> tuple[str, ...]:
    """Return the names of priors that do not hold their members at zero, but of curves."""
    return tuple(group.name for group in groups if group.width and group.length is None)


@dataclass(frozen=True, eq=False)
class FitPosterior:
    """The posterior of all unknowns of a fit: a robot, frames, sockets, and differences."""

    state: State
    """The most probable unknowns, or their mean, with the widths and noises that were found."""
    around: Gaussian
    """All unknowns but error curves, differences included, as changes from the state."""
    weights: np.ndarray
    """See :attr:`Posterior.weights`."""
    log_evidence: float
    """See :attr:`Posterior.log_evidence`."""
    iterates: Sequence[np.ndarray]
    """x of the robot and of differences after each iteration."""
    with_curves: np.ndarray | None = None
    """Covariance of all unknowns where there are error curves: they are too many for a root."""
    notes: tuple[str, ...] = ()
    """One line for each extension that was tried: kept or not, and the evidence."""
    at_usual_widths: tuple[np.ndarray, Gaussian] | None = None
    """The estimate, and the changes from it, that are still to be averaged over widths."""

    @cached_property
    def over_widths(self) -> "FitPosterior":
        """The posterior averaged over uncertain widths (A10), which models that lose do without."""
        if self.at_usual_widths is None:
            return self
        around, groups = over_widths(self.state, *self.at_usual_widths)
        state = replace(self.state, groups=groups)
        return replace(self, state=state, around=around, at_usual_widths=None)

    @cached_property
    def whole(self) -> np.ndarray:
        """Covariance of all unknowns, differences and error curves included."""
        covariance = self.with_curves
        if covariance is None:
            covariance = self.around.covariance
        check(covariance)
        return covariance

    @property
    def gaussian(self) -> Gaussian:
        """All unknowns as changes from the state, by the root of :attr:`whole`."""
        if self.with_curves is None:
            return self.around
        none = np.zeros(len(self.whole))
        return Gaussian.of(none, self.whole)

    @property
    def objective(self) -> Objective:
        """Function that was minimised."""
        return self.state.objective

    def unknowns_of(self, difference: Difference) -> np.ndarray:
        """Return the unknowns u of a difference that the fit has."""
        objective = self.objective
        k = objective.differences.index(difference)
        begin = objective.model.size + sum(objective.sizes[:k])
        return self.state.x[begin : begin + objective.sizes[k]]

    @property
    def model(self) -> ExtendedModel:
        """Model of the robot."""
        return self.objective.model

    @property
    def data(self) -> Observations:
        """All observations."""
        return self.objective.data

    @property
    def frames(self) -> dict[str, Pose]:
        """Pose of each frame in the base of the robot."""
        return dict(zip(self.data.frames, self.state.frames, strict=True))

    def frame_covariance(self, frame: str) -> np.ndarray:
        """Return the covariance of a frame's pose, its turn [rad] first, shape (6, 6)."""
        k = self.data.frames.index(frame)
        rows = self.objective.of_frame(k)
        return self.whole[rows, rows]

    @cached_property
    def covariance(self) -> np.ndarray:
        """Covariance of x of the robot, the frames, and the socket centres.

        Of a frame there is a turn about the base's axes [rad], then a shift [m].
        """
        size, x_size = self.model.size, self.objective.x_size
        indices = np.r_[:size, x_size : len(self.whole)]
        return submatrix(self.whole, indices)

    @property
    def active(self) -> tuple[str, ...]:
        """See :attr:`Posterior.active`."""
        return active_of(self.groups)

    @property
    def groups(self) -> tuple[PriorGroup, ...]:
        """The priors of the robot alone."""
        groups = self.state.groups
        return tuple(group for group in groups if group.members[0] < self.model.size)

    def changed(self, around: Gaussian) -> "FitPosterior":
        """Return the result with another Gaussian of all unknowns, as changes from the state."""
        state = self.state.changed(around.mean).linearised()
        return replace(
            self,
            state=state,
            around=replace(around, mean=np.zeros_like(around.mean)),
            iterates=[*self.iterates, state.x],
            with_curves=None,
        )

    @cached_property
    def arm(self) -> Posterior:
        """The robot alone."""
        objective, state, size = self.objective, self.state, self.model.size
        rows = np.r_[:size, objective.dense : objective.size]
        by_differences = moved = None
        if objective.differences:
            of_differences = slice(size, objective.x_size)
            A = state.linearised().linear.by_unknowns
            by_differences = -A[:, :, of_differences]
            moved = by_differences @ state.x[of_differences]
        return Posterior(
            model=self.model,
            data=self.data,
            x=state.x[:size],
            centres=state.centres,
            covariance=submatrix(self.whole, rows),
            groups=self.groups,
            noises=dict(zip(self.data.source_kinds, state.noises, strict=True)),
            points=state.linear.points,
            weights=self.weights,
            log_evidence=self.log_evidence,
            iterates=tuple(x[:size] for x in self.iterates),
            moved=moved,
            by_differences=by_differences,
        )
