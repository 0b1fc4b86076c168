"""The table of explanations, by their keys in ``causes.json``, which has their words."""

from functools import partial

import numpy as np

from . import arm, ball, base, mounting, recording
from .kinds import Kind, NoisePrior, kind_of

of_zero = partial(arm.of_joints, turns=np.ones_like, widths=arm.ZEROS)
"""The block of joints that are off throughout."""
KINDS = (
    kind_of("sound"),
    kind_of("distance", base.of_distance, base.share),
    kind_of("scaled", base.of_model, base.share),
    kind_of("one_socket", base.of_one_socket),
    kind_of("known", base.of_known),
    kind_of(
        "length",
        partial(arm.of_origin, unit="m", widths=arm.LENGTHS),
        partial(arm.error, unit="m"),
    ),
    kind_of(
        "angle",
        partial(arm.of_origin, unit="rad", widths=arm.ANGLES),
        partial(arm.error, unit="rad"),
    ),
    kind_of("version", arm.of_version),
    kind_of("other_arm", arm.of_other_arm),
    kind_of("zero", of_zero, arm.offset, turns=np.ones_like),
    kind_of("zero_lost", arm.of_lost_zero, arm.offset),
    kind_of(
        "gain",
        partial(arm.of_joints, turns=np.positive, widths=arm.GAINS),
        arm.excess,
        turns=np.positive,
    ),
    kind_of("uneven", arm.of_uneven),
    kind_of("soft_base", arm.of_soft_base),
    kind_of("commands", arm.of_commands, arm.sag),
    kind_of("lag", arm.of_lag, arm.excess),
    kind_of("base_moved", base.moved, base.moved_by),
    kind_of("base_tipped", base.tipped),
    kind_of("base_between", base.between),
    kind_of("drift", base.drifting, base.drift_by),
    kind_of("ball_sample", ball.one_sample, separate=True),
    kind_of("ball_bent", ball.bent),
    kind_of("ball_loose", noise=lambda _: NoisePrior(ball.LOOSE, 0.7)),
    kind_of("ball_loose_here", ball.loose_here),
    kind_of("socket", ball.mixed_up, sentence=ball.lie_elsewhere),
    kind_of(
        "mounting",
        mounting.mounted,
        sentence=mounting.stands,
        scene_after=mounting.remounted,
    ),
    kind_of("copies", recording.copies),
    kind_of("repeated", recording.repeated, separate=True),
    kind_of("quantised", recording.quantised, noise=recording.of_steps),
    kind_of("pushed", recording.pushed, noise=lambda _: NoisePrior(1.2e-3, 0.7)),
    kind_of("pushed_here", recording.pushed_here),
    kind_of("unexplained", noise=lambda _: NoisePrior(1e-2, 2.0)),
)
ONLY_SOUND = KINDS[:1]
SIZE_BY_MODEL = frozenset(kind.code for kind in KINDS if kind.of_size == "model")
"""Codes of those by which the model's numbers explain the size of the arm."""
SIZE_BY_DISTANCE = frozenset(kind.name for kind in KINDS if kind.of_size == "distance")
"""Names of those by which a distance does."""
SLIPS = Kind(
    "slips",
    0.05,
    "{joint} reads otherwise again and again",
    "mend the joint",
    "move the joint to its zero mark twice, and read what it says",
    "slips",
    arm.of_slips,
    arm.slipped,
)
CURABLE = (*(kind for kind in KINDS if kind.curable), SLIPS)
"""Those that a hand can cure while it records."""
_SIMULATED = (
    *(kind for kind in KINDS if kind.unit is not None),
    kind_of(
        "base_moved",
        base.turned,
        base.moved_by,
        fault="turn",
        unit="deg",
    ),
)
FLAWS = {
    word: tuple(kind for kind in _SIMULATED if word in (kind.fault, kind.name))
    for word in sorted({kind.fault or kind.name for kind in _SIMULATED})
}
"""Those that a simulated arm can have, by the word of its fault."""
