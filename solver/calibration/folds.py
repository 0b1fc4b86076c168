"""Folds of a calibration: whole fits that each leave out a place, or a region of joint space.

Checks of the recordings are made once, before. Each fold chooses its effects anew.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...errors import MukcaError
from ..identification import Prior, Progress
from ..identification.data import Measurement
from ..results import Fit, Fold, PlacementErrors
from ..tables import in_placements
from .errors import compared_models, frames_by, placement_errors
from .fit import Methods, fit_robot
from .fold_groups import Group, groups_of
from .problem import CalibrationProblem
from .refitted_ball import ball_refitted


def with_folds(
    problem: CalibrationProblem,
    fit: Fit,
    methods: Methods,
    prior: Prior = None,
    progress: Progress = lambda _: None,
) -> CalibrationProblem:
    """Return a problem with a fold for each group of samples that its fit is proven by.

    A fold that cannot be fitted is left out, with a warning. Where placements are held out, they
    prove the fit, and there are no folds.
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
        try:
            folds.append(_fold(problem, group, methods, prior))
        except (MukcaError, np.linalg.LinAlgError) as error:
            warnings.append(
                f"{names}: no fit to all others, so no proof there: {error}"
            )
    return replace(problem, folds=tuple(folds), warnings=tuple(warnings))


def _fold(
    problem: CalibrationProblem, group: Group, methods: Methods, prior: Prior
) -> Fold:
    """Return the fit to all that a group does not hold."""
    trained: list[Measurement] = []
    left_out: list[Measurement] = []
    for i, measured in enumerate(problem.measurements):
        ranks = group.get(i, np.arange(0))
        remaining = np.setdiff1d(np.arange(len(measured.positions)), ranks)
        if len(ranks):
            left_out.append(measured.only(ranks) if len(remaining) else measured)
        if len(remaining):
            trained.append(measured.only(remaining) if len(ranks) else measured)
    names = {m.name for m in trained}
    options = problem.options
    located = options.located
    settings = replace(
        options,
        known=[
            length
            for length in options.distances
            if {length.first[0], length.second[0]} <= names
        ],
        sockets_at=in_placements(
            located, sorted(names), [socket.socket[0] for socket in located]
        ),
    )
    part = replace(problem, measurements=tuple(trained))
    fit = fit_robot(part, settings, methods, prior=prior, require_scale=False)
    return Fold(fit, ball_refitted(part), tuple(trained), tuple(left_out))


def left_out_errors(folds: Sequence[Fold]) -> list[PlacementErrors]:
    """Return the errors of what each fold leaves out, by its models."""
    rows: list[PlacementErrors] = []
    for fold in folds:
        models = compared_models(fold.fit.calibrated, fold.ball)
        frames = frames_by(models, fold.trained)
        for measured in fold.left_out:
            rows.append(placement_errors(models, "left_out", measured, frames))
    return rows
