"""Error curves of joints: the angles they were fitted to, and how far two of them agree [rad]."""

from collections.abc import Sequence

import numpy as np

from ..identification.effects import KNOTS, SPACING
from .estimates import ErrorCurves
from .files import Document


class CurveAgreement(Document):
    """Agreement of two error curves of one joint, where both are known."""

    joint: str
    correlation: float
    """Of their values, less constant and first harmonic, which geometry takes as well."""
    difference: float
    """Root mean square of their difference, likewise [rad]."""
    expected: float
    """Root mean square of what their own uncertainty would make it [rad]."""


KNOWN = 0.7
"""A curve is known where its deviation is less than this share of its amplitude."""
LEAST_OVERLAP = 20
"""Knots at which both curves are known, for a word on them."""


def agreement(
    a: ErrorCurves | None, b: ErrorCurves | None
) -> tuple[CurveAgreement, ...]:
    """Return how far two calibrations' curves agree, for each joint that both know enough of."""
    if a is None or b is None:
        return ()
    by_joint = {curve.joint: curve for curve in b.joints}
    turn = SPACING * np.arange(KNOTS)
    gauge = np.stack([np.ones(KNOTS), np.sin(turn), np.cos(turn)], axis=1)
    agreements: list[CurveAgreement] = []
    for curve in a.joints:
        partner = by_joint.get(curve.joint)
        if partner is None:
            continue
        deviations = np.array([curve.deviations, partner.deviations])
        determined = (
            deviations < KNOWN * np.array([[a.amplitude], [b.amplitude]])
        ).all(axis=0)
        if determined.sum() < LEAST_OVERLAP:
            continue
        values = np.array([curve.values, partner.values])[:, determined].T
        shared = gauge[determined]
        values = values - shared @ np.linalg.lstsq(shared, values, rcond=None)[0]
        lengths = np.linalg.norm(values, axis=0).clip(min=1e-12)
        agreements.append(
            CurveAgreement(
                joint=curve.joint,
                correlation=float(values[:, 0] @ values[:, 1] / lengths.prod()),
                difference=float(np.mean((values[:, 0] - values[:, 1]) ** 2) ** 0.5),
                expected=float(np.mean(2 * deviations[:, determined] ** 2) ** 0.5),
            )
        )
    return tuple(agreements)


def agreement_words(agreements: Sequence[CurveAgreement]) -> str:
    """Return for people how far curves agree; empty where none can be compared."""
    if not agreements:
        return ""
    low = min(a.correlation for a in agreements)
    high = max(a.correlation for a in agreements)
    difference = 1e3 * float(np.mean([a.difference**2 for a in agreements]) ** 0.5)
    expected = 1e3 * float(np.mean([a.expected**2 for a in agreements]) ** 0.5)
    same = "the same" if difference < 2 * expected else "not the same"
    return (
        f"Error curves of {len(agreements)} joints: "
        f"correlation {low:.2f} to {high:.2f}; "
        f"they differ by {difference:.3f} mrad, "
        f"where their uncertainty alone makes {expected:.3f}: {same}."
    )


def sampled_ranges(angles: np.ndarray, reach: float) -> tuple[tuple[float, float], ...]:
    """Return the ranges of a turn that are within reach of angles, shape (N,) [rad]."""
    knots = SPACING * np.arange(KNOTS)
    distance = np.abs((knots[:, None] - angles + np.pi) % (2 * np.pi) - np.pi)
    covered = np.concatenate([[False], (distance <= reach).any(axis=1), [False]])
    ends = np.flatnonzero(np.diff(covered.astype(int))).reshape(-1, 2)
    return tuple(
        (float(SPACING * a), float(SPACING * (b - 1))) for a, b in ends.tolist()
    )


def beyond_words(
    curves: ErrorCurves | None,
    joint_names: Sequence[str],
    positions: np.ndarray,
    where: str,
) -> list[str]:
    """Return lines where samples, (N, m) [rad], are beyond what the curves were fitted to."""
    shares: dict[str, float] = {}
    for curve in () if curves is None else curves.joints:
        angles = positions[:, joint_names.index(curve.joint)] % (2 * np.pi)
        inside = np.zeros(len(angles), dtype=bool)
        for low, high in curve.sampled:
            inside |= (angles >= low - SPACING) & (angles <= high + SPACING)
        if not inside.all():
            shares[curve.joint] = float(np.mean(~inside))
    if not shares:
        return []
    joints = ", ".join(
        f"{name} ({100 * share:.0f} %)" for name, share in shares.items()
    )
    return [
        f"{where}: samples at angles that the error curves were not fitted to: {joints}; there a "
        "curve goes to zero, and predicted errors grow"
    ]
