"""The verdict: limits by arm, what fails, and what was not evaluated."""

import json
from typing import Any

import pytest

from mukca.solver.data.observations import parse_known
from mukca.solver.robot.urdf import shipped_robots
from mukca.tools.cli import main
from mukca.tools.documents.calibration import FORMAT, CalibrationDocument
from mukca.tools.documents.files import decode
from mukca.tools.documents.report import ReportDocument
from mukca.tools.report.build import Options, build_report
from mukca.tools.report.figures.acceptance import ARMS, known_arm


def figures_of(document: Any, **options: Any) -> ReportDocument:
    """Return the figures of a calibration's document."""
    typed = decode(json.dumps(document).encode(), CalibrationDocument, FORMAT, "")
    return build_report(typed, "", Options(**options)).figures


def rows(document: Any, **options: Any) -> tuple[str, dict[str, str], str]:
    """Return the verdict's status, that of each limit, and its text."""
    verdict = figures_of(document, **options).verdict
    return verdict.status, {row.name: row.status for row in verdict.limits}, verdict.text


def test_a_good_calibration_passes_as_far_as_it_was_evaluated(document) -> None:
    status, limits, text = rows(document)
    assert status == "pass"
    assert limits == {
        "mean_absolute_error": "pass",
        "distance_error": "pass",
        "between_placements": "not evaluated",
        "data_checks": "pass",
    }
    assert "Not evaluated: distances between placements." in text
    del document["checks"]
    _, limits, text = rows(document)
    assert limits["data_checks"] == "not evaluated"
    assert "Not evaluated: distances between placements and data checks." in text


@pytest.mark.parametrize("limit", ["mean_absolute_error", "distance_error"])
def test_a_limit_that_is_not_kept_fails(document, limit) -> None:
    status, limits, text = rows(document, **{limit: 1e-9})
    assert status == "fail" and limits[limit] == "fail"
    assert "limit 0.000 mm" in text


def test_without_held_out_data_nothing_is_validated(document) -> None:
    for key in ("data", "placements"):
        document[key] = [row for row in document[key] if row["role"] == "train"]
    document["summary"]["test"] = None
    status, limits, text = rows(document)
    assert status == "incomplete"
    assert limits["mean_absolute_error"] == "not evaluated"
    assert "held-out error (MAE)" in text


def test_the_error_alone_never_passes(document) -> None:
    """A model that shrinks to a point has no error at all."""
    document["model"]["name"] = document["model"]["source"] = "unheard_of"
    status, limits, _ = rows(document, mean_absolute_error=1.0)
    assert limits["mean_absolute_error"] == "pass"
    assert limits["distance_error"] == "not evaluated"
    assert status == "incomplete"


def test_an_unknown_arm_is_told_what_is_needed(document) -> None:
    document["model"]["name"] = document["model"]["source"] = "unheard_of"
    row = figures_of(document).verdict.limits[0]
    assert row.status == "not evaluated"
    assert "--repeatability-mm" in row.text
    status, _, _ = rows(document, repeatability=1e-4)
    assert status == "pass"


def test_errors_among_the_checks_fail_and_warnings_do_not(extended) -> None:
    assert rows(extended)[1]["data_checks"] == "pass"
    extended["checks"][0]["level"] = "error"
    assert rows(extended)[0] == "fail"


def test_known_distances_are_judged(document) -> None:
    figures = figures_of(document)
    a, b = (figures.placements[i].sockets[0].centre for i in (0, 1))
    length = sum((p - q) ** 2 for p, q in zip(a, b, strict=True)) ** 0.5
    good = [parse_known(f"front:0-left:0={length!r}+-0.0001")]
    bad = [parse_known(f"front:0-left:0={length + 1e-3!r}")]
    assert rows(document, known=good)[1]["between_placements"] == "pass"
    assert rows(document, known=bad)[1]["between_placements"] == "fail"


def test_distances_that_the_fit_was_told_prove_nothing(document) -> None:
    document["settings"]["known"] = ["front:0-left:0=0.4"]
    known = [parse_known("front:0-left:0=0.4")]
    assert rows(document, known=known)[1]["between_placements"] == "fail"
    for rows_of in (document["data"], document["placements"]):
        rows_of[1]["role"] = "train"
    assert rows(document, known=known)[1]["between_placements"] == "not evaluated"


def test_limits_are_no_finer_than_a_printed_socket_resolves(document) -> None:
    for name, limit in (("ur5e", 3e-4), ("iiwa14", 4.5e-4), ("gen3_lite", 3e-3)):
        document["model"]["name"] = name
        assert figures_of(document).limits.mean_absolute_error.value == pytest.approx(limit)


def test_every_shipped_robot_has_limits_and_is_known_by_its_names() -> None:
    assert set(ARMS) == set(shipped_robots())
    assert known_arm(["gen3lite"]) == "gen3_lite"
    assert known_arm(["lbr_iiwa_14_r820"]) is None or known_arm(["LBR-iiwa14"]) == "iiwa14"
    assert known_arm(["my_panda_on_a_ur5e"]) is None
    assert known_arm(["base", "panda"]) == "panda"


def test_the_command_says_by_its_status_whether_limits_are_kept(calibrated, tmp_path) -> None:
    words = ["report", str(calibrated / "calibration.json"), "--out", str(tmp_path)]
    assert main(words) == 0
    assert main([*words, "--limit-mae-mm", "0.001", "--force"]) == 1
    limit = json.loads((tmp_path / "report.json").read_text())["limits"]["mean_absolute_error"]
    assert limit == {"value": 1e-6, "source": "given by --limit-mae-mm"}
