"""The verdict: limits by arm, what fails, and what was not evaluated."""

import json
import shlex
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
import pytest

import mukca
from mukca.recorder import Sample
from mukca.solver.assessment import ARMS, Coverage, Options, known_arm, measurements_of
from mukca.solver.assessment.data_sufficiency import prediction_row, travel_row
from mukca.solver.assessment.limits import Limit
from mukca.solver.calibration import Calibration
from mukca.solver.data import parse_known
from mukca.solver.results import (
    CalibrationDocument,
    DistanceDeviation,
    Scale,
    Uncertainty,
    calibrated_robot,
)
from mukca.solver.robot import shipped_robots
from mukca.tools.cli import build_parser, main
from mukca.tools.report import build_report
from mukca.tools.report.figures import ReportDocument


def figures_of(document: Any, **options: Any) -> ReportDocument:
    """Return the figures of a calibration's document."""
    return build_report(decode_(document), "", Options(**options)).figures


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
        "scale": "pass",
        "samples": "pass",
        "travel": "pass",
        "predicted_distance": "not evaluated",
    }
    missing = "Not evaluated: distances between placements"
    assert f"{missing} and predicted error of distances." in text
    del document["checks"]
    _, limits, text = rows(document)
    assert limits["data_checks"] == "not evaluated"
    assert f"{missing}, data checks and predicted error of distances." in text


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


@pytest.mark.slow
def test_errors_among_the_checks_fail_and_warnings_do_not(extended) -> None:
    assert rows(extended)[1]["data_checks"] == "pass"
    extended["checks"][0]["level"] = "error"
    assert rows(extended)[0] == "fail"


@pytest.mark.slow
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


@pytest.mark.slow
def test_limits_are_no_finer_than_a_printed_socket_resolves(document) -> None:
    for name, limit in (("ur5e", 3e-4), ("iiwa14", 4.5e-4), ("gen3_lite", 3e-3)):
        document["model"]["name"] = name
        assert figures_of(document).limits.mean_absolute_error.value == pytest.approx(limit)


@pytest.mark.parametrize(("servos", "times"), [(False, 1), (True, 2)])
def test_play_leaves_the_mean_of_a_socket_no_better_than_a_sample(document, servos, times) -> None:
    document["settings"]["zeros"] = servos
    limits = figures_of(document, repeatability=2e-3).limits
    assert limits.distance_error.value == times * 2e-3 and limits.mean_absolute_error.value == 6e-3
    assert figures_of(document).limits.distance_error.value == pytest.approx(times * 1e-4)


def test_a_shipped_robot_is_known_by_its_names() -> None:
    assert set(ARMS) < set(shipped_robots())
    assert all(known_arm([name]) == name for name in ARMS)
    assert known_arm(["ur5e_on_a_table"]) == "ur5e" and known_arm(["my-ur5"]) == "ur5"
    assert known_arm(["ur30"]) is None and known_arm(["so101", "ur5"]) is None
    assert known_arm(["gen3lite"]) == "gen3_lite"
    assert known_arm(["lbr_iiwa_14_r820"]) is None or known_arm(["LBR-iiwa14"]) == "iiwa14"
    assert known_arm(["my_panda_on_a_ur5e"]) is None
    assert known_arm(["base", "panda"]) == "panda"


@pytest.mark.slow
def test_the_command_says_by_its_status_whether_limits_are_kept(calibrated, tmp_path) -> None:
    words = ["report", str(calibrated / "calibration.json"), "--out", str(tmp_path)]
    assert main(words) == 0
    assert main([*words, "--limit-mae-mm", "0.001", "--force"]) == 1
    limit = json.loads((tmp_path / "report.json").read_text())["limits"]["mean_absolute_error"]
    assert limit == {"value": 1e-6, "source": "given by --limit-mae-mm"}


def with_geometric(document: Any, error: float) -> Any:
    """A document whose URDF alone is less accurate than the full model."""
    for row in (document["summary"]["test"], document["summary"]["train"]):
        row["geometric"] = {**row["calibrated"], "mean_absolute_error": error}
    return document


def test_the_urdf_alone_is_judged_and_both_answers_are_named(document) -> None:
    verdict = figures_of(with_geometric(document, 0.5e-3)).verdict
    row = verdict.limits[0]
    assert verdict.status == "fail"
    assert verdict.title == "PASS with the corrected joint positions; the URDF alone: FAIL"
    assert (row.status, row.full_status, row.found) == ("fail", "pass", 0.5e-3)
    assert row.full == document["summary"]["test"]["calibrated"]["mean_absolute_error"]
    assert rows(with_geometric(document, 0.2e-3))[0] == "pass"


def test_where_both_models_fail_there_is_one_answer(document) -> None:
    verdict = figures_of(with_geometric(document, 0.5e-3), mean_absolute_error=1e-9).verdict
    assert verdict.status == "fail" and verdict.title == "FAIL"


@pytest.mark.parametrize(
    ("value", "deviation", "expected", "status"),
    [
        (0.002, 1e-4, "pass", "pass"),
        (0.005, 0.002, "pass", "pass"),
        (0.005, 0.001, "warning", "pass"),
        (-0.005, None, "warning", "pass"),
        (0.0021, 7e-4, "pass", "pass"),
        (0.0055, 7e-4, "warning", "pass"),
        (0.0087, 7e-4, "fail", "fail"),
        (-0.0062, None, "fail", "fail"),
        (0.0075, 0.0017, "warning", "pass"),
        (-0.0121, 0.009, "not enough", "incomplete"),
        (0.03, 0.009, "fail", "fail"),
        (0.02, 7e-4, "fail", "fail"),
        (-0.583, None, "fail", "fail"),
    ],
)
def test_an_arm_of_the_wrong_size_does_not_pass(
    document, value, deviation, expected, status
) -> None:
    document["scale"] = {"value": value, "deviation": deviation}
    told, limits, text = rows(document)
    assert (told, limits["scale"]) == (status, expected)
    assert ("more likely the sockets" in text) == (expected in ("warning", "fail"))
    assert ("record more samples" in text) == (expected == "not enough")


def test_the_likelier_distance_is_said(document) -> None:
    document["scale"] = {"value": 0.02, "deviation": 7e-4}
    for row in (*document["placements"], *document["data"]):
        row["distance"] = 0.051
    text = rows(document)[2]
    assert "The arm came out 2.00 % longer (+- 0.07 %) than its model" in text
    assert "more likely the sockets are 50.0 mm apart than 51.0" in text


@pytest.mark.parametrize(
    ("deviation", "status"),
    [(0.017, "not enough"), (0.003, "not evaluated"), (None, "not evaluated")],
)
def test_the_papers_method_passes_no_arm_whose_size_it_does_not_know(deviation, status) -> None:
    """It predicts no error of distances: an arm 16 mm off passed, 0.9 +- 1.7 % too long."""
    scale = Scale(value=0.009, deviation=deviation)
    nowhere = Coverage(joints=(), sockets=())
    row = prediction_row(None, Limit(value=3e-4, source=""), "paper", nowhere, scale)
    assert row.status == status
    assert ("known to 1.7 % only" in row.text) == (status == "not enough")


@pytest.mark.parametrize("code", ["sign", "swap", "zero", "model"])
def test_joints_are_to_be_mended_before_the_distance(document, code) -> None:
    """Where a joint is wrong, the arm's size is, too, and no distance is likelier."""
    document["scale"] = {"value": 0.02, "deviation": 7e-4}
    said = {"level": "error", "code": code, "where": "all placements", "text": "x", "advice": "y"}
    document["checks"] = [*document["checks"], said]
    figures = figures_of(document)
    assert "mend them before the distance" in figures.verdict.text
    assert "more likely the sockets" not in figures.verdict.text
    assert not any("--distance 0.0490" in step.command for step in figures.todo)


def test_few_samples_are_not_enough_to_say(document) -> None:
    for row in document["data"]:
        by_socket = [[s for s in row["samples"] if s["socket"] == k] for k in (0, 1)]
        row["samples"] = [s for those in by_socket for s in those[:5]]
    for row in document["placements"]:
        row["samples"] = [5, 5]
    calibration = calibrated_robot(decode_(document), "")
    errors = Calibration(decode_(document), calibration)
    again = errors.errors_of(measurements_of(errors.document, calibration.robot, ""))
    document["placements"] = json.loads(json.dumps([row.as_dict() for row in again]))
    verdict = figures_of(document).verdict
    assert verdict.status == "incomplete" and verdict.title == "NOT ENOUGH DATA TO SAY"
    assert "record at least 10 in each" in verdict.text


def decode_(document: Any) -> CalibrationDocument:
    return msgspec.convert(json.loads(json.dumps(document)), CalibrationDocument)


def test_a_joint_that_stood_still_leaves_it_open(document) -> None:
    covered = figures_of(document).coverage
    assert travel_row(covered).status == "pass"
    first = covered.sockets[0].low[2]
    sockets = tuple(
        msgspec.structs.replace(
            socket,
            low=(*socket.low[:2], first, *socket.low[3:]),
            high=(*socket.high[:2], first + 0.3, *socket.high[3:]),
        )
        for socket in covered.sockets
    )
    narrow = msgspec.structs.replace(covered, sockets=sockets)
    row = travel_row(narrow)
    assert row.status == "not enough" and "panda_joint3 turned by 17 deg" in row.text
    row = prediction_row(uncertainty(4e-3), Limit(value=3e-4, source=""), "auto", narrow)
    assert "more varied samples (panda_joint3 turned by 17 deg only), and a second" in row.text


@pytest.mark.slow
def test_the_twelve_most_alike_samples_do_not_pass(recordings) -> None:
    """They are too few and too alike to show what the arm does elsewhere."""
    folder = recordings / "panda_3"
    (placement,) = mukca.read_placements(folder / "frontcenter")
    kept: list[Sample] = []
    for socket in (0, 1):
        own = [sample for sample in placement.samples if sample.socket == socket]
        middle = np.median([sample.position for sample in own], axis=0)
        own.sort(key=lambda sample: np.abs(sample.position - middle).max())
        kept += own[:12]
    alike = replace(placement, samples=tuple(kept))
    test = mukca.read_placements(folder / "backleft")
    calibration = mukca.calibrate(mukca.load_robot("panda"), [alike], test=test)
    assert calibration.verdict.status != "pass"


def test_a_large_predicted_error_leaves_it_open(extended) -> None:
    assert rows(extended)[1]["predicted_distance"] == "pass"
    extended["uncertainty"]["distance_deviation"] = {"median": 3.8e-3, "worst": 9e-3}
    figures = figures_of(extended)
    limits = {row.name: row.status for row in figures.verdict.limits}
    assert (figures.verdict.status, limits["predicted_distance"]) == ("incomplete", "not enough")
    assert "are known to 3.80 mm only" in figures.verdict.text
    assert figures.answers.use.text.endswith("see first what it lacks.")


@pytest.mark.parametrize(
    ("limit", "allowed"), [(3e-4, 9e-4), (6e-4, 1.8e-3), (1.5e-3, 2e-3), (6e-3, 6e-3)]
)
def test_arms_that_repeat_worse_may_not_know_distances_ever_worse(limit, allowed) -> None:
    nowhere = Coverage(joints=(), sockets=())
    for found, expected in ((0.99 * allowed, "pass"), (1.01 * allowed, "not enough")):
        row = prediction_row(uncertainty(found), Limit(value=limit, source=""), "auto", nowhere)
        assert row.status == expected and row.limit == pytest.approx(allowed)


def uncertainty(median: float) -> Uncertainty:
    return Uncertainty(
        weak_directions=(),
        correlations=(),
        observability_index=0.01,
        distance_deviation=DistanceDeviation(median=median, worst=9e-3),
        cannot_see=(),
    )


@pytest.mark.slow
def test_no_distance_is_asked_to_be_known_better_than_links_are(extended) -> None:
    known = {"median": 1.4e-3, "worst": 9e-3}
    for length, expected in ((0.8, "not enough"), (1.3, "not enough"), (1.5, "pass")):
        extended["uncertainty"]["distance_deviation"] = {**known, "length": length}
        assert rows(extended)[1]["predicted_distance"] == expected, length


@pytest.mark.slow
def test_whatever_is_not_a_pass_says_what_to_do_next(document) -> None:
    assert figures_of(document).todo == ()
    todo = figures_of(with_geometric(document, 0.5e-3)).todo
    first = shlex.split(todo[0].command)
    assert "Train on" in todo[0].text
    assert len(first[first.index("solve") + 1 : first.index("--test")]) == 2
    document["scale"] = {"value": 0.02, "deviation": 7e-4}
    todo = figures_of(document).todo
    assert "--distance 0.04902" in todo[0].command
    assert "falls from 10.00 mm to 0.35 mm" in todo[0].expected and todo[0].before == 0.01
    document["settings"]["distance"] = 0.051
    wrong = {"level": "error", "code": "distance", "where": "front", "text": "a", "advice": "b"}
    document["checks"] = [wrong]
    checks = [s.command for s in figures_of(document).todo if s.command.startswith("mukca check")]
    assert checks and all("--distance 0.051" in command for command in checks)
    for step in todo:  # each can be copied: its verb and options exist
        words = shlex.split(step.command)[1:]
        build_parser(words[0]).parse_args(words)


@pytest.mark.slow
def test_each_step_says_what_it_should_bring(extended) -> None:
    extended["outlook"] = {
        "joints": [{"joint": "panda_joint1", "recorded": 1e-3, "workspace": 2e-3}],
        "forecasts": [
            {"placement": extended["placements"][1]["name"], "distance_deviation": 9e-5},
            {"placement": extended["placements"][2]["name"], "distance_deviation": 8e-5},
            {"placement": None, "distance_deviation": 7e-5},
        ],
    }
    todo = figures_of(extended, mean_absolute_error=1e-6).todo
    more, another = (next(s for s in todo if s.text.startswith(w)) for w in ("Train", "Record"))
    assert more.before == another.before == 1.25e-4
    assert more.after in (9e-5, 8e-5) and another.after == 7e-5
    assert more.expected.endswith("falls from 0.12 mm to " + f"{1e3 * more.after:.2f} mm")
    assert all(step.expected for step in todo)
    del extended["outlook"]
    assert "not told" in figures_of(extended, mean_absolute_error=1e-6).todo[-1].expected


@pytest.mark.slow
def test_no_step_is_to_train_on_what_is_wrong(document) -> None:
    document["checks"] = [
        {"level": "error", "code": "moved", "text": "it moved", "advice": "", "where": where}
        for where in ("/home/me/session/left/hole_1.csv:3",)
    ]
    todo = figures_of(document, mean_absolute_error=1e-6).todo
    assert not [step for step in todo if step.text.startswith("Train on left")]
    assert [step for step in todo if step.text.startswith("Train on right")]
    document["data"][1]["role"] = document["placements"][1]["role"] = "train"
    todo = figures_of(document, mean_absolute_error=1e-6).todo
    out = next(step for step in todo if step.text == "Leave out left")
    assert "left" not in out.command and out.before and out.after
    assert "the held-out error by Eq. (5) goes from" in out.expected
