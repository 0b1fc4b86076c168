"""A ``calibration.json`` as it is read: its arrays fit each other, and what it names is there."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from ...errors import JOINT_POSITION, LENGTH
from ...recorder import LAST_SOCKET
from ..identification.effects import EFFECTS
from .calibration import FORMAT, CalibrationDocument, calibrated_robot, misfit
from .files import read, require_beside
from .placements import PlacementSamples, RecordedSample

DEGREES = 360
"""Values of an error curve, one a degree."""


def read_calibration(file: Path) -> CalibrationDocument:
    """Read a ``calibration.json``.

    Raises:
        DocumentError: A key is wrong or does not fit the others, or a file beside it is edited or
            of another calibration.
    """
    document = read(file, CalibrationDocument, FORMAT)
    require_beside(file, document.provenance.output_sha256)
    calibrated_robot(document, str(file))  # the model's joints are those of its URDF
    for key, words in _conflicts(document):
        raise misfit(str(file), key, words)
    return document


def _conflicts(document: CalibrationDocument) -> Iterator[tuple[str, str]]:
    """Yield the keys of a document that do not fit its other keys, and why."""
    names = document.model.joint_names
    yield from _of_deflection(document.deflection, names)
    count = len(document.parameters)
    for i, fold in enumerate(document.folds):
        for key, words in _of_deflection(fold.deflection, names):
            yield f"folds[{i}].{key}", words
        if not len(fold.values) == len(fold.exported) == count:
            yield f"folds[{i}]", f"{count} values are needed, and as many exported"
    for i, placement in enumerate(document.data):
        for key, words in _of_placement(placement, len(names)):
            yield f"data[{i}].{key}", words
    stored = document.posterior
    if stored is not None:
        kinds = {
            "sockets" if p.samples[0].point is None else "points" for p in document.data
        }
        if absent := kinds.difference(stored.noises):
            yield "posterior.noises", f"none of {', '.join(absent)}"
    yield from _of_estimates(document, names)


def _of_deflection(
    deflection: Mapping[str, Sequence[float]], names: Sequence[str]
) -> Iterator[tuple[str, str]]:
    """Yield the extensions that are none, or have no coefficient for each joint, and why."""
    for extension, coefficients in deflection.items():
        key = f"deflection.{extension}"
        if extension not in EFFECTS:
            yield key, "no extension of this version"
            continue
        count = len(EFFECTS[extension].coefficient_names(names))
        if len(coefficients) != count:
            yield key, f"{len(coefficients)} coefficients, but the joints need {count}"


def _of_estimates(
    document: CalibrationDocument, names: Sequence[str]
) -> Iterator[tuple[str, str]]:
    """Yield the zeros, curves and tools that are not of joints of these names, and why."""
    curves = document.curves.joints if document.curves else ()
    for i, zero in enumerate(document.later_zeros):
        if zero.joint not in names:
            yield f"later_zeros[{i}]", f"no joint is called {zero.joint!r:.60}"
    for i, curve in enumerate(curves):
        if curve.joint not in names:
            yield f"curves.joints[{i}]", f"no joint is called {curve.joint!r:.60}"
        if not len(curve.values) == len(curve.deviations) == DEGREES:
            yield f"curves.joints[{i}]", f"{DEGREES} values and deviations are needed"
    for i, tool in enumerate(document.tools):
        if np.array(tool.covariance, dtype=object).shape != (3, 3):
            yield f"tools[{i}].covariance", "three rows of three numbers are needed"


def _of_placement(
    placement: PlacementSamples, joints: int
) -> Iterator[tuple[str, str]]:
    """Yield the keys of a placement's samples that do not fit so many joints, and why."""
    if not placement.samples:
        yield "samples", "none"
    if not 0 <= placement.distance <= LENGTH.largest:
        yield "distance", f"{placement.distance:g} m"
    for i, sample in enumerate(placement.samples):
        for key, words in _of_sample(sample, joints):
            yield f"samples[{i}].{key}", words
    for key in ("point", "orientation"):
        kinds = {getattr(sample, key) is None for sample in placement.samples}
        if len(kinds) > 1:
            yield f"samples.{key}", "some samples have it, and some do not"


def _of_sample(sample: RecordedSample, joints: int) -> Iterator[tuple[str, str]]:
    """Yield the keys of a sample that do not fit so many joints, and why."""
    for key in ("position", "effort"):
        values = getattr(sample, key)
        if values is not None and len(values) != joints:
            yield key, f"{len(values)} numbers, but the robot has {joints} joints"
    if doubt := JOINT_POSITION.doubt(sample.position):
        yield "position", doubt
    if not 0 <= sample.socket <= LAST_SOCKET:
        yield "socket", f"{sample.socket} is not from 0 to {LAST_SOCKET}"
    if sample.orientation is not None and not any(sample.orientation):
        yield "orientation", "no quaternion has length 0"
