"""The fit of a robot, its folds, the measurements that it is of, and what studies say of it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from msgspec import structs

from ..identification.data import Measurement, RobotRecordings
from ..identification.inference import FitPosterior, Posterior
from .calibrated import CalibratedRobot, Place
from .calibration import CalibrationDocument, FramePose
from .placements import Role


@dataclass(frozen=True)
class Fit:
    """The result of a fit, the same for both methods."""

    calibrated: CalibratedRobot
    optimizer: str
    seconds: float
    """Duration of the fit [s]."""
    iterates: tuple[CalibratedRobot, ...]
    """The robot after each iteration, the nominal one first."""
    covariance: np.ndarray | None = None
    """By the paper's method: how far the parameters would move if the same were recorded again,
    shape (n, n)."""
    full: FitPosterior | None = None
    """By the default method: the posterior of all unknowns, and why."""
    frames: tuple[FramePose, ...] | None = None
    """Of several robots that were calibrated together: frames in the base of this one, the first;
    None for a robot alone."""

    @cached_property
    def posterior(self) -> Posterior | None:
        """Posterior of the robot; None where it has none, or its covariance is not finite."""
        if self.full is None:
            return None
        posterior = self.full.arm
        matrix = posterior.covariance
        is_covariance = np.isfinite(matrix).all() and (np.diag(matrix) >= 0).all()
        return posterior if is_covariance else None


@dataclass(frozen=True)
class Fold:
    """A whole fit to all but some samples, and these."""

    fit: Fit
    ball: Place | None
    """The nominal ball in its link, refitted to the samples of the fit [m]; None if not
    identified."""
    trained: tuple[Measurement, ...]
    left_out: tuple[Measurement, ...]
    """Placements, or parts of them."""


Unseen = tuple[Posterior, Sequence[Measurement]]
"""Placements, or parts of them, with the posterior of a fit that has not seen them."""


@dataclass(frozen=True, kw_only=True)
class Measurements(RobotRecordings):
    """A robot, its placements to train on, and those that are held out."""

    name: str = ""
    """Its name among several robots; empty for one alone."""
    test: Sequence[Measurement] = ()
    """Placements that the fit does not see."""
    folds: Sequence[Fold] = ()
    """Fits, where nothing is held out, that each leave out some samples."""

    @property
    def base_frame(self) -> str:
        """The name of the frame that is the robot's base."""
        return f"{self.name}:base" if self.name else "base"

    @property
    def placements(self) -> list[tuple[Role, Measurement]]:
        """All placements, those to train on first."""
        return [
            *(("train", m) for m in self.measurements),
            *(("test", m) for m in self.test),
        ]

    def unseen(self, fit: Fit) -> list[Unseen]:
        """Return what fits did not see: held out of the fit itself, or left out by its folds."""
        pairs = [(fit.posterior, self.test)] if self.test else []
        pairs += [(fold.fit.posterior, fold.left_out) for fold in self.folds]
        return [
            (posterior, placements)
            for posterior, placements in pairs
            if posterior is not None
        ]


@dataclass(frozen=True)
class Study:
    """One thing that is said about a posterior and its measurements."""

    section: str
    """Key of ``calibration.json`` that it writes."""
    of: Callable[..., Any]
    """The section of a :class:`Fit` and :class:`.Measurements`, then of the sections that it reads;
    None for nothing to say."""
    reads: tuple[str, ...] = ()
    """Sections that it reads: of the document as fitted, or of studies before it."""
    needs_posterior: bool = True
    """True if nothing can be said of a fit by the paper's method."""


def studied(
    document: CalibrationDocument,
    fit: Fit,
    measurements: object,
    studies: Sequence[Study],
) -> CalibrationDocument:
    """Return a document with the sections of all studies."""
    for study in studies:
        if study.needs_posterior and fit.posterior is None:
            continue
        sections = (getattr(document, name) for name in study.reads)
        section = study.of(fit, measurements, *sections)
        document = structs.replace(document, **{study.section: section})
    return document
