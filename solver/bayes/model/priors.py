"""The priors of a model's unknowns at the start of the estimation, group by group.

The unknowns x_g of a group g, for instance all angles of the joint origins, have a Gaussian prior
of one width s_g, which the evidence sets (see docs/model.md). The lengths may also all grow or
shrink together, by the same share, which is the scale of the whole robot; that costs much less than
so many separate changes.
"""

from dataclasses import replace

import numpy as np

from ...data import Observations
from .extended_model import ExtendedModel
from .prior_group import PriorGroup

BALL_WIDTH = 0.1
"""Width of the prior of the ball's place on the flange [m]: so wide that the data decide alone."""
TRANSLATION_WIDTH, ROTATION_WIDTH = 1e-3, 5e-3
"""Widths of lengths [m] and angles [rad] at the start of the estimation."""
COMMON_SCALE = 2e-3
"""Standard deviation of the whole robot's scale, 0.2 %. A caliper on a base of 50 mm gives the
scale to 0.06 %, so measured distances decide; where an arm is noisy, the URDF's scale holds."""


def prior_groups(model: ExtendedModel, data: Observations) -> tuple[PriorGroup, ...]:
    """Return the groups of a model's unknowns, at the widths from which the estimation starts.

    Args:
        model: The model.
        data: What was measured: the torques tell the size of a plausible compliance.
    """
    kinds = np.array(
        [
            "ball" if p.of_ball else "translation" if p.unit == "m" else "rotation"
            for p in model.parameters
        ]
    )
    lengths, angles, ball = (
        np.flatnonzero(kinds == kind) for kind in ("translation", "rotation", "ball")
    )
    by_scale = COMMON_SCALE * model.ball.nominal[lengths]
    geometry = [
        PriorGroup("translation", "m", lengths, TRANSLATION_WIDTH, common=by_scale),
        PriorGroup("rotation", "rad", angles, ROTATION_WIDTH),
        PriorGroup("ball", "m, rad", ball, BALL_WIDTH, learned=False),
    ]
    groups = [group for group in geometry if len(group.members)]
    for effect, own in zip(model.effects, model.slices, strict=True):
        widths = effect.geometry_widths
        groups = [
            replace(g, width=widths[g.name], typical=widths[g.name]) if g.name in widths else g
            for g in groups
        ]
        of_type = model.of_type.get(effect.name)
        members = np.arange(own.start, own.stop, dtype=np.int64)
        groups.append(effect.prior(members, data.positions, data.torques, of_type))
    return tuple(groups)
