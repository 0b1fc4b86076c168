"""The tables that a calibration is handed: checks of its recordings, and studies of its fit."""

from dataclasses import replace

import numpy as np
import pytest

import mukca
from mukca.solver.calibration import (
    METHODS,
    STUDIES,
    Calibration,
    SolveOptions,
    Tables,
    calibrate_robot,
)
from mukca.solver.results import CalibrationDocument, Study


@pytest.fixture(scope="module")
def placements(session):
    return mukca.read_placements(session)


@pytest.fixture(scope="module")
def calibrated(panda, placements):
    def calibrated(**tables):
        options = SolveOptions().validated()
        return calibrate_robot(panda, placements[:2], (), options, Tables(**tables))

    return calibrated


@pytest.mark.slow
def test_without_any_table_there_is_a_calibration(calibrated, placements):
    document, robot = calibrated()
    assert document.uncertainty is document.better is document.outlook is None
    assert Calibration(document, robot).ball(placements[0].positions).shape[1] == 3
    told, same = calibrated(studies=STUDIES, methods=replace(METHODS, geometry=None))
    assert np.allclose(same.values, robot.values, rtol=0, atol=1e-12)
    assert told.uncertainty is not None and told.placements[0].predicted_deviation is not None


@pytest.mark.slow
def test_a_check_comes_before_the_fit_and_a_study_after_it(calibrated):
    def first_placement_alone(problem):
        return replace(problem, measurements=problem.measurements[:1])

    def choices(fit, measurements, scale):
        return (f"{len(measurements.measurements)} placement, scale {scale}",)

    study = Study("choices", choices, ("scale",))
    document, _ = calibrated(checks=[first_placement_alone], studies=[study])
    assert document.choices == ("1 placement, scale None",)


def test_a_study_reads_sections_of_the_document_and_no_later_study():
    fields = set(CalibrationDocument.__struct_fields__)
    for i, study in enumerate(STUDIES):
        later = {other.section for other in STUDIES[i + 1 :]}
        assert {study.section, *study.reads} <= fields and not later & set(study.reads)
