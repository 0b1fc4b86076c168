"""The priors of a model's unknowns at the start of the estimation, group by group."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..data import Observations, Pose, hand_eye, tip_shifts
from ..effects import Effect
from ..robot import BallModel, Origin, Parameter
from .difference import tips_of
from .extended_model import ExtendedModel
from .prior_group import SMALLEST_WIDTH, GivenPrior, PriorGroup

BALL_WIDTH = 0.1
"""Width of the prior of the ball's place on the flange [m]: so wide that the data decide alone."""
FARTHEST, MOST_OFF = 3.0, 0.1
"""A tool is nearer to the flange, and poses nearer to the nominal robot [m], if units are right."""
GEOMETRY_WIDTHS = {"translation": 1e-3, "rotation": 5e-3}
"""Widths of lengths [m] and angles [rad] at the start of the estimation."""
COMMON_SCALE = 2e-3
"""Standard deviation of the whole robot's scale, 0.2 %. A caliper on a base of 50 mm gives the
scale to 0.06 %, so measured distances decide; where an arm is noisy, the URDF's scale holds."""
LEAST_TURN = 1e-6
"""Turn per unit of a coefficient in samples that hardly show it."""


def prior_groups(model: ExtendedModel, data: Observations) -> tuple[PriorGroup, ...]:
    """Return the groups of a model's unknowns, at the widths from which the estimation starts.

    The torques of the data tell the size of a plausible compliance.
    """
    groups = _geometry_groups(model, data)
    for effect, place in zip(model.effects, model.slices, strict=True):
        members = np.arange(model.size)[place]
        turns = effect.turns(data)
        if effect.rare:
            groups += _rare_groups(model, effect, members, turns)
        else:
            groups.append(_effect_group(effect, members, turns))
    if model.given is None:
        return tuple(groups)
    return _with_given(model, model.given, groups)


def _geometry_groups(model: ExtendedModel, data: Observations) -> list[PriorGroup]:
    """Return the groups of lengths, of angles, and of the ball's place."""
    kinds = np.array([_kind(parameter) for parameter in model.parameters])
    lengths = np.flatnonzero(kinds == "translation")
    angles = np.flatnonzero(kinds == "rotation")
    ball = np.flatnonzero(kinds == "ball")
    typical: dict[str, float] = {}
    for effect in model.effects:
        typical.update(effect.geometry_widths)
    widths = GEOMETRY_WIDTHS | typical
    by_scale = COMMON_SCALE * model.ball.nominal[lengths]
    place = _ball_by_instrument(model, data)
    expected = None
    if place is not None:
        expected = place[ball]
    groups = [
        PriorGroup(
            "translation",
            "m",
            lengths,
            widths["translation"],
            common=by_scale,
        ),
        PriorGroup(
            "rotation",
            "rad",
            angles,
            widths["rotation"],
        ),
        PriorGroup(
            "ball",
            "m, rad",
            ball,
            BALL_WIDTH,
            learned=False,
            expected=expected,
        ),
    ]
    return [
        replace(group, typical=typical.get(group.name, 0.0))
        for group in groups
        if len(group.members)
    ]


def _kind(parameter: Parameter) -> str:
    """Return the name of a parameter's group."""
    if parameter.of_ball:
        return "ball"
    return "translation" if parameter.unit == "m" else "rotation"


def _rare_groups(
    model: ExtendedModel,
    effect: Effect,
    members: np.ndarray,
    turns: np.ndarray,
) -> list[PriorGroup]:
    """Return a group for each coefficient, which is held where recordings show nothing of it."""
    groups: list[PriorGroup] = []
    for k, member in enumerate(members.tolist()):
        group = _effect_group(effect, members[[k]], turns[:, k])
        group = replace(group, name=model.names[member])
        if group.name not in model.seen:
            group = replace(group, width=SMALLEST_WIDTH, learned=False)
        groups.append(group)
    return groups


def groups_at(
    model: ExtendedModel,
    data: Observations,
    widths: Mapping[str, float],
) -> tuple[PriorGroup, ...]:
    """Return the groups that have a width, at these widths."""
    groups: list[PriorGroup] = []
    for group in prior_groups(model, data):
        if group.name in widths:
            width = widths[group.name]
            groups.append(replace(group, width=width))
    return tuple(groups)


def _ball_by_instrument(model: ExtendedModel, data: Observations) -> np.ndarray | None:
    """Return the ball's place and turn on the flange by what an instrument measured, from nominal.

    Frame and ball alone are fitted to the nominal robot, from any start: with all lengths and
    angles free at once, a ball that is 90 mm off lets the fit diverge.
    """
    if data.turned.any():
        return _from_nominal(model.ball, _tool_by_poses(model.ball, data))
    if data.seated.any() or not len(data.q):
        return None
    shifts, off = tip_shifts(tips_of(model.ball, data))
    shift = shifts.mean(axis=0)
    if np.linalg.norm(shift) > FARTHEST or off > MOST_OFF:
        return None
    return _from_nominal(model.ball, Pose(np.eye(3), shift))


def _from_nominal(ball: BallModel, tool: Pose) -> np.ndarray:
    """Return the changes of all parameters that move the ball by a pose in its own frame."""
    origins = ball.origins(ball.nominal)
    nominal = Pose.of(Origin.of(origins[-1]))
    of_ball = (nominal @ tool).origin
    origins[-1] = *of_ball.xyz, *of_ball.rpy
    return ball.parameters_at(origins) - ball.nominal


def _tool_by_poses(ball: BallModel, data: Observations) -> Pose:
    """Return the ball's place (unless it cannot be) and turn in its own frame by measured poses."""
    counts = np.bincount(data.turned_in[data.turned])
    frame = counts.argmax()
    turned = np.flatnonzero(data.turned_in == frame)
    balls = np.flatnonzero(data.measured_in == frame)
    placements = data.recorded_at[turned]
    of_placements = np.isin(data.recorded_at[balls], placements)
    points = data.points[balls[of_placements]]
    q = data.q[turned]
    R = ball.rotations(ball.nominal, q).points
    p = ball.points(ball.nominal, q)
    file = str(data.wheres[turned[0]]).rpartition(":")[0]
    calibrated = hand_eye(
        R,
        p,
        data.rotations[turned],
        points,
        file,
    )
    tool = calibrated.tool
    length = float(np.linalg.norm(tool.translation))
    if length > FARTHEST or calibrated.distance > MOST_OFF:
        return replace(tool, translation=np.zeros(3))
    return tool


def _with_given(
    model: ExtendedModel,
    prior: GivenPrior,
    groups: list[PriorGroup],
) -> tuple[PriorGroup, ...]:
    """Return the groups, with what is given of some unknowns in place of their own priors."""
    marginal = prior.of(model.names)
    members = [model.names.index(name) for name in marginal.names]
    remainder = [_without_members(group, members) for group in groups]
    remainder = [group for group in remainder if len(group.members)]
    if not members:
        return tuple(remainder)
    given = PriorGroup(
        "given",
        "",
        np.array(members),
        1.0,
        learned=False,
        expected=marginal.mean,
        shape=marginal.covariance,
    )
    return (*remainder, given)


def _without_members(group: PriorGroup, members: Sequence[int]) -> PriorGroup:
    """Return the prior of a group's other members."""
    mask = ~np.isin(group.members, members)
    common, expected = group.common, group.expected
    if common is not None:
        common = common[mask]
    if expected is not None:
        expected = expected[mask]
    return replace(
        group,
        members=group.members[mask],
        common=common,
        expected=expected,
    )


def _effect_group(
    effect: Effect,
    members: np.ndarray,
    turns: np.ndarray,
) -> PriorGroup:
    """Return the prior of an effect's coefficients: as wide as they usually turn the joints."""
    width = effect.typical_shift / max(_root_mean_square(turns), LEAST_TURN)
    group = PriorGroup(
        effect.name,
        effect.unit,
        members,
        width,
        typical=width if effect.learned else 0.0,
        learned=effect.learned,
        optional=True,
        non_negative=effect.non_negative,
        follows_noise=effect.joint_noise is not None,
    )
    return group.following(effect.typical_shift) if group.follows_noise else group


def _root_mean_square(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
