"""Inspection of recordings before a fit: each placement, and all of them together."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from math import ceil

import numpy as np

from ..identification.data import Measurement, places_of
from ..identification.robot import Robot
from ..results import Diagnostic, Hypothesis
from .configurations import of_placement, where_of
from .corrections import Correction, correction_of
from .explain import explain
from .finding import GARBAGE, UNKNOWNS, Finding, by_mender
from .hypotheses import Scene, samples_of
from .robust_fit import RigidModel
from .scene_fit import Given, scene_of

UNCLEAR = {"ball_loose", "pushed", "unexplained", "other_arm", "drift"}
"""Causes that several faults look like, which each placement may tell by itself."""
VAGUE = ("ball_loose", "pushed", "model")
"""Codes of such causes of all placements."""
EXACT = 1e-5
"""Largest error of points that the nominal model computed [m]; tables round to so much."""
ENOUGH = 8
"""Fewest points that tell that."""
TOGETHER = 40
"""Placements that are inspected together at most: each explanation is compared with all others, so
that more would take the square of their number."""
MANY = 5.0
"""A placement fitted alone that leaves more than so many times what the arm repeats is not sound,
though nothing explains it."""


@dataclass(frozen=True)
class Inspection:
    """Diagnostics of one placement."""

    measured: Measurement
    floor: float
    """Mean error of a fit to this placement alone, see :func:`.fitted_alone` [m]."""
    corrections: tuple[Correction, ...]
    """Actions that set its findings right."""
    diagnostics: tuple[Diagnostic, ...]
    centre: np.ndarray
    """Between its sockets, as the fit to all placements predicts it, shape (3,) [m]."""

    @property
    def sound(self) -> bool:
        """True without diagnostics that are errors."""
        return all(diagnostic.level != "error" for diagnostic in self.diagnostics)


@dataclass(frozen=True)
class Survey:
    """Diagnostics of several placements, and what explains them."""

    placements: tuple[Inspection, ...]
    shared: tuple[Diagnostic, ...]
    """Diagnostics of all placements, or of the arm."""
    hypotheses: tuple[Hypothesis, ...] = ()
    """Explanations of all recordings, the most probable first."""
    causes: tuple[str, ...] = ()
    """Names of the explanations that were accepted, each beside those before."""
    gains: tuple[str, ...] = ()
    """Joints that read too much or too little by a share."""

    @property
    def unclear(self) -> bool:
        """True where samples scatter, maybe since several placements have faults of their own."""
        corrections = chain.from_iterable(one.corrections for one in self.placements)
        return not any(corrections) and not UNCLEAR.isdisjoint(self.causes)

    def told_by(self, surveys: Sequence["Survey"]) -> "Survey":
        """Return what surveys of each placement alone tell, if differences are among it."""
        telling = [one for one in surveys if not set(UNKNOWNS).isdisjoint(one.causes)]
        if not telling:
            return self
        return replace(
            self,
            placements=tuple(one.placements[0] for one in surveys),
            shared=tuple(d for d in self.shared if d.code not in VAGUE),
            hypotheses=telling[0].hypotheses,
            causes=telling[0].causes,
        )

    @property
    def codes(self) -> set[str]:
        """Codes of the diagnostics of all placements."""
        return {diagnostic.code for diagnostic in self.shared}

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All diagnostics, those of all placements first."""
        return (
            *self.shared,
            *chain.from_iterable(one.diagnostics for one in self.placements),
        )


def inspect_all(
    robot: Robot,
    measurements: Sequence[Measurement],
    given: Given | None = None,
    *,
    zeros: bool = False,
    repeatability: float | None = None,
) -> Survey:
    """Inspect placements: each by itself, and all together, or so many as :data:`TOGETHER`.

    Args:
        robot: The robot.
        measurements: The placements.
        given: What was said of them.
        zeros: The joints may have offsets of degrees, as on arms made of servos: then that is no
            mistake.
        repeatability: Of the arm [m]; None where nothing is known of it.

    Raises:
        KnownError: A known distance names a socket that is not there.
    """
    given = given or Given()
    if not measurements:
        return Survey((), ())
    places_of(measurements, lengths=given.known, require_scale=False)
    model = RigidModel(robot, zeros=zeros)
    count = ceil(len(measurements) / TOGETHER)
    ends = [len(measurements) * k // count for k in range(count + 1)]
    surveys: list[Survey] = []
    for begin, end in pairwise(ends):
        group = measurements[begin:end]
        surveys.append(_survey_of(model, group, given.within(group), repeatability))
    return _joined(surveys)


def _joined(surveys: Sequence[Survey]) -> Survey:
    """Return the survey of groups of placements; of a cause of several, the first is told."""
    first, *others = surveys
    if not others:
        return first
    shared: dict[str, Diagnostic] = {}
    for survey in surveys:
        names = [inspection.measured.name for inspection in survey.placements]
        where = f"{names[0]} to {names[-1]}"
        for diagnostic in survey.shared:
            everywhere = all(diagnostic.code in one.codes for one in surveys)
            told = diagnostic if everywhere else replace(diagnostic, where=where)
            shared.setdefault(diagnostic.code, told)
    telling = next((survey for survey in surveys if survey.causes), first)
    return Survey(
        tuple(chain.from_iterable(survey.placements for survey in surveys)),
        tuple(shared.values()),
        telling.hypotheses,
        causes=tuple(chain.from_iterable(survey.causes for survey in surveys)),
        gains=tuple(chain.from_iterable(survey.gains for survey in surveys)),
    )


def _survey_of(
    model: RigidModel,
    measurements: Sequence[Measurement],
    given: Given,
    repeatability: float | None,
) -> Survey:
    """Return what explains placements together."""
    scene = scene_of(model, measurements, given, repeatability)
    causes, hypotheses = explain(model, scene)
    findings = [Finding(cause, measurements, given, model.zeros) for cause in causes]
    gains = [cause for cause in causes if cause.kind.name == "gain"]
    advice = {f.diagnostic.text: f.diagnostic.advice for f in findings}
    return Survey(
        tuple(_inspections(model, scene, measurements, findings)),
        shared=tuple(f.diagnostic for f in findings if f.cause.of_all),
        hypotheses=tuple(
            replace(h, advice=advice.get(h.text) or by_mender(h.advice, given))
            for h in hypotheses
        ),
        causes=tuple(cause.kind.name for cause in causes),
        gains=tuple(cause.parameters["joint"] for cause in gains),
    )


def _inspections(
    model: RigidModel,
    scene: Scene,
    measurements: Sequence[Measurement],
    findings: Sequence[Finding],
) -> list[Inspection]:
    """Return the diagnostics of each placement, with what sets its findings right."""
    explained = any(finding.explains_errors for finding in findings)
    balls = model.points(scene.x, scene.q)
    inspections: list[Inspection] = []
    for m, rows, floor in zip(measurements, scene.places, scene.floors, strict=True):
        here = [finding for finding in findings if finding.placement == m.name]
        diagnostics = [finding.diagnostic for finding in here]
        diagnostics += of_placement(model.robot, m)
        if floor > MANY * scene.noise and not explained:
            errors = np.linalg.norm(scene.remaining[rows], axis=1)
            worst = int(np.argmax(errors))
            diagnostics.append(_unexplained(m, floor, scene.noise, worst))
        if m.kind == "points" and floor < EXACT:
            diagnostics += _computed(model, m)
        cures = (correction_of(each.cause, each.diagnostic, m) for each in here)
        corrections = tuple(filter(None, cures))
        centre = np.median(balls[rows], axis=0)
        inspections.append(
            Inspection(m, floor, corrections, tuple(diagnostics), centre)
        )
    return inspections


def _computed(
    model: RigidModel,
    measured: Measurement,
) -> list[Diagnostic]:
    """Return the diagnostic of points that were computed from the joints, if any.

    The nominal model leaves nothing of them, which no instrument can do.
    """
    (error,) = model.nominal.errors([samples_of([measured])])
    if error >= EXACT or len(measured.positions) < ENOUGH:
        return []
    text = f"the nominal model leaves less than {1e3 * EXACT:g} mm of its points"
    advice = "no instrument is so exact. A controller computed them from the joints: measure them"
    return [Diagnostic("warning", "computed", where_of([measured]), text, advice)]


def _unexplained(
    measured: Measurement,
    floor: float,
    noise: float,
    worst: int,
) -> Diagnostic:
    """Return the diagnostic of a placement that leaves much, whatever the cause."""
    text = (
        f"fitted alone it leaves {1e3 * floor:.2f} mm, more than {MANY:.0f} times the "
        f"{1e3 * noise:.2f} mm that are usual of this arm. No single cause explains it"
    )
    advice = "look at ball, sockets and base, and record it again; or give --repeatability-mm"
    if measured.kind == "points":
        sample = measured.placement.samples[int(measured.order[worst])]
        worst_row = sample.where or sample.named
        advice = (
            f"the worst is {worst_row}: are all of one target, in a right-handed frame?"
        )
    level = "error" if floor > GARBAGE else "warning"
    return Diagnostic(level, "floor", where_of([measured]), text, advice)
