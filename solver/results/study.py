"""A study: one thing that is said about a fit, as a section of ``calibration.json``."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from msgspec import structs

from .calibration import CalibrationDocument
from .fit import Fit


@dataclass(frozen=True)
class Study:
    """What is said about a posterior and its measurements."""

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
