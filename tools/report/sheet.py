"""Content of a sheet to sign: what was measured at places that the fit did not see."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

from ...errors import MukcaError, fixed
from ...solver.assessment import (
    BAND,
    NEAR,
    WORKSPACE,
    LimitResult,
    Quantiles,
    RoleSummaries,
    mm,
    plural,
    short_where,
)
from ...solver.identification.data import Metrics
from ...solver.results import CalibrationDocument, Provenance, calibrated_robot
from . import figures
from .figures import ReportDocument

BLANK = "_" * 24
"""Of a note that nobody made, to be filled in by hand."""
UNKNOWN = "\N{EN DASH}"
"""For what the calibration's file does not keep."""
NOTES = {
    "number": "Certificate number",
    **figures.NOTED,
    "place": "Place",
    "instrument": "Instrument, make and type",
    "instrument_serial_number": "Its serial number",
    "instrument_certificate": "Its certificate",
    "instrument_uncertainty": "Its uncertainty (k = 2)",
    "due": "Date due",
}
"""Titles of what people note, by their keys; the instrument measured the sockets or points."""
PREDICTED = (NEAR, WORKSPACE)
"""Limits on figures that the posterior predicts."""
RULE = (
    "Rule of decision: a measured figure passes at its limit or below, as measured where its "
    "95 % interval (k = 1.96) goes beyond. It fails only by more than one standard deviation. A "
    "predicted figure passes where the upper end of its 68 % interval is at its limit or below."
)
VOID = (
    "The calibration is void after a collision, a repair, or the change of a motor, an encoder or "
    "a joint's zero, with another load than stated, and for joints beyond the stated range. "
    "Check it by mukca validate after any of these, and until the date due."
)
NO_ROBOT_STANDARD = (
    "The errors above are neither the pose accuracy AP nor the pose repeatability RP of ISO 9283, "
    "and nobody may state them as such. The program's maker is no accredited laboratory."
)
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


def sheet_of(
    document: CalibrationDocument,
    report: ReportDocument,
    notes: Mapping[str, str] | None = None,
) -> Sheet:
    """Return the content of the sheet of a calibration.

    Args:
        document: The calibration.
        report: Its report.
        notes: Texts by the keys of :data:`NOTES`; they take the place of those recorded.

    Raises:
        CertificateError: Nothing was left out, or a note has no place on the sheet.
    """
    for key in notes or {}:
        if key not in NOTES:
            raise CertificateError(f"--note {key}: choose among {', '.join(NOTES)}")
    role, held_out = report.summary.judged
    if role == "train":
        raise CertificateError(
            "a certificate rests on what a fit left out, and nothing was: record a second place"
        )
    words = "held-out" if role == "test" else "left-out"
    lead = "which the calibration did not see"
    if role == "left_out":
        lead = "each by a fit to all others; calibrated.urdf is by the fit to all"
    parts = plural(held_out.placements, "placement")
    trained = report.summary.train
    if trained and held_out.placements > trained.placements:
        parts = f"{held_out.placements} regions of joint space"
    samples = plural(held_out.samples, "sample")
    errors = Section(
        title=f"Measured errors at {words} places",
        lead=f"{parts}, {samples}, {lead}.",
        heads=("model", "mean", "95 % below", "largest"),
        rows=_rows(report.summary),
        paragraphs=[report.error_parts.text] if report.error_parts else [],
    )
    limits = Section(
        title="Limits",
        heads=("on", "measured, k = 1.96", "predicted, 68 % interval", "at most", ""),
        rows=list(map(_limit_row, report.verdict.limits)),
        paragraphs=[*_doubts(report), *_origin_of_limits(report), RULE],
    )
    sections = (
        Section(rows=_facts(document, report, notes or {})),
        errors,
        limits,
        _answer(report),
        Section(title="Scope", paragraphs=(VOID, NO_ROBOT_STANDARD)),
        _origin(report.provenance),
    )
    return Sheet(
        title=report.robot_name,
        created=report.provenance.created,
        sections=sections,
    )


def _doubts(report: ReportDocument) -> list[str]:
    """Return which limits are not shown to be kept; none where all are."""
    verdict = report.verdict
    if verdict.status == "pass":
        return []
    return [f"Not shown to be kept: {r.doubt}." for r in verdict.limits if r.doubt]


def _answer(report: ReportDocument) -> Section:
    """Return the verdict, and those of its premises that its answer does not say."""
    verdict = report.verdict
    answer = " ".join(verdict.answer)
    premises = [row.text for row in report.rests_on if row.text not in answer]
    title = f"Verdict: {verdict.title}"
    return Section(title=title, paragraphs=[*verdict.answer, *premises])


def _origin(provenance: Provenance) -> Section:
    """Return versions of the programs, and hashes of the model, the URDF and the recordings."""
    versions = [f"{name} {version}" for name, version in provenance.versions.items()]
    model = {"model, its URDF with the ball's joint": provenance.model_sha256}
    outputs = model | (provenance.output_sha256 or {})
    lines = [f"{digest} {name}" for name, digest in outputs.items()]
    for file, digest in provenance.data_sha256.items():
        lines.append(f"{digest} {short_where(file)}")
    more = len(lines) - MOST_HASHES
    if more > 0:
        lines[MOST_HASHES:] = [f"and {more} more, in calibration.json"]
    return Section(title="Versions and SHA-256", lead=", ".join(versions), small=lines)


def _facts(
    document: CalibrationDocument, report: ReportDocument, notes: Mapping[str, str]
) -> list[tuple[str, str]]:
    """Return what is known of the arm and of the recording, a title and a text each."""
    files = list(chain.from_iterable(data.files for data in document.data))
    recorded = figures.session_notes(files)
    titles = NOTES.items()
    return [
        *((t, notes.get(key) or recorded.get(t, BLANK)) for key, t in titles),
        ("Calibrated on", report.provenance.created[:10]),
        ("Payload at the ball", f"{document.load.payload:g} kg"),
        ("Range of joints", _ranges(document)),
        ("Measured with", report.distance_text),
    ]


def _ranges(document: CalibrationDocument) -> str:
    """Return the range of each joint over all samples, in words."""
    samples = chain.from_iterable(row.samples for row in document.data)
    positions = zip(*(sample.position for sample in samples), strict=True)
    joints = calibrated_robot(document, "calibration").robot.actuated
    words: list[str] = []
    for joint, values in zip(joints, positions, strict=True):
        is_length = joint.type == "prismatic"
        factor, unit = (1e3, "mm") if is_length else (math.degrees(1), "deg")
        ends = [fixed(factor * value, 0) for value in (min(values), max(values))]
        words.append(f"{joint.name} {' to '.join(ends)} {unit}")
    return "; ".join(words)


def _rows(summary: RoleSummaries) -> list[list[str]]:
    """Return errors at held-out places by each model: mean, 95 %, largest.

    The nominal model stands first as it does best: with its ball refitted, or with that given.
    """
    held_out = summary.judged[1]
    by_model = held_out.quantiles
    rows: list[list[str]] = []

    def add(title: str, metrics: Metrics, quantiles: Quantiles | None) -> None:
        p95 = mm(quantiles.p95, 3) if quantiles else UNKNOWN
        largest = quantiles.max if quantiles else metrics.max_error
        mean = mm(metrics.mean_absolute_error, 3)
        rows.append([title, mean, p95, mm(largest, 3)])

    add("nominal model", held_out.nominal, by_model.nominal)
    refitted = held_out.ball_refitted
    if refitted:
        add("nominal model, ball refitted", refitted, None)
        if refitted.mean_absolute_error < held_out.nominal.mean_absolute_error:
            rows.reverse()
    add("calibrated.urdf", held_out.loaded, by_model.loaded)
    if held_out.geometric:
        add("corrected joint positions", held_out.calibrated, by_model.calibrated)
    return rows


def _limit_row(row: LimitResult) -> list[str]:
    """Return a limit, the figure measured or predicted, and whether the limit is kept."""
    words = "not measured" if row.found is None else mm(row.found, 3)
    if row.found is not None and row.deviation is not None:
        words += f" \N{PLUS-MINUS SIGN}{mm(BAND * row.deviation, 3)}"
    if row.interval:
        low, high = mm(row.interval.low, 3), mm(row.interval.high, 3)
        words = f"{mm(row.interval.value, 3)} ({low} to {high})"
    columns = ["", words] if row.name in PREDICTED else [words, ""]
    agreed = "none" if row.limit is None else mm(row.limit, 3)
    status = f"{row.status}, as measured" if row.doubt else row.status
    if row.status == "not enough" and row.deviation is not None:
        status = "not decided"
    return [row.title, *columns, agreed, status]


def _origin_of_limits(report: ReportDocument) -> list[str]:
    """Return where the limits come from, in a sentence; nothing where there is none."""
    rows = [row for row in report.verdict.limits if row.limit is not None]
    if not rows:
        return []
    origins = [f"{row.title}: {row.reason.partition('; ')[0]}" for row in rows]
    source = report.limits.repeatability_source
    return [f"Origin of the limits: {'; '.join(origins)}. Repeatability: {source}."]
