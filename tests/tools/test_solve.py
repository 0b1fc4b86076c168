"""`mukca solve` and `validate` as scripts and users meet them."""

import json
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest
from cases import by_table
from full_disk import full_disk
from stored import STORED

import mukca

pytestmark = pytest.mark.slow

WRITTEN = {"calibrated.urdf", "calibration.json", "report.html", "report.json", "residuals.csv"}


@pytest.fixture
def run(command, monkeypatch, session):
    """Run a command in the folder of the recordings: status, output, error."""
    monkeypatch.chdir(session)
    return command


def test_json_is_one_object_with_the_agreed_keys(run):
    status, out, _ = run(
        "solve", "front", "--test", "left", "--test", "right", "--robot", "panda", "--json"
    )
    assert status == 0
    result = json.loads(out)
    assert result["robot"] == "panda" and result["method"] == "auto"
    assert result["optimizer"] == "gauss-newton" and result["converged"] is True
    assert result["iterations"] >= 1 and result["solve_seconds"] > 0
    assert [p["role"] for p in result["placements"]] == ["train", "test", "test"]
    assert all(p["samples"] == [12, 12] for p in result["placements"])
    for figures in (*result["placements"], result["summary"]["train"], result["summary"]["test"]):
        for model in ("nominal", "calibrated", "ball_refitted"):
            assert set(figures[model]) >= {"mean_absolute_error", "max_error", "distance_error"}
    assert result["groups"] and result["noise"] and result["uncertainty"]["weak_directions"]
    test = [p["calibrated"] for p in result["placements"] if p["role"] == "test"]
    summary = result["summary"]["test"]["calibrated"]
    by_ball = result["summary"]["test"]["ball_refitted"]["mean_absolute_error"]
    nominal = result["summary"]["test"]["nominal"]["mean_absolute_error"]
    assert nominal > by_ball > summary["mean_absolute_error"]
    assert summary["mean_absolute_error"] == np.mean([m["mean_absolute_error"] for m in test])
    assert summary["max_error"] == max(m["max_error"] for m in test)
    assert summary["distance_error"] == np.mean([abs(m["distance_error"]) for m in test])
    assert result["outputs"] == {}


def test_without_out_nothing_is_written_and_the_last_line_says_so(run, session):
    before = sorted(session.rglob("*"))
    status, out, _ = run("solve", "front", "--robot", "panda")
    assert status == 1 and "Verdict: BETTER" in out and "nothing was left out" in out
    assert out.startswith(
        "With the new URDF, a distance anywhere in the workspace is wrong by about "
    )
    assert out.strip().splitlines()[-1].startswith("Nothing was written")
    assert "the report" not in out
    assert sorted(session.rglob("*")) == before


def test_outputs_are_written_and_validate_reads_them_back(run, tmp_path):
    out = tmp_path / "deep" / "calibrated"
    words = ("solve", "front", "--test", "left", "--robot", "panda", "--out", str(out))
    status, text, _ = run(*words)
    assert status == 0
    assert "camera extrinsics" in text and "load it instead of the nominal URDF" in text
    assert {file.name for file in out.iterdir()} == WRITTEN
    _, text, _ = run("validate", f"{out}/calibration.json", "front", "left", "right", "--json")
    validated = json.loads(text)
    document = json.loads((out / "calibration.json").read_text())
    assert [p["role"] for p in validated["placements"]] == ["train", "test", "test"]
    for row, again in zip(document["placements"], validated["placements"][:2], strict=True):
        assert row["calibrated"] == again["calibrated"] and row["nominal"] == again["nominal"]
    needs_no_other_file(out, document)


def needs_no_other_file(out, document):
    calibration = mukca.load_calibration(out / "calibration.json")
    assert document["model"]["calibrated_urdf"] == (out / "calibrated.urdf").read_text()
    assert document["model"]["nominal_urdf"] == mukca.load_robot("panda").text.data.decode()
    counts = [(d["role"], len(d["samples"])) for d in document["data"]]
    assert counts == [("train", 24), ("test", 24)]
    first = document["data"][0]["samples"][0]
    assert calibration.ball(np.array(first["position"])).shape == (3,)
    assert len(document["history"]) == document["iterations"] + 1
    assert (
        document["history"][0]["test"]["inconsistency"]
        > document["history"][-1]["test"]["inconsistency"]
    )
    assert set(document["provenance"]["versions"]) >= {"mukca", "casadi", "numpy", "python"}
    assert len(document["provenance"]["data_sha256"]) == 4
    names = {(p["joint"], p["component"], p["unit"]) for p in document["parameters"]}
    assert len(names) == 48 and ("ball_joint", "z", "m") in names


def test_results_are_overwritten_only_by_force(run, tmp_path):
    words = ("solve", "front", "--robot", "panda", "--method", "paper", "--out", str(tmp_path))
    status, _, err = run(*words)
    assert status == 2 and "--force" in err
    (tmp_path / "notes.txt").write_text("mine")
    status, out, _ = run(*words, "--force")
    assert status == 3 and ("NOT ENOUGH" in out) != ("load it instead of" in out)
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert not [f for f in tmp_path.iterdir() if f.name.startswith(".")]
    export = ("export", str(tmp_path), "--to", "dh", "--out", str(tmp_path / "dh.csv"))
    assert "NOT ENOUGH DATA: do not use it yet" in run(*export)[2]


def test_a_distorted_model_is_refused_and_not_exported(run, tmp_path):
    # Regularisation holds the nominal lengths, so the base cannot come out 20 mm longer.
    words = ("solve", "front", "--robot", "panda", "--distance", "0.07")
    words = (*words, "--method", "paper", "--regularization", "1")
    status, out, err = run(*words, "--out", str(tmp_path / "c"), "--json")
    assert status == 1
    assert "session" in err and "--accept-distorted" in err
    assert json.loads(out)["distorted"] and not (tmp_path / "c").exists()
    status, out, _ = run(*words, "--out", str(tmp_path / "c"), "--accept-distorted")
    assert status == 1 and "FAIL" in out  # it is written, and no one is told that it is good
    assert "load it instead of" not in out
    assert (tmp_path / "c/calibrated.urdf").exists()
    export = ("export", str(tmp_path / "c"), "--to", "dh", "--out", str(tmp_path / "dh.csv"))
    for words in (export, ("poses", str(tmp_path / "c"), "front/hole_0.csv")):
        status, _, err = run(*words)
        assert status == 0 and "FAIL: do not use it yet" in err


def test_not_converged_is_status_1_and_no_result(run, tmp_path):
    words = ("solve", "front", "--robot", "panda", "--method", "paper", "--max-iterations", "1")
    status, out, err = run(*words, "--json", "--out", str(tmp_path / "c"))
    assert (status, out) == (1, "")
    assert "did not converge" in err and not (tmp_path / "c").exists()


def test_a_test_folder_leaves_out_what_was_trained_on(run, session):
    words = ("--test", ".", "--robot", "panda", "--method", "paper", "--json")
    _, out, err = run("solve", "front", *words)
    assert [p["role"] for p in json.loads(out)["placements"]] == ["train", "test", "test"]
    assert "front: only trained on" in err
    assert "warning" not in err  # it is what a folder of placements is for


def test_a_placement_named_for_the_test_is_left_out_of_a_folder_to_train_on(run, session):
    words = ("--robot", "panda", "--method", "paper", "--json", "--test")
    _, out, err = run("solve", ".", *words, "right")
    roles = {p["name"].split("/")[-1]: p["role"] for p in json.loads(out)["placements"]}
    assert roles == {"front": "train", "left": "train", "right": "test"}
    assert "right: only tested on" in err and "warning" not in err
    status, _, err = run("solve", ".", "right", *words, "right")
    assert status == 2 and "right: trained on, so it cannot be held out as well" in err
    status, _, err = run("solve", ".", *words, "front", "left", "right")
    assert status == 2 and "front: held out, so nothing is left to train on" in err


def test_each_placement_has_its_own_distance(run, session, tmp_path):
    shutil.copytree(session / "left", tmp_path / "left")
    (tmp_path / "left/placement.json").write_text('{"distance": 0.0502}')
    words = ("solve", "front", "--test", str(tmp_path / "left"), "--robot", "panda", "--json")
    words = (*words, "--method", "paper")
    _, out, _ = run(*words)
    assert [p["distance"] for p in json.loads(out)["placements"]] == [0.05, 0.0502]
    _, out, err = run(*words, "--distance", "0.0501")
    assert [p["distance"] for p in json.loads(out)["placements"]] == [0.0501, 0.0501]
    assert "not the recording's 0.0502" in err


def test_free_and_fix_are_obeyed(run):
    words = ("--free", "*.xyz", "--fix", "panda_joint2", "--method", "paper")
    _, out, err = run("solve", "front", "--robot", "panda", "--json", *words)
    assert json.loads(out)["summary"]["test"] is None and "DO NOT LOAD IT" in err
    names = [row["name"] for row in json.loads(out)["parameters"]]
    assert all(name[-2:] in (".x", ".y", ".z") for name in names)
    assert "panda_joint8.x" in names and not any("joint2" in name for name in names)


def edited(session, to, hole_0):
    """A copy of the front placement with another hole_0.csv, or none."""
    shutil.copytree(session / "front", to)
    (to / "hole_0.csv").unlink()
    if hole_0 is not None:
        (to / "hole_0.csv").write_text(hole_0)
    return str(to)


@by_table("hole_0", "told")
def test_bad_recordings_get_one_line(refused, session, tmp_path, hole_0, told):
    words = ("solve", edited(session, tmp_path / "bad", hole_0), "--robot", "panda")
    assert refused(told, *words).startswith("mukca solve: ")


def test_a_full_disk_is_told(run, tmp_path):
    """A limit on the size of files stands for the disk; the URDF alone is larger."""
    with full_disk(4096):
        status, _, err = run("solve", "front", "--robot", "panda", "--out", str(tmp_path / "c"))
    assert status == 2 and "nothing was changed; reason: File too large" in err
    assert not (tmp_path / "c").exists()


@pytest.fixture
def shell(session):
    """Run `mukca` with words and redirections in the folder of the recordings, by a shell."""
    return lambda words: subprocess.run(
        ["bash", "-c", f'"$0" -m mukca {words}', sys.executable],
        cwd=session, capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.mark.parametrize("name", ["S\N{LATIN SMALL LETTER U WITH DIAERESIS}d", "a\udcff"])
@pytest.mark.parametrize("words", ["check {} --robot panda", "info {}", "solve {} --robot panda"])
def test_letters_that_the_output_has_not_are_marks(
    shell, session, tmp_path, monkeypatch, words, name
):
    """As on a console of Windows, or where a name is of another encoding."""
    monkeypatch.setenv("PYTHONIOENCODING", "ascii:strict")
    shutil.copytree(session / "front", tmp_path / name)
    result = shell(words.format(tmp_path / "*"))
    assert result.returncode in (0, 1, 3) and "?" in result.stdout, result.stderr


LONG = 300 * "x"
"""A name that no disk takes, and that even root cannot look at."""


@pytest.mark.parametrize(
    "words",
    [
        f"report {LONG}",
        f"compare {LONG}",
        f"extract {LONG} --robot panda",
        f"validate {LONG} front",
        f"check {LONG} --robot panda",
        f"fleet {LONG} --robot panda --out out",
        f"solve front --robot panda --out {LONG}",
        f"plan --robot panda --out {LONG}.svg",
        f"plan --robot panda --out {LONG[:246]}.svg",
    ],
)
def test_a_path_that_cannot_be_looked_at_is_told(shell, words):
    result = shell(words)
    *_, last = result.stderr.splitlines()
    assert result.returncode == 2 and last.startswith(f"mukca {words.split()[0]}: xxx")
    assert last.endswith("File name too long") and "/.xxx" not in last


def test_as_a_module_and_to_a_closed_pipe(shell):
    result = shell("solve front --robot panda | head -1")
    assert result.returncode == 0 and "Traceback" not in result.stderr


@pytest.mark.parametrize("more", ["", " --json"])
def test_an_output_that_is_full_is_told_in_one_line(shell, more):
    words = f"check front --robot panda{more}"
    result = shell(f"{words} > /dev/full")
    *_, last = result.stderr.splitlines()
    assert result.returncode == 1
    assert last == "mukca check: what it says cannot be written: No space left on device"
    assert shell(f"{words} >&-").returncode == 0


def test_a_link_that_is_written_to_stays_a_link(session, tmp_path, run):
    link, target = tmp_path / "link.csv", tmp_path / "target.csv"
    target.touch()
    link.symlink_to(target)
    words = ["poses", str(STORED / "1.0" / "calibrated"), "front/hole_0.csv"]
    status, *_ = run(*words, "--out", str(link), "--force")
    assert status == 0 and link.is_symlink() and target.read_text().count("\n") > 3
    status, _, err = run(*words, "--out", "/dev/full", "--force")
    assert status == 2 and "/dev/full: is no file; choose another" in err


def test_the_help_loads_nothing_heavy():
    code = (
        "import sys; from mukca.tools.cli import main\n"
        "try: main(['--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'casadi', 'numpy', 'yourdfpy', 'rich', 'matplotlib', 'serial', 'can'}\n"
        "sys.exit(str(heavy & set(sys.modules)) if heavy & set(sys.modules) else 0)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_the_help_names_the_defaults_that_are_used(run):
    status, out, _ = run("solve", "--help-all")
    words = " ".join(out.partition("method paper:")[2].split())
    assert status == 0
    paper = {"optimizer": "gauss-newton", "regularization": 1e-4, "max_iterations": 200}
    for option, default in paper.items():
        at = re.search(rf"--{option.replace('_', '-')} [^-].*?\(default: ([^)]+)\)", words)
        assert at and type(default)(at[1]) == default


PAPER = ("solve", "front", "--test", "left", "--robot", "panda", "--method", "paper")


def test_fail_is_status_1_and_the_files_are_there(run, tmp_path):
    out = ("--out", str(tmp_path / "c"), "--json")
    status, text, err = run(*PAPER, "--repeatability-mm", "0.3", *out)
    assert status == 0 and json.loads(text)["outputs"]
    status, text, err = run(*PAPER, "--distance", "0.055", *out, "--force")
    assert status == 1 and "FAIL" in err
    assert "warning: all placements: the sockets are more likely" in err
    likely = re.search(
        r"the sockets are more likely (\S+) mm apart than 55.0", " ".join(err.split())
    )
    assert likely is not None and float(likely[1]) == pytest.approx(50, abs=0.7)
    assert json.loads(text)["scale"]["value"] == pytest.approx(0.09, abs=0.01)
    assert 5e-4 < json.loads(text)["scale"]["deviation"] < 5e-3
    assert json.loads(text)["verdict"]["status"] == "fail"
    assert {file.name for file in (tmp_path / "c").iterdir()} == WRITTEN
    report = json.loads((tmp_path / "c/report.json").read_text())
    assert report["verdict"]["status"] == "fail"
    assert "55 mm (as given)" in err and "55 mm (as given)" in report["distance_text"]


@pytest.mark.parametrize("metadata", [None, {"distance": 0.05}])
def test_a_distance_that_nobody_measured_is_no_pass(run, session, tmp_path, metadata):
    """A 0.05 that the recorder once wrote by itself is none either; typed, it is."""
    for name in ("front", "left"):
        shutil.copytree(session / name, tmp_path / name)
        (tmp_path / name / "placement.json").unlink()
        if metadata is not None:
            (tmp_path / name / "placement.json").write_text(json.dumps(metadata))
    words = ("solve", str(tmp_path / "front"), "--test", str(tmp_path / "left"))
    words = (*words, "--robot", "panda", "--method", "paper")
    status, text, _ = run(*words)
    assert status == 3 and "50 mm (the default: nobody measured it" in " ".join(text.split())
    assert "NOT ENOUGH DATA" in text and "obody measured the distance of the sockets" in text
    status, text, _ = run(*words, "--distance", "0.05", "--json")
    verdict = json.loads(text)["verdict"]
    assert status == 0 and (verdict["status"], verdict["kind"]) == ("pass", None)
    relies = (
        "This relies on your 50 mm: measured 0.1 mm too short, every length is 0.2 % too short."
    )
    assert relies in " ".join(verdict["answer"])


def test_a_fit_that_breaks_down_is_one_line(run, monkeypatch):
    def broken(*_, **__):
        raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr("mukca.solver.calibration.robot_calibration.fit_robot", broken)
    status, out, err = run("solve", "front", "--robot", "panda", "--json")
    assert (status, out) == (1, "") and len(err.strip().splitlines()) == 1
    assert "did not converge" in err


def test_an_uncertainty_that_is_no_number_fails_and_is_not_written(run, monkeypatch, tmp_path):
    monkeypatch.setattr("mukca.solver.results.Fit.posterior", None)
    out = ("--out", str(tmp_path / "c"))
    status, _, err = run("solve", "front", "--test", "left", "--robot", "panda", "--json", *out)
    assert status == 1 and "could not be computed" in err and "FAIL" in err
    text = (tmp_path / "c/calibration.json").read_text() + (tmp_path / "c/report.json").read_text()
    assert "NaN" not in text and "uncertainty" not in json.loads(
        (tmp_path / "c/calibration.json").read_text()
    )
