"""Answers of the page for any error that a task may allow; the page's script chooses one.

They change only where that error passes one of the placements' own errors, so they are few.
"""

from collections.abc import Sequence

from ....solver.assessment import PlacementReport
from ....solver.results import Document
from ..figures import Answer, ReportDocument, answer_at, use_text
from ..plots import map_sentence

_NUMBER = "\0"
"""Stands for the error that the task allows while the sentences are written."""


class AnswersFrom(Document, kw_only=True, frozen=True):
    """Answers where the task allows an error of at least this much."""

    allowed: float
    """[m]."""
    answers: tuple[Answer, ...]
    """At each placement."""
    use: tuple[str, ...]
    """The answer in words, cut where the error that the task allows is to stand."""
    map: tuple[str, ...]
    """The sentence below the map, likewise."""


def answers_by_tolerance(report: ReportDocument) -> list[AnswersFrom]:
    """Return the answers for any error that the task may allow, the first for the smallest."""
    changes = {0.0, *(change for row in report.placements for change in _changes(row))}
    return [_step(report, allowed) for allowed in sorted(changes)]


def _changes(row: PlacementReport) -> Sequence[float]:
    """Return the tolerances at which the answer for a placement changes [m]."""
    if row.role == "train":
        return ()
    errors = row.quantiles.loaded
    mostly = max(abs(row.loaded.distance_error or 0.0), errors.p95)
    return mostly, max(mostly, errors.max)


def _step(report: ReportDocument, allowed: float) -> AnswersFrom:
    called = [row.called for row in report.answers.use.rows]
    answers: tuple[Answer, ...] = tuple(answer_at(row, allowed) for row in report.placements)
    use = use_text(called, answers, _NUMBER, report.verdict.status)
    return AnswersFrom(
        allowed=allowed,
        answers=answers,
        use=tuple(use.split(_NUMBER, 1)),
        map=tuple(map_sentence(report, answers, _NUMBER).split(_NUMBER, 1)),
    )
