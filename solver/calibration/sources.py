"""Sources of a calibration, as its document keeps them: samples with weights, files, versions."""

import hashlib
import platform
from collections.abc import Mapping, Sequence
from datetime import datetime, timezone
from itertools import chain

import casadi as ca
import numpy as np

from ..._version import __version__
from .. import results
from ..identification.data import Measurement, as_point
from ..identification.inference import Posterior
from ..identification.robot import Robot
from .problem import CalibrationProblem


def samples_of(
    problem: CalibrationProblem, posterior: Posterior | None
) -> tuple[results.PlacementSamples, ...]:
    """Return all samples; those trained on have robust weights, which come socket by socket."""
    of_balls = np.zeros(0)
    of_turns = np.zeros(0)
    if posterior is not None:
        turned = posterior.data.turned
        of_balls = posterior.weights[~turned]
        of_turns = posterior.weights[turned]
    folds = {
        id(sample): number
        for number, fold in enumerate(problem.folds)
        for measured in fold.left_out
        for sample in measured.placement.samples
    }
    rows: list[results.PlacementSamples] = []
    for role, measured in problem.placements:
        placement = measured.placement
        count = len(placement.samples)
        of_ball = of_turn = [None] * count
        if of_balls.size:
            of_ball = measured.as_recorded(of_balls[:count]).tolist()
            of_balls = of_balls[count:]
            if measured.has_orientations:
                of_turn = of_turns[:count].tolist()
                of_turns = of_turns[count:]
        row = results.PlacementSamples.filled(
            placement,
            role=role,
            distance=measured.distance,
            files=tuple(map(str, placement.files)),
            samples=_recorded_samples(measured, of_ball, of_turn, folds),
        )
        rows.append(row)
    return tuple(rows)


def _recorded_samples(
    measured: Measurement,
    of_ball: Sequence[float | None],
    of_turn: Sequence[float | None],
    folds: Mapping[int, int],
) -> tuple[results.RecordedSample, ...]:
    """Return the samples of a placement as recorded, with the weights of balls and of turns.

    ``folds`` has the number of the fold that leaves each out, by the identity of its sample.
    """
    recorded = measured.placement.samples
    shifts = [None] * len(recorded)
    if measured.moved is not None:
        shifts = list(map(as_point, measured.as_recorded(measured.moved)))
    samples: list[results.RecordedSample] = []
    for i, sample in enumerate(recorded):
        row = results.RecordedSample.filled(
            sample,
            weight=of_ball[i],
            orientation_weight=of_turn[i],
            moved=shifts[i],
            fold=folds.get(id(sample)),
        )
        samples.append(row)
    return tuple(samples)


def provenance_of(
    robot: Robot, measurements: Sequence[Measurement]
) -> results.Provenance:
    """Return what a result was made from and with: digests, versions, time."""
    files = chain.from_iterable(measured.placement.files for measured in measurements)
    return results.Provenance(
        created=datetime.now(timezone.utc).isoformat(timespec="seconds"),
        model_sha256=robot.sha256,
        data_sha256={
            str(file): hashlib.sha256(file.read_bytes()).hexdigest() for file in files
        },
        versions={
            "python": platform.python_version(),
            "mukca": __version__,
            "casadi": ca.__version__,
            "numpy": np.__version__,
        },
    )
