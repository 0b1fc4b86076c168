"""Rows of a verdict, by what they are made of."""

from dataclasses import replace

import pytest
from altered import with_errors

from mukca.solver.assessment import (
    Options,
    limit_row,
    limits_of,
    predicted_in_words,
    rows_since,
    worst,
)
from mukca.solver.assessment.conclusion import conclude
from mukca.solver.assessment.held_out import error_rows
from mukca.solver.assessment.scale_check import scale_row
from mukca.solver.identification.data import measure
from mukca.solver.results import Diagnostic, Hypothesis, Scale


def test_the_worst_of_several_is_said_first():
    assert [worst(each) for each in ([], [0, 0], [0, 3], [3, 1, 0])] == [0, 0, 3, 1]


@pytest.mark.parametrize(("code", "status"), [("moved", "not evaluated"), ("far", "pass")])
def test_no_size_is_called_right_by_a_base_that_moved(code, status):
    checks = [Diagnostic(level="error", code=code, where="front", text="", advice="")]
    assert scale_row(Scale(value=1e-3, deviation=5e-4), 0.05, checks).status == status


@pytest.mark.parametrize(
    ("level", "distance", "status"),
    [("warning", 0.001, "warning"), ("warning", 0.4, "fail"), ("error", 0.001, "fail")],
)
def test_a_length_explains_the_size_unless_a_distance_may(level, distance, status):
    checks = [Diagnostic(level=level, code="length", where="all", text="x is off", advice="")]
    odds = {"length": 1 - distance, "distance": distance}
    causes = [Hypothesis(name, p, {}, "", "", "") for name, p in odds.items()]
    assert scale_row(Scale(value=0.02, deviation=5e-4), 0.05, checks, causes).status == status


@pytest.mark.parametrize(("told", "status"), [(True, "warning"), (False, "fail")])
def test_a_few_samples_break_no_limit_where_the_evidence_tells(simulated, told, status):
    since, calibrated = simulated.read({}), simulated.calibration.calibrated
    large = with_errors(simulated.calibration.validate(since).summary.test, 1e-3)
    limits = limits_of(simulated.calibration.document, "since", Options())
    data = [measure(since, calibrated.robot)]
    rows, _ = rows_since(calibrated, large, data, limits, zeros=False, compared=told)
    assert [row.status for row in rows[:2]] == [status] * 2


def kept(error, deviation):
    """A row of a limit of 0.1 mm that counts as kept, by an error and its deviation [mm]."""
    given = 1e-3 * error, 1e-4
    return limit_row("distance_error", "pass", "", *given, deviation=1e-3 * deviation)


@pytest.mark.parametrize(
    ("error", "deviation", "words"),
    [
        (0.05, 0.02, ""),
        (0.078, 0.046, "held-out distance error may be 0.168 mm (95 %)"),
    ],
)
def test_a_pass_says_which_limits_are_not_shown_to_be_kept(simulated, error, deviation, words):
    better, row = simulated.calibration.document.better, kept(error, deviation)
    verdict = conclude([row], better, None)
    assert words in row.doubt and bool(words) == bool(row.doubt)
    assert verdict.status == "pass" and words in verdict.answer[-1]
    assert verdict.answer[-1].count("; its ") == bool(words)


def test_a_figure_about_its_limit_neither_keeps_nor_misses_it(simulated):
    """Above it by less than the figure's deviation, or with a deviation larger than the limit."""
    summary = simulated.calibration.document.summary
    limits = limits_of(simulated.calibration.document, "since", Options(distance_error=1e-4))
    for error, deviation in ((5e-5, 1.1e-4), (1.5e-4, 1.1e-4), (1.02e-4, 1e-5)):
        deviations = {"distance_error": deviation}
        metrics = replace(summary.train.loaded, distance_error=error)
        row = error_rows(metrics, None, limits, "", deviations=deviations)[1]
        assert row.status == "not enough" and "or more placements" in row.text
        verdict = conclude([row], simulated.calibration.document.better, None)
        assert (verdict.title, verdict.use, verdict.exit_status) == ("BETTER", True, 1)
        assert row.text[1:] in verdict.answer[-1]


@pytest.mark.parametrize(
    ("predicted", "length", "repeatability", "words"),
    [
        (0.8e-3, None, 1e-4, "where 0.90 mm is asked: no other placement is needed for that"),
        (1.0e-3, None, 1e-4, "where 0.90 mm is asked: record another placement"),
        (1.0e-3, 1.1, 1e-4, "where 1.10 mm is asked: no other placement is needed for that"),
        (1.0e-3, None, None, "whether that is enough follows from your arm's --repeatability-mm"),
    ],
)
def test_one_judgement_says_whether_another_placement_is_needed(
    predicted, length, repeatability, words
):
    assert predicted_in_words(predicted, length, repeatability).endswith(words)
