"""The priors of a model's unknowns at the start of the estimation, group by group."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...data import Observations, Pose, hand_eye
from ...robot import Origin
from .effects import Effect, Readings
from .extended_model import ExtendedModel
from .prior_group import SMALLEST_WIDTH, Expected, GivenPrior, PriorGroup

BALL_WIDTH = 0.1
"""Width of the prior of the ball's place on the flange [m]: so wide that the data decide alone."""
FARTHEST, MOST_OFF = 3.0, 0.1
"""A tool is nearer to the flange, and poses nearer to the nominal robot [m], if units are right."""
GEOMETRY_WIDTHS = {"translation": 1e-3, "rotation": 5e-3}
"""Widths of lengths [m] and angles [rad] at the start of the estimation."""
COMMON_SCALE = 2e-3
"""Standard deviation of the whole robot's scale, 0.2 %. A caliper on a base of 50 mm gives the
scale to 0.06 %, so measured distances decide; where an arm is noisy, the URDF's scale holds."""
SHARED_DEVIATION = 0.3
"""Typical difference between two arms of a type, as a share of an effect's size."""


def prior_groups(model: ExtendedModel, data: Observations) -> tuple[PriorGroup, ...]:
    """Return the groups of a model's unknowns, at the widths from which the estimation starts.

    The torques of the data tell the size of a plausible compliance.
    """
    kinds = [
        "ball" if p.of_ball else "translation" if p.unit == "m" else "rotation"
        for p in model.parameters
    ]
    lengths, angles, ball = (
        np.flatnonzero(np.array(kinds) == kind)
        for kind in ("translation", "rotation", "ball")
    )
    typical: dict[str, float] = {}
    for effect in model.effects:
        typical.update(effect.geometry_widths)
    widths = GEOMETRY_WIDTHS | typical
    by_scale = COMMON_SCALE * model.ball.nominal[lengths]
    place = _ball_by_poses(model, data)
    expected = None if place is None else (place[ball], 0 * place[ball])
    geometry = [
        PriorGroup("translation", "m", lengths, widths["translation"], common=by_scale),
        PriorGroup("rotation", "rad", angles, widths["rotation"]),
        PriorGroup(
            "ball", "m, rad", ball, BALL_WIDTH, learned=False, expected=expected
        ),
    ]
    groups = [
        replace(group, typical=typical.get(group.name, 0.0))
        for group in geometry
        if len(group.members)
    ]
    readings = Readings(data.positions, data.torques, data.clocks)
    for effect, place_of_effect in zip(model.effects, model.slices, strict=True):
        members = np.arange(model.size)[place_of_effect]
        shifts = effect.turns(readings)
        if not effect.rare:
            of_type = model.of_type.get(effect.name)
            groups.append(_prior_of_effect(effect, members, shifts, of_type))
            continue
        for k, member in enumerate(members.tolist()):
            group = _prior_of_effect(effect, members[k : k + 1], shifts[:, k])
            group = replace(group, name=model.names[member])
            held = replace(group, width=SMALLEST_WIDTH, learned=False)
            groups.append(group if group.name in model.seen else held)
    return (
        tuple(groups)
        if model.given is None
        else _with_given(model, model.given, groups)
    )


def groups_at(
    model: ExtendedModel, data: Observations, widths: Mapping[str, float]
) -> tuple[PriorGroup, ...]:
    """Return the groups that have a width, at these widths."""
    groups = [group for group in prior_groups(model, data) if group.name in widths]
    return tuple(replace(group, width=widths[group.name]) for group in groups)


def _ball_by_poses(model: ExtendedModel, data: Observations) -> np.ndarray | None:
    """Return the ball's place (unless it cannot be) and turn on the flange by measured poses."""
    if not data.turned.any():
        return None
    frame = np.bincount(data.turned_in[data.turned]).argmax()
    turned = np.flatnonzero(data.turned_in == frame)
    balls = np.flatnonzero(data.measured_in == frame)
    seats = balls[np.isin(data.recorded_at[balls], data.recorded_at[turned])]
    q, ball = data.positions[turned], model.ball
    R = ball.rotations(ball.nominal, q).points
    p = ball.points(ball.nominal, q)
    where = str(data.wheres[turned[0]]).rpartition(":")[0]
    calibrated = hand_eye(R, p, data.rotations[turned], data.points[seats], where)
    tool = calibrated.tool
    length = float(np.linalg.norm(tool.translation))
    if length > FARTHEST or calibrated.distance > MOST_OFF:
        tool = replace(tool, translation=np.zeros(3))
    origins = ball.origins(ball.nominal)
    of_ball = (Pose.of(Origin.of(origins[-1])) @ tool).origin
    origins[-1] = *of_ball.xyz, *of_ball.rpy
    return ball.parameters_at(origins) - ball.nominal


def _with_given(
    model: ExtendedModel, prior: GivenPrior, groups: list[PriorGroup]
) -> tuple[PriorGroup, ...]:
    """Return the groups, with what is given of some unknowns in place of their own priors."""
    marginal = prior.of(model.names)
    members = np.array(
        [model.names.index(name) for name in marginal.names], dtype=np.int64
    )
    remainder: list[PriorGroup] = []
    for group in groups:
        mask = ~np.isin(group.members, members)
        if mask.any():
            common = None if group.common is None else group.common[mask]
            expected = group.expected and (
                group.expected[0][mask],
                group.expected[1][mask],
            )
            free = group.members[mask]
            remainder.append(
                replace(group, members=free, common=common, expected=expected)
            )
    if not len(members):
        return tuple(remainder)
    expected = marginal.mean, 0 * marginal.mean
    shape = marginal.covariance
    given = PriorGroup(
        "given", "", members, 1.0, learned=False, expected=expected, shape=shape
    )
    return (*remainder, given)


def _prior_of_effect(
    effect: Effect,
    members: np.ndarray,
    shifts: np.ndarray,
    of_type: Expected | None = None,
) -> PriorGroup:
    """Return the prior of an effect's coefficients: as wide as they usually shift the samples."""
    width = effect.typical_shift / max(float(np.sqrt(np.mean(shifts**2))), 1e-6)
    if of_type is not None:
        width = SHARED_DEVIATION * float(np.sqrt(np.mean(of_type[0] ** 2)))
    group = PriorGroup(
        effect.name,
        effect.unit,
        members,
        width,
        typical=width if effect.learned else 0.0,
        learned=effect.learned,
        expected=of_type,
        optional=True,
        non_negative=effect.non_negative,
        follows_noise=effect.joint_noise is not None,
    )
    return group.following(effect.typical_shift) if group.follows_noise else group
