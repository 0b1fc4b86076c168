"""Study: how well the arm is known, and directions that the data do not identify, in words."""

from collections.abc import Sequence

import numpy as np

from ..identification.inference import Posterior
from ..results import Direction, Fit, Measurements, Study, Uncertainty
from .predicted_errors import errors_near, workspace_errors
from .projections import basis_of, outside, unit
from .structural_changes import BASE, Change, structural_changes
from .uncertainty import UNDECIDED, correlations, observability_index

UNOBSERVABLE = (
    "the base frame: you measured distances between sockets, not their positions in the base frame",
    "the flange's orientation and the last joint's offset: another tool needs its own TCP "
    "calibration",
)
"""Unknowns that no recording of a ball in sockets can tell."""
BASE_TURNS = (
    "the base frame: it can still turn about the sockets that you measured. Measure three or more "
    "that are not on one line"
)
BASE_OF_POINTS = "the base frame: nobody measured where the instrument stands in it"
SCALE = "the scale of all lengths (a longer base, or known distances, would tell it)"


def weak_directions(posterior: Posterior) -> tuple[Direction, ...]:
    """Return what the data cannot tell, in words.

    First come directions that no ball can show in any chain of joints like this one; then those
    that these recordings do not show, named by the two parameters that take part most. With L L^T
    the prior covariance of the geometry, z = L^-1 x has the prior N(0, 1) and the posterior
    covariance L^-1 Sigma L^-T. Its deviation along a direction is 1 where the data tell nothing.
    """
    n = posterior.model.geometry
    prior = posterior.prior_covariance[:n, :n]
    L = np.linalg.cholesky(prior)
    whiten = np.linalg.inv(L)
    covariance = whiten @ posterior.covariance[:n, :n] @ whiten.T
    changes = [
        Change(text, unit(whiten @ vector))
        for text, vector in structural_changes(posterior)
    ]
    if posterior.data.anchored:
        changes = _without_turns_of_joints(changes, n)
    by_scale = L.T @ posterior.model.by_scale()[:n]
    if by_scale.any():
        changes.append(Change(SCALE, unit(by_scale)))
    Q = _basis(changes, n)
    changes += _undecided(posterior.model.names, covariance, L, Q)
    directions: dict[str, Direction] = {}
    for text, u in changes:
        deviation = float(u @ covariance @ u) ** 0.5
        if deviation > UNDECIDED:
            directions.setdefault(text, Direction(text, deviation))
    return tuple(directions.values())


def _undecided(
    names: Sequence[str],
    covariance: np.ndarray,
    L: np.ndarray,
    Q: np.ndarray,
) -> list[Change]:
    """Return the directions beside a basis Q that these recordings do not show, the widest first.

    Args:
        names: Of all unknowns, the geometry's n first.
        covariance: Of the whitened geometry, shape (n, n).
        L: Root of the geometry's prior covariance, shape (n, n).
        Q: Shape (n, r).
    """
    remaining = outside(outside(covariance, Q).T, Q)
    values, vectors = np.linalg.eigh(remaining)
    widths = np.linalg.norm(L, axis=1)
    changes: list[Change] = []
    undecided = np.flatnonzero(values > UNDECIDED**2)
    for k in undecided[::-1]:
        vector = vectors[:, k]
        shares = np.abs(L @ vector) / widths
        by_share: list[int] = np.argsort(-shares).tolist()
        pair = " against ".join(names[i] for i in by_share[:2])
        changes.append(Change(f"mainly {pair}", vector))
    return changes


def _without_turns_of_joints(
    changes: Sequence[Change],
    n: int,
) -> list[Change]:
    """Return changes, those of a base whose place is known without what other changes are as well.

    A turn of the base about joint 1 is one thing with joint 1's offset, which no ball shows.
    """
    Q = _basis([change for change in changes if change.text != BASE], n)
    return [
        Change(BASE, unit(outside(vector, Q))) if text == BASE else Change(text, vector)
        for text, vector in changes
    ]


def _basis(
    changes: Sequence[Change],
    n: int,
) -> np.ndarray:
    """Return an orthonormal basis of changes, shape (n, changes)."""
    vectors = [change.vector for change in changes]
    return basis_of(np.reshape(vectors, (-1, n)).T)


def unobservable(
    posterior: Posterior,
    weak: Sequence[Direction],
) -> tuple[str, ...]:
    """Return what no recording of this kind can determine, in words."""
    base, flange = UNOBSERVABLE
    if not posterior.data.anchored:
        has_sockets = bool(posterior.data.labels)
        return (base if has_sockets else BASE_OF_POINTS, flange)
    if any(direction.text == BASE for direction in weak):
        return (BASE_TURNS, flange)
    return (flange,)


def uncertainty(
    fit: Fit,
    measurements: Measurements,
) -> Uncertainty:
    """Return how well the arm is known, and what is not observable."""
    posterior = fit.posterior
    assert posterior is not None
    load = fit.calibrated.load
    exported = fit.calibrated.exported
    recorded = [m for _, m in measurements.placements]
    weak = weak_directions(posterior)
    return Uncertainty(
        weak_directions=weak,
        correlations=correlations(posterior),
        observability_index=observability_index(posterior),
        distance_deviation=workspace_errors(posterior, load, exported),
        near=errors_near(posterior, load, recorded, exported),
        cannot_see=unobservable(posterior, weak),
    )


UNCERTAINTY = Study("uncertainty", uncertainty)
