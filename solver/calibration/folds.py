"""Folds of a calibration: whole fits that each leave out a place, or a region of joint space.

Checks of the recordings are made once, before. Each fold chooses its effects anew.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...errors import MukcaError
from ..identification import Prior, Progress
from ..identification.data import Measurement
from ..results import Fit, Fold
from ..tables import in_placements
from .fit import Methods, fit_robot
from .fold_groups import Group, groups_of
from .options import SolveOptions
from .problem import CalibrationProblem
from .refitted_ball import ball_refitted


def with_folds(
    problem: CalibrationProblem,
    fit: Fit,
    prior: Callable[[CalibrationProblem], Prior] = lambda _: None,
    progress: Progress = lambda _: None,
    *,
    methods: Methods,
) -> CalibrationProblem:
    """Return a problem with a fold for each group of samples that its fit is proven by.

    A fold that cannot be fitted is left out, with a warning. Where placements are held out, they
    prove the fit, and there are no folds.

    Args:
        problem: What the fit is to.
        fit: The fit to all.
        prior: What is known of the robot before; see :func:`.calibrate_robot`.
        progress: Called with a word for each fold.
        methods: Those of the fit.
    """
    if problem.test or problem.options.no_proof:
        return problem
    measurements = problem.measurements
    places = [fit.calibrated.predict(m).mean(axis=0) for m in measurements]
    folds: list[Fold] = []
    warnings = list(problem.warnings)
    for group in groups_of(measurements, places):
        names = ", ".join(measurements[i].name for i in group)
        progress(f"without {names}")
        part, left_out = _divided(problem, group)
        try:
            known = prior(part)
            arm = fit_robot(
                part, part.options, methods, prior=known, require_scale=False
            )
        except (MukcaError, np.linalg.LinAlgError) as error:
            words = "the fit to all others fails, so nothing proves it there"
            warnings.append(f"{names}: {words}: {error}")
            continue
        fold = Fold(arm, ball_refitted(part), tuple(part.measurements), left_out)
        folds.append(fold)
    return replace(problem, folds=tuple(folds), warnings=tuple(warnings))


def _divided(
    problem: CalibrationProblem, group: Group
) -> tuple[CalibrationProblem, tuple[Measurement, ...]]:
    """Return the problem without a group of samples, and these."""
    trained: list[Measurement] = []
    left_out: list[Measurement] = []
    for i, measured in enumerate(problem.measurements):
        ranks = group.get(i)
        if ranks is None:
            trained.append(measured)
            continue
        remaining = np.setdiff1d(np.arange(len(measured.positions)), ranks)
        if not remaining.size:
            left_out.append(measured)
            continue
        left_out.append(measured.only(ranks))
        trained.append(measured.only(remaining))
    names = {m.name for m in trained}
    options = _on_placements(problem.options, names)
    return replace(problem, measurements=tuple(trained), options=options), tuple(
        left_out
    )


def _on_placements(options: SolveOptions, names: set[str]) -> SolveOptions:
    """Return options with the known distances and coordinates between some placements."""
    known = [k for k in options.distances if {k.first[0], k.second[0]} <= names]
    located = options.located
    every_place = [socket.socket[0] for socket in located]
    sockets_at = in_placements(located, sorted(names), every_place)
    return replace(options, known=known, sockets_at=sockets_at)
