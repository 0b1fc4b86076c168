"""A calibration as people use it: print, predict, save, load again, validate."""

import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from html import escape
from pathlib import Path

import msgspec
import numpy as np

from ...errors import MukcaError
from ...recorder import Placement, Sample
from .. import results
from ..assessment import (
    Assessment,
    Verdict,
    assess,
    distance_text,
    distortion_row,
    joints_wrong,
)
from ..assessment import Options as AssessmentOptions
from ..identification.data import Measurement, measure, one_blas_thread
from .deviation import FittedModel
from .errors import Errors, placement_errors
from .option import UsageError
from .preparation import as_list, at_scale

CALIBRATION, URDF = "calibration.json", "calibrated.urdf"
MOST_FINDINGS = 5
"""Findings that are printed; all are in the document."""
SAME_DIGITS = 6
"""Digits to which joint positions of one sample agree in all forms of a recording [rad], [m]."""


class DistortedError(MukcaError):
    """A model does not reproduce the distance of the sockets, so it is not to be used."""

    failed = True


class Calibration(FittedModel):
    """A robot as its recordings say it is, with everything that is known of it.

    Args:
        document: All that ``calibration.json`` holds.
        calibrated: The calibrated robot; None to build it from the document.
        source: The document's file, for messages.
    """

    @classmethod
    def of_file(cls, file: Path) -> "Calibration":
        """Read a ``calibration.json``; see :func:`load_calibration`."""
        return cls(results.read_calibration(file), source=str(file))

    @cached_property
    def errors(self) -> Errors:
        """Per placement: its role, and its errors by each model [m]; last where it was left out."""
        return Errors([*self.document.placements, *self.document.left_out])

    @cached_property
    def ball_refitted(self) -> results.CalibratedRobot | None:
        """Nominal robot with its ball refitted; None if not identified, and in older files."""
        return results.with_ball_at(self.robot, self.document.refitted_ball)

    @property
    def parameters(self) -> tuple[results.ParameterValue, ...]:
        """Calibrated numbers of the geometry, with their nominal values and deviations."""
        return self.document.parameters

    def urdf(self, folder: Path | None = None) -> bytes:
        """Return the text of ``calibrated.urdf``; see :meth:`.CalibratedRobot.urdf`."""
        return self.calibrated.urdf(folder)

    @property
    def result(self) -> results.Result:
        """Result of the calibration, without the samples and the models."""
        return results.Result.filled(self.document)

    def refusal(self, accept_distorted: bool | None = None) -> str:
        """Return why the model is not to be written, in words; empty where it may be.

        ``accept_distorted`` is that of :meth:`save`.
        """
        if accept_distorted is None:
            accept_distorted = bool(self.document.settings.get("accept_distorted"))
        if accept_distorted or not self.document.distorted:
            return ""
        mend = "Check --distance, that sockets are not mixed up, and the data"
        if joints_wrong(self.document.checks):
            mend = "Mend first what the checks say of the joints"
        distortion = distortion_row(self.document).text
        return f"refused: {distortion}. {mend}; accept_distorted (--accept-distorted) writes it"

    @cached_property
    def assessment(self) -> Assessment:
        """The calibration held against the limits that fit the arm; no page is made for it."""
        return assess(self.document, self.source, AssessmentOptions())

    @property
    def verdict(self) -> Verdict:
        """Verdict on the calibration, and the limits that it rests on."""
        return self.assessment.verdict

    def save(
        self,
        folder: str | Path,
        *,
        force: bool = False,
        accept_distorted: bool | None = None,
        pages: "Callable[[Calibration], Mapping[str, bytes]] | None" = None,
    ) -> dict[str, str]:
        """Write the calibrated URDF and ``calibration.json``.

        :func:`mukca.write_report` writes the page that shows them.

        Args:
            folder: Made where missing. Files of other names in it stay as they are.
            force: Overwrite what is there.
            accept_distorted: Write even a model that does not reproduce the sockets' distance; None
                for what the calibration was told.
            pages: Makes further files to write with them, by name, as ``report.html``.

        Returns:
            The paths written, by kind.

        Raises:
            OutputError: The folder is there already, or cannot be written.
            DistortedError: See ``accept_distorted``.
        """
        folder = Path(folder)
        results.refuse_existing(folder, force=force)
        if refusal := self.refusal(accept_distorted):
            raise DistortedError(refusal)
        outputs, contents = self.files_in(folder, accept_distorted, pages)
        results.write_files(folder, contents)
        return outputs

    def files_in(
        self,
        folder: Path,
        accept_distorted: bool | None,
        pages: "Callable[[Calibration], Mapping[str, bytes]] | None",
    ) -> tuple[dict[str, str], dict[str, bytes]]:
        """Return the paths that :meth:`save` writes, by kind, and the content of each file by name.

        ``calibration.json`` is put in its place first and the URDF last: until then the document
        names the digest of another URDF, also over files of versions that knew no digests.
        """
        saved = self.saved_in(folder)
        outputs = dict(saved.document.outputs)
        further: Mapping[str, bytes] = pages(saved) if pages is not None else {}
        if "report.html" in further:
            outputs["report"] = str(folder / "report.html")
        settings = dict(self.document.settings)
        if accept_distorted is not None:
            settings["accept_distorted"] = accept_distorted
        document = msgspec.structs.replace(
            saved.document, outputs=outputs, settings=settings
        )
        return outputs, {
            CALIBRATION: results.encode(document, indent=1),
            **further,
            URDF: self.urdf(folder),
        }

    def saved_in(self, folder: Path) -> "Calibration":
        """Return the calibration with the paths and digests that :meth:`save` writes."""
        document = msgspec.structs.replace(
            self.document,
            outputs={
                "urdf": str(folder / URDF),
                "calibration": str(folder / CALIBRATION),
            },
            provenance=msgspec.structs.replace(
                self.document.provenance,
                output_sha256={URDF: results.sha256(self.urdf(folder))},
            ),
        )
        saved = Calibration(document, self.calibrated, str(folder / CALIBRATION))
        saved.base_in = self.base_in
        return saved

    @one_blas_thread
    def validate(self, placements: Placement | Sequence[Placement]) -> Errors:
        """Measure the calibration on other recordings.

        Args:
            placements: See :func:`mukca.read_placements`. Those that the calibration was fitted
                to have the role ``train`` in the result: their errors prove little.

        Raises:
            UsageError: No placement is given.
            MeasurementError: A placement is not of this robot.
        """
        several = as_list(placements)
        if not several:
            raise UsageError(
                "no placement to validate on; read some by mukca.read_placements"
            )
        read = partial(measure, robot=self.robot, sockets=1, load=self.load)
        return self.errors_of([read(self.at_scale(p)) for p in several])

    def errors_of(
        self, data: Sequence[Measurement], *, other_tip: bool = False
    ) -> Errors:
        """Return the errors of checked placements, those trained on first.

        ``other_tip``: points were measured with another probe, whose tip is refitted.
        """
        placements: list[tuple[results.Role, Measurement]] = [
            ("train" if self.was_trained_on(m) else "test", m)
            for m in map(self.as_read_now, data)
        ]
        placements.sort(key=lambda pair: pair[0] == "test")
        ball = self.document.refitted_ball
        return Errors(
            placement_errors(self.calibrated, ball, (), placements, other_tip=other_tip)
        )

    def at_scale(self, placement: Placement) -> Placement:
        """Return a placement at the scale of the instrument that the calibration was told."""
        return at_scale(placement, self.document.settings.get("scale"))

    def was_trained_on(self, measured: Measurement) -> bool:
        """Tell whether the robot was fitted to most of these samples, in whatever form they are."""
        return any(
            row.role == "train" and _are_in(measured, row) for row in self.document.data
        )

    def as_read_now(self, measured: Measurement) -> Measurement:
        """Samples with joint positions converted to the present zeros [rad].

        Only samples that the calibration was made of are converted: they are older.
        """
        offsets = self.document.later_offsets
        before = (row.shifted(offsets) for row in self.document.data)
        if not any(offsets) or not any(_are_in(measured, row) for row in before):
            return measured
        remark = (
            f"{measured.name}: read before zeros changed, and taken as joints read now"
        )
        read_now = measured.shifted(np.negative(offsets))
        return replace(read_now, warnings=(*measured.warnings, remark))

    def __repr__(self) -> str:
        doc = self.document
        findings = [f"{finding.level}: {finding}" for finding in doc.checks or ()]
        lines = [
            f"{doc.robot}, calibrated by method {doc.method}",
            *self.verdict.answer,
            distance_text(doc.placements),
            *findings[:MOST_FINDINGS],
        ]
        verdict = f"Verdict: {self.verdict.title}. {self.verdict.text}"
        return "\n".join([*lines, repr(self.errors), "", *textwrap.wrap(verdict, 100)])

    def _repr_html_(self) -> str:
        """Return the verdict and the errors for notebooks."""
        title, *lines = map(
            escape, (self.verdict.title, *self.verdict.answer, repr(self.errors))
        )
        return f"<h4>{title}</h4><pre>{'<br/>'.join(lines)}</pre>"


def _are_in(measured: Measurement, row: results.PlacementSamples) -> bool:
    """Return whether most samples are in a placement of a calibration, in whatever order."""
    ours = _rounded(measured.placement.samples)
    theirs = _rounded(row.samples)
    return 2 * len(set(theirs).intersection(ours)) > len(ours)


def _rounded(
    samples: Iterable[Sample | results.RecordedSample],
) -> list[tuple[float, ...]]:
    """Return joints, and points: a plan may be measured twice, through the same postures."""
    rows = ((*sample.position, *(sample.point or ())) for sample in samples)
    return [tuple(np.round(row, SAME_DIGITS).tolist()) for row in rows]
