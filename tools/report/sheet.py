"""Content of a sheet to sign: what was measured at places that the fit did not see."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain

from ...errors import MukcaError
from ...solver.assessment import BAND, RoleSummaries, Verdict, mm, plural
from ...solver.results import CalibrationDocument, Provenance
from . import figures
from .figures import ReportDocument

BLANK = "_" * 24
"""What nobody noted is filled in by hand."""
UNKNOWN = "\N{EN DASH}"
"""For what the calibration's file does not keep."""
MOST_HASHES = 12
"""Hashes on the sheet; the others are in calibration.json."""


class CertificateError(MukcaError):
    """A certificate that cannot be."""


@dataclass(frozen=True)
class Section:
    """A part of the sheet, from top to bottom."""

    title: str = ""
    lead: str = ""
    heads: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    """Cells of a table; without heads the first cell of a row is its head."""
    paragraphs: Sequence[str] = ()
    small: Sequence[str] = ()
    """Lines in small letters."""


@dataclass(frozen=True)
class Sheet:
    """The content of a certificate, whatever it is written as."""

    title: str
    created: str
    """When the calibration was made."""
    sections: Sequence[Section]
    kind: str = "Certificate of calibration"
    signatures: Sequence[str] = ("Measured by, date", "Accepted by, date")


def sheet_of(document: CalibrationDocument, report: ReportDocument) -> Sheet:
    """Return the content of the sheet of a calibration.

    Raises:
        CertificateError: Nothing was left out.
    """
    role, held_out = report.summary.judged
    if role == "train":
        raise CertificateError(
            "a certificate rests on what a fit left out, and nothing was: record a second place"
        )
    words = "held-out" if role == "test" else "left-out"
    lead = "which the calibration did not see"
    if role == "left_out":
        lead = "each by a fit to all others; calibrated.urdf is by the fit to all"
    placements = plural(held_out.placements, "placement")
    samples = plural(held_out.samples, "sample")
    errors = Section(
        title=f"Errors at {words} places",
        lead=f"{placements}, {samples}, {lead}.",
        heads=("model", "mean", "95 % below", "largest"),
        rows=_rows(report.summary),
        paragraphs=[] if report.error_parts is None else [report.error_parts.text],
    )
    limits = Section(
        title="Limits",
        heads=("on", "found, 95 % interval", "at most", ""),
        rows=_limits(report),
        paragraphs=_doubts(report.verdict),
    )
    sections = (
        Section(rows=_facts(document, report)),
        errors,
        limits,
        _answer(report),
        _origin(report.provenance),
    )
    return Sheet(
        title=report.robot_name,
        created=report.provenance.created,
        sections=sections,
    )


def _answer(report: ReportDocument) -> Section:
    """Return the verdict, and those of its premises that its answer does not say."""
    verdict = report.verdict
    answer = " ".join(verdict.answer)
    texts = [premise.text for premise in report.rests_on]
    premises = [text for text in texts if text not in answer]
    return Section(
        title=f"Verdict: {verdict.title}",
        paragraphs=[*verdict.answer, *premises],
    )


def _origin(provenance: Provenance) -> Section:
    """Return versions of the programs, and hashes of the model, the URDF and the recordings."""
    versions = [f"{name} {version}" for name, version in provenance.versions.items()]
    model = ("model", provenance.model_sha256)
    outputs = (provenance.output_sha256 or {}).items()
    return Section(
        title="Versions and SHA-256",
        lead=", ".join(versions),
        small=_hashes([model, *outputs, *provenance.data_sha256.items()]),
    )


def _facts(
    document: CalibrationDocument, report: ReportDocument
) -> list[tuple[str, str]]:
    """Return what is known of the arm and of the recording, a title and a text each."""
    files = list(chain.from_iterable(data.files for data in document.data))
    notes = figures.session_notes(files)
    return [
        *((title, notes.get(title, BLANK)) for title in figures.NOTED.values()),
        ("Calibrated on", report.provenance.created[:10]),
        ("Payload at the ball", f"{document.load.payload:g} kg"),
        ("Measured with", report.distance_text),
    ]


def _hashes(hashes: Iterable[tuple[str, str]]) -> list[str]:
    """Return a line for each file that the calibration was made of."""
    lines = [f"{digest} {name}" for name, digest in hashes]
    more = len(lines) - MOST_HASHES
    if more > 0:
        lines[MOST_HASHES:] = [f"and {more} more, in calibration.json"]
    return lines


def _rows(summary: RoleSummaries) -> list[list[str]]:
    """Return errors at held-out places by each model: mean, 95 %, largest."""
    held_out = summary.judged[1]
    nominal = held_out.quantiles.nominal
    loaded = held_out.quantiles.loaded
    mean = held_out.nominal.mean_absolute_error
    rows: list[tuple[str, float, float | None, float]] = []
    rows.append(("nominal model", mean, nominal.p95, nominal.max))
    if (refitted := held_out.ball_refitted) is not None:
        mean = refitted.mean_absolute_error
        rows.append(("nominal model, ball refitted", mean, None, refitted.max_error))
    rows.append(
        ("calibrated.urdf", held_out.loaded.mean_absolute_error, loaded.p95, loaded.max)
    )
    return [
        [title, *(UNKNOWN if error is None else mm(error, 3) for error in errors)]
        for title, *errors in rows
    ]


def _limits(report: ReportDocument) -> list[list[str]]:
    """Return each limit, what was measured with its 95 % interval, and whether it is kept."""
    rows: list[list[str]] = []
    for row in report.verdict.limits:
        measured = "not measured" if row.found is None else mm(row.found, 3)
        if row.interval is not None:
            measured += (
                f" (68 %: {mm(row.interval.low, 3)} to {mm(row.interval.high, 3)})"
            )
        if row.found is not None and row.deviation is not None:
            measured += f" \N{PLUS-MINUS SIGN}{mm(BAND * row.deviation, 3)}"
        agreed = "none" if row.limit is None else mm(row.limit, 3)
        status = f"{row.status}, as measured" if row.doubt else row.status
        if row.status == "not enough" and row.deviation is not None:
            status = "not decided"
        rows.append([row.title, measured, agreed, status])
    return rows


def _doubts(verdict: Verdict) -> list[str]:
    """Return why limits are not shown to be kept, where the verdict's answer does not say it."""
    if verdict.status == "pass":
        return []
    return [
        f"Not shown to be kept: {row.doubt}." for row in verdict.limits if row.doubt
    ]
