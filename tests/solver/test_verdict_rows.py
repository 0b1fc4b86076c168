"""Rows of a verdict, by what they are made of."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from altered import with_errors

from mukca.solver.assessment import (
    Options,
    checks_row,
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
from mukca.solver.results import (
    Better,
    Consequence,
    Diagnostic,
    Hypothesis,
    Improvement,
    Interval,
    Scale,
)


def interval(value):
    """An error with its interval [m]."""
    return Interval(value=value, low=0.8 * value, high=1.2 * value)


def improved(before, corrected, corrected_near):
    """A calibration with errors of 0.4 mm in the workspace and 0.2 mm near recorded places."""
    odds = {"probability": 0.99 if before > 1e-3 else 0.3, "corrected_probability": 0.97}
    places = [
        Improvement(before=interval(before), now=interval(now), corrected=interval(full), **odds)
        for now, full in ((4e-4, corrected), (2e-4, corrected_near))
    ]
    return Better(workspace=places[0], recorded_places=places[1])


def test_the_worst_of_several_is_said_first():
    assert [worst(each) for each in ([], [0, 0], [0, 3], [3, 1, 0])] == [0, 0, 3, 1]


@pytest.mark.parametrize(("code", "status"), [("moved", "not evaluated"), ("far", "pass")])
def test_no_size_is_called_right_by_a_base_that_moved(code, status):
    checks = [Diagnostic(level="error", code=code, where="front", text="", advice="")]
    assert scale_row(Scale(value=1e-3, deviation=5e-4), 0.05, checks).status == status


@pytest.mark.parametrize(
    ("level", "distance", "status"),
    [
        ("warning", 0.001, "warning"),
        ("warning", 0.4, "not enough"),
        ("error", 0.001, "not enough"),
    ],
)
def test_a_length_explains_the_size_unless_a_distance_may(level, distance, status):
    checks = [Diagnostic(level=level, code="length", where="all", text="x is off", advice="")]
    odds = {"length": 1 - distance, "distance": distance}
    causes = [Hypothesis(name, p, {}, "", "", "") for name, p in odds.items()]
    assert scale_row(Scale(value=0.02, deviation=5e-4), 0.05, checks, causes).status == status


@pytest.mark.parametrize(
    ("value", "length", "readings", "told"),
    [
        (0.0087, 0.2, 1, "BETTER"),
        (0.0087, 0.05, 1, "NOT ENOUGH DATA"),
        (0.0130, 0.2, 1, "NOT ENOUGH DATA"),
        (0.0130, 0.0, 2, "PASS near the recorded places"),
        (0.5, 0.2, 2, "FAIL"),
    ],
)
def test_a_length_is_likelier_than_a_distance_where_the_size_nearly_holds(
    value, length, readings, told
):
    """Or where two readings agree; but no arm is half as long again as its model."""
    odds = {"distance": 1 - length, "length": length}
    causes = [Hypothesis(name, p, {}, "", "", "") for name, p in odds.items()]
    row = scale_row(Scale(value=value, deviation=7e-4), 0.05, (), causes, readings=readings)
    verdict = conclude([row], improved(2e-3, 3e-4, 1e-4), None)
    assert verdict.title == told and "the sockets are" in row.text


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
        (0.078, 0.046, "held-out distance error may be up to 0.168 mm (limit 0.100 mm)"),
    ],
)
def test_a_pass_says_which_limits_are_not_shown_to_be_kept(simulated, error, deviation, words):
    better, row = simulated.calibration.document.better, kept(error, deviation)
    verdict = conclude([row], better, None)
    assert words in row.doubt and bool(words) == bool(row.doubt)
    answer = " ".join(verdict.answer)
    assert verdict.status == "pass" and words in answer
    assert answer.count("Only just: the ") == bool(words)


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
        assert row.text[1:] in verdict.answer[2]


@pytest.mark.parametrize(
    ("high", "length", "repeatability", "words"),
    [
        (
            0.8e-3,
            None,
            1e-4,
            "be within this arm's limit, 0.90 mm, so no other placement is needed",
        ),
        (
            1.0e-3,
            None,
            1e-4,
            "would be more than this arm's limit, 0.90 mm, so record another placement",
        ),
        (
            1.0e-3,
            1.1,
            1e-4,
            "be within this arm's limit, 1.10 mm, so no other placement is needed",
        ),
        (1.0e-3, None, None, "whether that is enough follows from your arm's --repeatability-mm"),
    ],
)
def test_one_judgement_says_whether_another_placement_is_needed(high, length, repeatability, words):
    predicted = Interval(value=0.6e-3, low=0.3e-3, high=high)
    told = predicted_in_words(predicted, length, repeatability)
    assert told.endswith(words) and "wrong by about 0.60 mm" in told


@pytest.mark.parametrize(
    ("before", "corrected", "near", "words"),
    [
        (2e-3, 5.2e-4, 8e-5, "a distance is then wrong by 0.08 mm there, 0.52 elsewhere."),
        (
            2e-3,
            3e-4,
            8e-5,
            "Better still, load it and let mukca correct the joint positions that you send (mukca "
            "command): a distance is then wrong by about 0.30",
        ),
        (2e-3, 5.2e-4, 3e-4, "Corrected joint positions are no better than this."),
        (
            5e-4,
            3e-4,
            8e-5,
            "With your file, let mukca correct the joint positions that you send (mukca command)",
        ),
    ],
)
def test_the_answer_says_where_corrected_joints_are_better(before, corrected, near, words):
    """Where they alone are, it is not USE IT, which is of the URDF."""
    verdict = conclude([], improved(before, corrected, near), None)
    assert verdict.answer[0] == (
        "With the new URDF, a distance anywhere in the workspace is wrong by about 0.40 mm "
        f"(was {'2.0' if before > 1e-3 else '0.50'}); near the recorded places by 0.20."
    )
    is_better = before > 1e-3
    assert verdict.use == is_better == verdict.answer[1].startswith("USE IT: load ")
    assert words in verdict.answer[-1]


def test_corrected_joints_that_are_worse_where_left_out_are_not_advised():
    larger, smaller = [SimpleNamespace(mean_absolute_error=e) for e in (3.5e-3, 3.4e-3)]
    held_out = SimpleNamespace(calibrated=larger, loaded=smaller)
    verdict = conclude([], improved(2e-3, 3e-4, 8e-5), held_out)
    assert verdict.answer[-1] == "Corrected joint positions are no better than this."


def test_a_length_that_alone_is_missing_asks_for_no_samples():
    lacking = limit_row("distance_given", "not enough", "nobody measured the sockets")
    verdict = conclude([lacking], improved(2e-3, 3e-4, 8e-5), None)
    assert verdict.answer[1:] == (
        "DO NOT LOAD IT: The samples are enough; only the sockets' distance is missing. "
        "Nobody measured the sockets.",
    )
    few = limit_row("samples", "not enough", "record more")
    assert "No more" not in " ".join(conclude([lacking, few], None, None).answer)


def test_where_the_workspace_is_as_before_the_recorded_places_lead():
    """A figure that did not change says nothing for a model."""
    verdict = conclude([], improved(4e-4, 3e-4, 8e-5), None)
    assert verdict.answer[0] == (
        "With the new URDF, a distance near the recorded places is wrong by about 0.20 mm "
        "(was 0.40); "
        "elsewhere by 0.40, as before."
    )


@pytest.mark.parametrize(("workspace", "status"), [(1e-4, "warning"), (2e-3, "fail")])
def test_an_error_stops_nothing_whose_consequence_the_gain_dwarfs(workspace, status):
    cost = Consequence(1e-5, workspace, 1e-3, 1e-3)
    error = Diagnostic("error", "base_moved", "front", "the base moved", "screw it down", cost)
    better = improved(2e-3, 4e-4, 1e-4)
    assert checks_row([error], better).status == status
    assert checks_row([error]).status == "fail"
