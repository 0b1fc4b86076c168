"""Error curves of joints: the angles they were fitted to, and how far two of them agree [rad]."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

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
    turn = SPACING * np.arange(KNOTS)
    gauge = np.stack([np.ones(KNOTS), np.sin(turn), np.cos(turn)], axis=1)
    amplitudes = np.array([[a.amplitude], [b.amplitude]])
    by_joint = {curve.joint: curve for curve in b.joints}
    agreements: list[CurveAgreement] = []
    for curve in a.joints:
        pair = [curve, by_joint.get(curve.joint, curve)]
        deviations = np.array([one.deviations for one in pair])
        known = np.all(deviations < KNOWN * amplitudes, axis=0)
        if curve.joint not in by_joint or known.sum() < LEAST_OVERLAP:
            continue
        values = np.array([one.values for one in pair])[:, known].T
        shared = gauge[known]
        values = values - shared @ np.linalg.lstsq(shared, values, rcond=None)[0]
        lengths = np.linalg.norm(values, axis=0).clip(min=1e-12)
        agreements.append(
            CurveAgreement(
                joint=curve.joint,
                correlation=float(values[:, 0] @ values[:, 1] / lengths.prod()),
                difference=rms(np.diff(values)),
                expected=rms(2**0.5 * deviations[:, known]),
            )
        )
    return tuple(agreements)


def rms(values: ArrayLike) -> float:
    """Return the root mean square of some values."""
    return float(np.mean(np.square(values)) ** 0.5)


def agreement_words(agreements: Sequence[CurveAgreement]) -> str:
    """Return for people how far curves agree; empty where none can be compared."""
    if not agreements:
        return ""
    correlations = [a.correlation for a in agreements]
    difference = 1e3 * rms([a.difference for a in agreements])
    expected = 1e3 * rms([a.expected for a in agreements])
    same = "the same" if difference < 2 * expected else "not the same"
    return (
        f"Error curves of {len(agreements)} joints: "
        f"correlation {min(correlations):.2f} to {max(correlations):.2f}; "
        f"they differ by {difference:.3f} mrad, "
        f"where their uncertainty alone makes {expected:.3f}: {same}."
    )


def sampled_ranges(angles: np.ndarray, reach: float) -> tuple[tuple[float, float], ...]:
    """Return the ranges of a turn that are within reach of angles, shape (N,) [rad]."""
    knots = SPACING * np.arange(KNOTS)
    distance = np.abs((knots[:, None] - angles + np.pi) % (2 * np.pi) - np.pi)
    covered = np.pad((distance <= reach).any(axis=1), 1)
    ends = np.flatnonzero(np.diff(covered)).reshape(-1, 2)
    return tuple((float(SPACING * a), float(SPACING * (b - 1))) for a, b in ends)


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
    joints = ", ".join(
        f"{name} ({100 * share:.0f} %)" for name, share in shares.items()
    )
    words = (
        f"{where}: samples at angles that the error curves were not fitted to: {joints}; there a "
        "curve goes to zero, and predicted errors grow"
    )
    return [words] if shares else []
