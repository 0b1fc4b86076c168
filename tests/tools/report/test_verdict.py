"""The verdict: limits by arm, what fails, what was not evaluated, and the next steps."""

import json
import shlex
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from altered import moved, row_of, statuses
from cases import by_table
from recorded import RIGID, write_sockets
from worlds import measured_points

import mukca
from mukca.recorder import Sample
from mukca.solver.identification.data import IDENTITY
from mukca.solver.identification.robot import BallModel
from mukca.tools.cli import build_parser, main
from mukca.tools.report.figures import mending
from mukca.tools.simulation import perturb

pytestmark = pytest.mark.slow

KNOWN = "front:0-left:0="


@pytest.fixture
def rows(report):
    """Return the verdict's status, that of each limit, and its text."""

    def rows(document, *options):
        verdict = report(document, *options)["verdict"]
        return verdict["status"], statuses(verdict), verdict["text"]

    return rows


def test_a_good_calibration_passes_as_far_as_it_was_evaluated(document, report, rows):
    verdict = report(document)["verdict"]
    assert (verdict["status"], verdict["use"]) == ("pass", True)
    assert [row["name"] for row in verdict["limits"]] == ["mean_absolute_error", "distance_error"]
    assert not [row for row in verdict["reasons"] if row["status"] not in ("pass", "warning")]
    assert verdict["answer"][0].startswith("USE IT: load calibrated.urdf. It is better than your")
    del document["checks"]
    status, limits, text = rows(document)
    assert (status, limits["data_checks"]) == ("better", "not evaluated")
    assert "run mukca check" in text


@pytest.mark.parametrize(
    ("limit", "option"),
    [("mean_absolute_error", "--limit-mae-mm"), ("distance_error", "--limit-distance-mm")],
)
def test_a_limit_that_is_not_kept_holds_a_better_model_back(document, report, limit, option):
    verdict = report(document, option, "1e-4")["verdict"]
    assert (verdict["status"], verdict["kind"], verdict["use"]) == ("better", "better", True)
    assert verdict["title"] == "BETTER" and "limit of 0.000 mm" in verdict["answer"][1]
    assert statuses(verdict)[limit] in ("fail", "not enough")  # beyond its own deviation, or not


@pytest.mark.parametrize(
    ("options", "stamp", "colour", "shown"),
    [
        (["--limit-mae-mm", "9"], "PASS", "pass", 32),
        (["--limit-mae-mm", "1e-4"], "BETTER", "incomplete", 33),
    ],
)
def test_the_colour_says_what_the_words_say(
    document, written, read_page, options, stamp, colour, shown, monkeypatch, capsys
):
    """A limit that is missed is no success, in green neither on the page nor in a terminal."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    file = written(document)
    main(["report", str(file), *options])
    page = read_page(file.parent / "report.html")
    (classes,) = (each["class"] for each, _ in page.having("id") if each["id"] == "verdict")
    assert classes == f"verdict {colour}"
    assert f"\x1b[1;{shown}m{stamp}" in capsys.readouterr().out


def test_without_held_out_data_nothing_is_validated(document, rows):
    for key in ("data", "placements"):
        document[key] = [row for row in document[key] if row["role"] == "train"]
    document["summary"]["test"] = None
    status, limits, text = rows(document)
    assert status == "incomplete"
    assert limits["mean_absolute_error"] == "not evaluated"
    assert "Mean left-out error: nothing was left out" in text


def test_places_that_are_one_are_named_where_nothing_could_be_left_out(panda, session):
    front = mukca.read_placements(session / "front")[0]
    halves = [
        replace(front, name=f"session/{half}", samples=front.samples[half::2], files=())
        for half in (0, 1)
    ]
    (row,) = [
        row
        for row in mukca.calibrate(panda, halves, method="paper").verdict.reasons
        if row.name == "mean_absolute_error"
    ]
    assert row.reason.startswith("session/1 is at the place of session/0, or a part of it (0 mm")
    assert "so nothing could be left out" in row.reason


def copied(placement):
    """The same rows in another order, a bit off."""
    rows = moved(placement, placement.positions + 9e-4).samples[::-1]
    return replace(placement, name="session/again", samples=rows, files=())


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        (lambda p: (p, copied(p)), "session/again is a copy of session/front"),
        (
            lambda p: (
                replace(p, samples=p.samples[::2]),
                replace(p, name="session/half", samples=p.samples[1::2], files=()),
            ),
            "session/half is at the place of session/front, or a part of it (0 mm away)",
        ),
    ],
)
def test_what_was_trained_on_validates_nothing(panda, session, parts, words):
    train, again = parts(mukca.read_placements(session / "front")[0])
    elsewhere = mukca.read_placements(session / "left")[0]
    alone = mukca.calibrate(panda, train, test=again, method="paper").verdict
    assert (
        alone.status == "incomplete" and statuses(alone)["mean_absolute_error"] == "not evaluated"
    )
    held_out = row_of(alone, "held_out")
    assert words in held_out.text and "proves nothing" in held_out.text
    both = mukca.calibrate(panda, train, test=[again, elsewhere], method="paper")
    assert row_of(both.verdict, "held_out").status == "warning"
    assert row_of(both.verdict, "mean_absolute_error").found == pytest.approx(
        both.errors[2].calibrated.mean_absolute_error
    )


@pytest.mark.parametrize("repeated", [0.6, 1.0])
def test_a_plan_measured_anew_is_proof_where_it_has_postures_of_its_own(repeated):
    """A robot repeats its postures to 0.01 mrad, and an instrument measures each of them anew."""
    robot, generator = mukca.load_robot("ur5e"), np.random.default_rng(3)
    truth = perturb(robot, generator, 1e-3, 3e-3)
    train, other = (measured_points(truth, IDENTITY, generator, noise=3e-5) for _ in range(2))
    again = measured_again(truth, train, generator)
    count = int(repeated * len(train.samples))
    test = replace(again, name="again", samples=again.samples[:count] + other.samples[count:])
    without = ["compliance", "tilt", "play", "transmission", "curves", "joint-noise"]
    verdict = mukca.calibrate(robot, train, test=test, without=without).verdict
    error = row_of(verdict, "mean_absolute_error")
    if repeated == 1.0:
        assert "again repeats the postures of points" in error.text
    else:
        assert error.found is not None and "repeats" not in error.text


def measured_again(arm, placement, generator):
    """Return what an instrument measures of the same postures at another time."""
    q = placement.positions + generator.normal(0, 1e-5, placement.positions.shape)
    points = BallModel(arm, []).points(np.empty(0), q)
    points = points + generator.normal(0, 3e-5, points.shape)
    rows = zip(q.tolist(), points.tolist(), strict=True)
    samples = tuple(Sample(tuple(row), 0, point=tuple(point)) for row, point in rows)
    return replace(placement, samples=samples, files=())


def test_the_error_alone_never_passes(document, report, rows):
    """A model that shrinks to a point has no error at all; of an unknown arm more is needed."""
    document["model"]["name"] = document["model"]["source"] = "unheard_of"
    status, limits, _ = rows(document, "--limit-mae-mm", "900")
    assert limits["mean_absolute_error"] == "pass"
    assert limits["distance_error"] == "not evaluated"
    assert status == "better"
    verdict = report(document)["verdict"]
    assert verdict["kind"] == "better" and verdict["use"]  # only its limits are open
    assert "--repeatability-mm" in verdict["answer"][1]
    assert rows(document, "--repeatability-mm", "0.1")[0] == "pass"


def test_no_pass_stands_beside_a_warning_that_bears_on_the_model(extended, rows):
    assert rows(extended)[1]["data_checks"] == "pass"  # a sample that hardly counts is no matter
    extended["checks"][1]["code"] = "copies"
    status, limits, text = rows(extended)
    assert (status, limits["data_checks"]) == ("incomplete", "not enough")
    assert "Far from its socket; look at it" in text
    extended["checks"][0]["level"] = "error"
    assert rows(extended)[0] == "fail"


def test_a_drift_fails_nothing_that_was_held_out_bears_out(extended, rows):
    drift = {"level": "error", "code": "drift", "where": "front", "text": "a", "advice": "b"}
    extended["checks"] = [drift, {**drift, "code": "moved", "where": "front/hole_0.csv:3"}]
    assert rows(extended)[1]["data_checks"] == "not enough"
    assert rows(extended, "--limit-mae-mm", "0.01")[1]["data_checks"] == "fail"
    extended["checks"][1]["where"] = "left"
    assert rows(extended)[1]["data_checks"] == "fail"


def test_a_distorted_model_fails_whoever_asks(document, written, report):
    document["distorted"] = ["session/front"]
    assert mukca.load_calibration(written(document)).verdict.status == "fail"
    verdict = report(document)["verdict"]
    assert verdict["status"] == "fail" and "does not reproduce" in verdict["text"]


def test_the_report_says_what_a_pass_rests_on(document, report):
    figures = report(document)
    by_name = {one["name"]: one for one in figures["rests_on"]}
    assert by_name["distance"]["value"] == 0.05
    assert by_name["distance"]["effect"] == pytest.approx(0.002)
    answer = " ".join(figures["verdict"]["answer"])
    assert all(one["text"] in answer for one in by_name.values())
    limited = report(document, "--limit-mae-mm", "1e-4")["verdict"]
    assert limited["title"] == "BETTER"
    assert by_name["distance"]["text"] in " ".join(limited["answer"])


def test_nothing_is_called_firm_that_moved(document, report):
    moved = {"level": "warning", "code": "movement", "where": "front", "text": "a", "advice": "b"}
    document["checks"] = [moved]
    assert [one["name"] for one in report(document)["rests_on"]] == ["distance"]


def test_known_distances_are_statuses(document, report, rows):
    centres = [row["sockets"][0]["centre"] for row in report(document)["placements"]]
    length = float(np.linalg.norm(np.subtract(*centres[:2])))
    for known, status in ((f"{length!r}+-0.0001", "pass"), (f"{length + 1e-3!r}", "fail")):
        assert rows(document, "--known", KNOWN + known)[1]["between_placements"] == status


def test_distances_that_the_fit_was_told_prove_nothing(document, rows):
    known = [f"{KNOWN}0.4"]
    document["settings"]["known"] = known
    assert rows(document, "--known", *known)[1]["between_placements"] == "fail"
    for rows_of in (document["data"], document["placements"]):
        rows_of[1]["role"] = "train"
    assert rows(document, "--known", *known)[1]["between_placements"] == "not evaluated"


def test_limits_are_no_finer_than_a_printed_socket_resolves(document, report):
    for name, limit in (("ur5e", 3e-4), ("iiwa14", 4.5e-4), ("gen3_lite", 3e-3)):
        document["model"]["name"] = name
        found = report(document)["limits"]["mean_absolute_error"]["value"]
        assert found == pytest.approx(limit)


@pytest.mark.parametrize(("servos", "times"), [(False, 1), (True, 2)])
def test_play_leaves_the_mean_of_a_socket_no_better_than_a_sample(document, report, servos, times):
    document["settings"]["zeros"] = servos
    limits = report(document, "--repeatability-mm", "2")["limits"]
    assert limits["distance_error"]["value"] == pytest.approx(times * 2e-3)
    assert limits["mean_absolute_error"]["value"] == pytest.approx(6e-3)
    assert report(document)["limits"]["distance_error"]["value"] == pytest.approx(times * 1e-4)


def test_a_repeatability_below_what_a_socket_resolves_is_not_ignored_unsaid(
    document, written, command, tmp_path
):
    words = ("report", written(document), "--out", tmp_path / "out", "--repeatability-mm")
    told = "limits go by the 0.1 mm that a printed socket resolves"
    assert told in " ".join(command(*words, "0.03")[1].split())
    assert told not in " ".join(command(*words, "0.1", "--force")[1].split())


@by_table("name", "arm")
def test_an_arm_is_known_by_its_name(document, written, name, arm):
    document["model"]["name"] = document["model"]["source"] = name
    limits = mukca.load_calibration(written(document)).assessment.limits
    assert limits.repeatability_source.startswith(f"{arm}: ") == (limits.repeatability is not None)
    assert (limits.repeatability is not None) == (arm is not None)


def test_the_command_says_by_its_status_whether_limits_are_kept(calibrated, tmp_path):
    words = ["report", str(calibrated / "calibration.json"), "--out", str(tmp_path)]
    assert main(words) == 0
    assert main([*words, "--limit-mae-mm", "0.001", "--force"]) == 1
    limit = json.loads((tmp_path / "report.json").read_text())["limits"]["mean_absolute_error"]
    assert limit == {"value": 1e-6, "source": "given by --limit-mae-mm"}


def with_geometric(document, error):
    """A document whose URDF alone is less accurate than the full model."""
    for row in (document["summary"]["test"], document["summary"]["train"]):
        row["geometric"] = {**row["calibrated"], "mean_absolute_error": error}
    return document


def test_the_urdf_alone_is_judged_and_the_full_model_stands_beside_it(document, report, rows):
    verdict = report(with_geometric(document, 0.5e-3))["verdict"]
    row = verdict["limits"][0]
    assert (verdict["status"], verdict["kind"], verdict["use"]) == ("better", "better", True)
    assert (row["status"], row["full_status"], row["found"]) == ("fail", "pass", 0.5e-3)
    assert row["full"] == document["summary"]["test"]["calibrated"]["mean_absolute_error"]
    for key in ("data", "placements"):  # with one held out, none is left to train on
        document[key] = [row for row in document[key] if not row["name"].endswith("right")]
    (step,) = report(with_geometric(document, 0.5e-3))["todo"]
    file = document["outputs"]["calibration"]
    assert step["command"] == f"mukca command {Path(file).parent} poses.csv --out joints.csv"
    assert step["before"] == 0.5e-3
    (step,) = report({**with_geometric(document, 0.5e-3), "outputs": {}})["todo"]
    assert step["command"].startswith("mukca command DIR ")
    assert rows(with_geometric(document, 0.2e-3))[0] == "pass"
    worse = report(with_geometric(document, 1.0))["verdict"]
    assert (worse["status"], worse["kind"], worse["use"]) == ("incomplete", "no_better", False)
    assert worse["title"] == "NO BETTER" and worse["answer"][0].startswith("DO NOT LOAD IT")


def test_the_step_names_the_folder_that_was_written(panda, tmp_path, command):
    """Of an arm that bends, whose URDF alone misses the limits; the report says the same."""
    _, bending = mukca.simulate_recordings(panda, 3, seed=3, samples=12, compliance=3e-4)
    for placement in bending:
        write_sockets(tmp_path / placement.name, placement)
    *train, test = [tmp_path / placement.name for placement in bending]
    words = ("solve", *train, "--test", test, "--robot", "panda", "--distance", "0.05")
    out = tmp_path / "results 1.0"
    said = command(*words, "--without", "tilt", "transmission", "--out", out)[1]
    assert f"mukca command '{out}' poses.csv --out joints.csv" in said
    assert "is up to date" in command("report", out)[1]


@by_table("value", "deviation", "expected", "status")
def test_an_arm_of_the_wrong_size_does_not_pass(document, value, deviation, expected, status, rows):
    document["scale"] = {"value": value, "deviation": deviation}
    told, limits, text = rows(document)
    assert (told, limits["scale"]) == (status, expected)
    badly_known = "record more samples" in text
    assert badly_known == (value == -0.0121)
    measure = (
        "or every length of the model is" in text and "--distance FIRST --distance SECOND" in text
    )
    assert measure == (expected != "pass" and not badly_known)


def test_what_may_explain_the_size_is_said(document, rows):
    document["scale"] = {"value": 0.02, "deviation": 7e-4}
    for row in (*document["placements"], *document["data"]):
        row["distance"] = 0.051
    text = rows(document)[2]
    assert "The arm came out 2.00 % longer (+- 0.07 %) than its model" in text
    assert "the sockets are 50.0 mm apart, or every length of the model is 2.00 % off" in text


@pytest.mark.parametrize(
    ("deviation", "status"), [(0.017, "not enough"), (0.003, "warning"), (None, "warning")]
)
def test_the_papers_method_passes_no_arm_whose_size_it_does_not_know(
    document, report, deviation, status
):
    """It predicts no error of distances: an arm 16 mm off passed, 0.9 +- 1.7 % too long."""
    document["scale"] = {"value": 0.009, "deviation": deviation}
    verdict = report(document)["verdict"]
    row = next(row for row in verdict["reasons"] if row["name"] == "known")
    assert row["status"] == status and (status == "warning" or verdict["status"] != "pass")
    assert ("known to 1.7 % only" in row["text"]) == (status == "not enough")


@pytest.mark.parametrize("code", ["sign", "swap", "zero", "model"])
def test_joints_are_to_be_mended_before_the_distance(document, code, report):
    """Where a joint is wrong, the arm's size is, too, and no distance is likelier."""
    document["scale"] = {"value": 0.02, "deviation": 7e-4}
    said = {"level": "error", "code": code, "where": "all placements", "text": "x", "advice": "y"}
    document["checks"] = [*document["checks"], said]
    figures = report(document)
    assert "mend them before the distance" in figures["verdict"]["text"]
    assert "the sockets are" not in figures["verdict"]["text"]
    assert not any("MEASURED" in step["command"] for step in figures["todo"])


def test_the_twelve_most_alike_samples_do_not_pass(recordings):
    """They are too few and too alike to show what the arm does elsewhere."""
    folder = recordings / "panda_3"
    (placement,) = mukca.read_placements(folder / "frontcenter")
    kept = []
    for socket in (0, 1):
        own = [sample for sample in placement.samples if sample.socket == socket]
        middle = np.median([sample.position for sample in own], axis=0)
        own.sort(key=lambda sample: np.abs(sample.position - middle).max())
        kept += own[:12]
    alike = replace(placement, samples=tuple(kept))
    test = mukca.read_placements(folder / "backleft")
    calibration = mukca.calibrate(mukca.load_robot("panda"), [alike], test=test)
    assert calibration.verdict.status != "pass"


def test_a_large_predicted_error_holds_it_back(extended, report):
    passing = report(extended)["verdict"]
    assert statuses(passing)["predicted_distance"] == "pass"
    assert not any("record" in row["text"] for row in passing["limits"])
    extended["uncertainty"]["distance_deviation"] = {"median": 3.8e-3, "worst": 9e-3}
    verdict = report(extended)["verdict"]
    assert (verdict["kind"], statuses(verdict)["predicted_distance"]) == ("better", "not enough")
    assert "are wrong by 3.80 mm, and 0.90 mm is allowed; record" in verdict["text"]


def test_a_pass_claims_no_more_than_its_rows(extended, report):
    """The URDF alone is not the full model: how far it is from it counts, near and far."""
    known = {"median": 3e-4, "worst": 9e-3, "alone": 8e-4}
    extended["uncertainty"]["near"] = known
    for alone, scope in ((8.9e-4, "workspace"), (1.1e-3, "recorded_places")):
        extended["uncertainty"]["distance_deviation"] = {**known, "alone": alone}
        verdict = report(extended)["verdict"]
        assert (verdict["status"], verdict["scope"]) == ("pass", scope)
        assert verdict["title"].startswith("PASS near the recorded") == (scope != "workspace")
        row = verdict["limits"][-1]
        assert (row["found"], row["full"], row["full_status"]) == (alone, 3e-4, "pass")
    extended["uncertainty"]["near"] = {**known, "alone": 1.1e-3}
    verdict = report(extended)["verdict"]
    assert (verdict["status"], verdict["kind"]) == ("better", "better")


@pytest.mark.parametrize(
    ("limit", "allowed"), [("0.3", 9e-4), ("0.6", 1.8e-3), ("1.5", 2e-3), ("6", 6e-3)]
)
def test_arms_that_repeat_worse_may_not_know_distances_ever_worse(extended, report, limit, allowed):
    for found, expected in ((0.99 * allowed, "pass"), (1.01 * allowed, "not enough")):
        extended["uncertainty"]["distance_deviation"] = {"median": found, "worst": 9e-3}
        row = report(extended, "--limit-mae-mm", limit)["verdict"]["limits"][-1]
        assert row["status"] == expected and row["limit"] == pytest.approx(allowed)


def test_no_distance_is_asked_to_be_known_better_than_links_are(extended, rows):
    known = {"median": 1.4e-3, "worst": 9e-3}
    for length, expected in ((0.8, "not enough"), (1.3, "not enough"), (1.5, "pass")):
        extended["uncertainty"]["distance_deviation"] = {**known, "length": length}
        assert rows(extended)[1]["predicted_distance"] == expected, length


def test_whatever_is_not_a_pass_says_what_to_do_next(document, report):
    assert "todo" not in report(document)
    todo = report(with_geometric(document, 1.5e-3))["todo"]
    assert len(todo) == 1
    first = shlex.split(todo[0]["command"])
    assert "Train on" in todo[0]["text"]
    assert len(first[first.index("solve") + 1 : first.index("--test")]) == 2
    document["scale"] = {"value": 0.02, "deviation": 7e-4}
    step = report(document)["todo"][0]
    assert "--distance 0.05 --distance MEASURED" in step["command"]
    assert (
        "then known to 0.35 mm instead of 10.00 mm" in step["expected"] and step["before"] == 0.01
    )
    document["settings"]["distance"] = 0.051
    wrong = {"level": "error", "code": "distance", "where": "front", "text": "a", "advice": "b"}
    document["checks"] = [wrong]
    todo += report(document)["todo"]
    assert todo[-1]["command"].startswith("mukca check")
    assert "--distance 0.051" in todo[-1]["command"]
    for step in todo:  # each can be copied: its verb and options exist
        words = shlex.split(step["command"].replace("MEASURED", "0.05"))[1:]
        build_parser(words[0]).parse_args(words)


def untested(document, count):
    """A calibration trained on the first placements of the session, and on nothing else."""
    for key in ("data", "placements"):
        document[key] = document[key][:count]
        for row in document[key]:
            row["role"] = "train"
    document["summary"]["test"] = None
    return document


def test_another_placement_is_recorded_beside_the_others(document, report):
    (row,) = untested(document, 1)["data"]
    front = Path("elsewhere") / Path(row["files"][0]).parent.name
    for folder, out in (("front", "another"), ("another", "another-2")):
        row["files"] = [str(front.parent / folder / Path(file).name) for file in row["files"]]
        (step,) = report(document)["todo"]
        assert step["command"].endswith(f" --out {front.parent / out}")
        assert "to its left, 0.10 up, 0." in step["text"].replace(" m", "")
    row["files"] = [Path(file).name for file in row["files"]]  # of a solve in the placement itself
    assert report(document)["todo"][0]["command"].endswith(" --out ../another")


def test_a_simulated_arm_is_recorded_at_its_next_base(document, report, tmp_path):
    (row,) = untested(document, 1)["data"]
    hand = tmp_path / "hand"
    for name in ("front", "left"):
        (hand / name).mkdir(parents=True)
        (hand / name / "samples.csv").touch()
    folder = tmp_path / "recordings" / "front"
    folder.mkdir(parents=True)
    row["files"] = [str(folder / Path(file).name) for file in row["files"]]
    for name, proposed in (("front", f"mock:{hand}/left?follow"), ("left", "NAME:ADDRESS")):
        metadata = {"sessions": [{"driver": f"mock:{hand}/{name}?follow"}]}
        (folder / "placement.json").write_text(json.dumps(metadata))
        command = shlex.split(report(document)["todo"][0]["command"])
        assert command[command.index("--driver") + 1] == proposed


def test_what_lies_beside_the_recordings_is_not_recorded_again(document, report, session):
    figures = report(untested(document, 1))
    (step,) = figures["todo"]
    assert step["text"] == "Train on right and left too, recorded already beside the others"
    assert "nothing was left out" in figures["verdict"]["text"]  # the step says how to
    words = shlex.split(step["command"])
    assert words[2:4] == [str(session), "--robot"]  # the folder stands for all three
    document["settings"]["leave_out"] = ["left"]
    (step,) = report(document)["todo"]
    assert step["text"].startswith("Train on right too, recorded already")


def test_what_was_not_to_be_proven_is_left_out_next(document, report):
    untested(document, 2)["settings"]["no_proof"] = True
    (step,) = report(document)["todo"]
    assert step["text"].startswith("Leave each place out once")
    assert "--no-proof" not in step["command"] and "--test" not in step["command"]


def test_each_step_says_what_it_should_bring(extended, report):
    """By the figure of the answer; and one that should make it worse is no step."""
    interval = {"value": 4e-4, "low": 3e-4, "high": 5e-4}
    extended["better"] = {"workspace": {"before": interval, "now": interval, "probability": 0.99}}
    one, other = [row["name"] for row in extended["placements"][1:3]]
    shares = {one: 0.75, other: 0.6, None: 0.5}
    forecasts = [
        {"placement": name, "distance_deviation": 9e-5, "share": share}
        for name, share in shares.items()
    ]
    extended["outlook"] = {"joints": [], "forecasts": forecasts}
    (step,) = report(extended, "--limit-mae-mm", "0.001")["todo"]
    assert step["text"].startswith("Train") and step["before"] == 4e-4
    assert step["after"] in (pytest.approx(3e-4), pytest.approx(2.4e-4))
    assert f"about {1e3 * step['after']:.2f} mm in place of 0.40" in step["expected"]
    for row in forecasts[:2]:
        row["share"] = 1.2
    (step,) = report(extended, "--limit-mae-mm", "0.001")["todo"]
    assert step["text"].startswith("Record another placement") and step["after"] == 2e-4
    del extended["outlook"]
    (step,) = report(extended, "--limit-mae-mm", "0.001")["todo"]
    assert step["expected"] == "no forecast: only --method auto makes one"


@pytest.mark.parametrize(("share", "asked"), [(2.9e-3, False), (3.1e-3, True)])
def test_a_base_is_read_again_where_the_arm_came_out_longer(document, report, share, asked):
    """Though it passes; and no more once two readings agree."""
    document["scale"] = {"value": share, "deviation": 7e-4}
    figures = report(document)
    assert figures["verdict"]["status"] == "pass"
    steps = figures.get("todo", [])
    assert [" --distance MEASURED" in step["command"] for step in steps] == [True] * asked
    for row in document["placements"]:
        row["distance_readings"] = 2
    assert "todo" not in report(document)


def test_no_step_is_to_train_on_what_is_wrong(document, report, monkeypatch):
    where = "/home/me/session/left/hole_1.csv:3"
    wrong = {"level": "error", "code": "moved", "text": "it moved", "advice": "", "where": where}
    document["checks"] = [wrong]
    (again,) = report(document)["todo"]
    assert again["text"].startswith("Record left again")
    assert again["command"].startswith("mukca record")
    document["data"][1]["role"] = document["placements"][1]["role"] = "train"
    (again,) = report(document)["todo"]
    assert again["text"].startswith("Record left again")  # all is worse without it
    errors = (SimpleNamespace(mean_absolute_error=error) for error in (2e-3, 1e-3))
    monkeypatch.setattr(mending, "evaluate", lambda points, measured: next(errors))
    (out,) = report(document, "--limit-mae-mm", "0.001")["todo"]
    assert out["text"] == "Leave out left"
    assert "left" not in out["command"] and out["before"] and out["after"]
    assert "the held-out error by Eq. (5) goes from" in out["expected"]


@pytest.mark.parametrize(("error", "again"), [(1.0, True), (0.5e-3, False)])
def test_a_placement_that_moved_is_recorded_again_unless_the_file_is_better(
    document, report, error, again
):
    """Before anything is trained on beside it; one that is held out made the file no worse."""
    for where in ("session/front", "session/left"):
        moved = {"level": "warning", "code": "movement", "text": "a", "advice": "b", "where": where}
        document["checks"] = [moved]
        (step,) = report(with_geometric(document, error))["todo"]
        is_trained = where == "session/front"
        assert step["text"].startswith("Record front again") == (again and is_trained)


def test_a_held_out_distance_is_held_to_what_is_known_of_it(panda, session):
    """An arm that repeats to 1 mm knows the distance of two means far better."""
    train, left = (mukca.read_placements(session / name)[0] for name in ("front", "left"))
    for distance, expected in ((0.05, "pass"), (0.0503, "not enough")):
        test = replace(left, distance=distance)
        found = mukca.calibrate(panda, train, test=test, repeatability_mm=1.0, **RIGID).verdict
        assert statuses(found)["distance_error"] == "pass"
        assert statuses(found)["distance_deviations"] == expected
    assert found.kind == "better" and "moved between its sockets" in found.text


def test_a_drift_that_the_fit_has_weighed_is_not_weighed_again(panda, session, monkeypatch):
    """Nor where no times say which socket was first: it weighs both orders."""
    (placement,) = mukca.read_placements(session / "front")
    drift = "mukca.solver.assessment.drift.steady_drift"
    for as_recorded, length, said in (
        (True, 1e-2, "not enough"),
        (True, 1e-3, "warning"),  # the calibration gains more
        (False, 1e-2, "pass"),
    ):
        monkeypatch.setattr(drift, lambda placement, length=length: (1.0, length))
        found = mukca.calibrate(panda, placement, as_recorded=as_recorded, **RIGID)
        assert statuses(found.verdict)["drift"] == said


def test_a_base_that_creeps_is_no_pass_where_it_was_trained(panda, session, tmp_path):
    """It turns about the first joint, by 1 mm from the first sample to the last."""
    train, left = (mukca.read_placements(session / name)[0] for name in ("front", "left"))
    sound = mukca.calibrate(panda, train, test=left, method="paper").verdict
    assert statuses(sound)["drift"] == "pass" == statuses(sound)["drift_held_out"]
    for turn, said in ((5e-4, "pass"), (1e-3, "not enough"), (2e-3, "not enough")):
        crept = moved(train, train.positions + turn * np.outer(np.arange(24) / 24, np.eye(7)[0]))
        trained = mukca.calibrate(panda, crept, test=left, method="paper").verdict
        assert statuses(trained)["drift"] == said and (said == "pass" or trained.status != "pass")
    mukca.write_report(mukca.calibrate(panda, crept, test=left, method="paper"), tmp_path / "crept")
    (step,) = json.loads((tmp_path / "crept" / "report.json").read_text())["todo"]
    assert step["text"].startswith("Record front again")  # as the answer says
    found = mukca.calibrate(panda, left, test=crept, method="paper")
    held = statuses(found.verdict)
    assert (held["drift"], held["drift_held_out"]) == ("pass", "warning")
    mukca.write_report(found, tmp_path)
    answers = json.loads((tmp_path / "report.json").read_text())["answers"]
    assert answers["data"]["text"].startswith("Yes, but the ball drifts in its sockets")


@pytest.mark.parametrize("zeros", [False, True])
def test_a_place_that_became_worse_is_named(document, report, zeros):
    before = report(document)["verdict"]
    assert before["use"] and not any("worse than" in line for line in before["answer"])
    row = next(row for row in document["placements"] if row["role"] == "test")
    (row["ball_refitted"] or row["nominal"])["mean_absolute_error"] = 1e-6
    document["settings"]["zeros"] = zeros
    after = report(document)["verdict"]["answer"]
    (line,) = (line for line in after if "worse than your file (0.001 mm ->" in line)
    assert f"At {row['name']} " in line and ("zeros" in line) is zeros
