"""Rows of a verdict, by what they are made of."""

import pytest
from altered import with_errors

from mukca.solver.assessment import Options, limits_of, rows_since, worst
from mukca.solver.assessment.scale_check import scale_row
from mukca.solver.data import measure
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
