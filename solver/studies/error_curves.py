"""Study: the error curves of the joints, at their knots."""

import numpy as np

from ..results import (
    ErrorCurves,
    Fit,
    JointCurve,
    Measurements,
    Study,
    beyond_words,
    sampled_ranges,
)
from .projections import rounded, variances_of


def error_curves(
    fit: Fit,
    _: Measurements,
) -> ErrorCurves | None:
    """Return the error curves of the joints that turn, with their deviations; None for none.

    At a knot a cubic B-spline is (c_(k-1) + 4 c_k + c_(k+1)) / 6 of its coefficients c, that go
    round; with B that matrix, the curve is B c, and its covariance B Sigma B^T.
    """
    posterior = fit.posterior
    assert posterior is not None
    coefficients = posterior.deflection.curves
    if coefficients is None:
        return None
    model = posterior.model
    group = posterior.groups[-1]
    assert group.length is not None
    knots, m = coefficients.shape
    members = model.slices[-1]
    Sigma = posterior.covariance[members, members]
    identity = np.eye(knots)
    neighbours = np.roll(identity, 1, axis=0) + np.roll(identity, -1, axis=0)
    B = (neighbours + 4 * identity) / 6
    joints: list[JointCurve] = []
    for k, joint in enumerate(model.robot.actuated):
        if joint.type == "prismatic":
            continue
        variances = variances_of(B, Sigma[k::m, k::m])
        positions = posterior.data.q[:, k]
        curve = JointCurve(
            joint=joint.name,
            values=rounded(B @ coefficients[:, k], 9),
            deviations=rounded(np.sqrt(variances.clip(min=0)), 9),
            sampled=sampled_ranges(positions, group.length),
        )
        joints.append(curve)
    return ErrorCurves(amplitude=group.width, length=group.length, joints=tuple(joints))


def warnings(
    _: Fit,
    measurements: Measurements,
    words: tuple[str, ...],
    curves: ErrorCurves | None,
) -> tuple[str, ...]:
    """Return warnings, with those of held-out placements where a curve is not known."""
    names = measurements.robot.joint_names
    for m in measurements.test:
        words += tuple(beyond_words(curves, names, m.positions, m.name))
    return words


CURVES = Study("curves", error_curves)
WARNINGS = Study("warnings", warnings, ("warnings", "curves"))
