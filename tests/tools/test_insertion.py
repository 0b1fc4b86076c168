"""The experiments in simulation: it is the model that decides, not the controller."""

import io
import json
import os
import re
import subprocess
import sys
from contextlib import redirect_stdout
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the extra simulation is not installed")
pytest.importorskip("pinocchio", reason="the extra simulation is not installed")

from PIL import Image

import mukca
from mukca.tools.cli import main

pytestmark = pytest.mark.slow


def simulate(*words):
    with redirect_stdout(io.StringIO()) as told:
        assert main(["simulate", *words, "--json"]) == 0
    return json.loads(told.getvalue())


def simulate_apart(*words, **environment):
    """Simulate in a program of its own."""
    command = [sys.executable, "-m", "mukca", "simulate", *words]
    return subprocess.run(command, env=os.environ | environment, capture_output=True, text=True)


@pytest.fixture(scope="module")
def report(shared):
    """Return the folder of an experiment, with the calibrated model and the nominal one."""

    def report(experiment):
        def make(out):
            between = 2.0 if experiment == "insertion" else 4.0  # frames [s]
            with patch("mukca.tools.experiments.pictures.INTERVAL", between):
                result = simulate(*words_of(experiment, out))
            assert json.loads((out / "simulation.json").read_text()) == result

        return shared(f"simulated-{experiment}", make)

    return report


def words_of(experiment, out):
    words = (experiment, "--model", "calibrated", "--trials", "2", "--out", str(out))
    return (*words, "--cross", "1") if experiment == "insertion" else words


def figures(folder):
    """Return what came of the nominal and of the calibrated model."""
    result = json.loads((folder / "simulation.json").read_text())
    return result["beside"], result


def test_the_calibrated_model_inserts_and_the_nominal_does_not(report):
    nominal, result = figures(report("insertion"))
    assert result["centre"]["inserted"] == 2
    assert result["cross"]["inserted"] == 1
    assert nominal["centre"]["inserted"] < 2
    error = [one["centre"]["tracking_error"] for one in (nominal, result)]
    assert error[1] < 1e-3 < error[0]
    elbows = [trial["elbow"] for trial in result["centre"]["each"]]
    assert max(elbows) - min(elbows) > 1.0


def test_lines_of_the_calibrated_model_lie_together(report):
    nominal, calibrated = (one["drawing"] for one in figures(report("drawing")))
    assert calibrated["max_spread"] < 0.5e-3 < nominal["spread"]
    assert all(line["touching"] > 0.95 for line in calibrated["each"])


def test_a_model_may_be_a_file(tmp_path):
    model = tmp_path / "mine.urdf"
    model.write_bytes(mukca.load_robot("panda").text.data)
    words = ("insertion", "--trials", "1", "--hole-mm", "40", "--model")
    by_file, by_word = simulate(*words, str(model)), simulate(*words, "nominal")
    assert by_file.pop("model") == str(model) and by_word.pop("model") == "nominal"
    assert by_file == by_word


@pytest.mark.parametrize("experiment", ["insertion", "drawing"])
def test_a_report_shows_both_models(report, experiment):
    out = report(experiment)
    if not (out / "picture.png").exists():
        pytest.skip("neither EGL nor OSMesa: apt-get install libegl1")
    nominal, result = figures(out)
    shown = {"picture.png", "animation.gif"}
    assert {file.name for file in out.iterdir()} == {"report.html", "simulation.json"} | shown
    assert (nominal["model"], result["model"]) == ("nominal", "calibrated")
    with Image.open(out / "animation.gif") as frames:
        assert frames.n_frames > 5
    with Image.open(out / "picture.png") as picture:
        shown = np.asarray(picture.convert("RGB"), dtype=float)[20:]  # less the title
    half = shown.shape[1] // 2
    assert shown.std() > 10
    assert np.abs(shown[:, :half] - shown[:, half:]).max() > 50
    page = (out / "report.html").read_text()
    assert page.count("data:image/") == 2
    assert not re.search(r"(src|href)=\"(?!data:)", page)
    assert main(["simulate", *words_of(experiment, out)]) == 2  # nothing is overwritten


def test_without_opengl_the_figures_are_given_all_the_same(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "report.html").write_text("an older one")
    words = ("insertion", "--model", "true", "--trials", "1", "--out", str(out), "--force")
    done = simulate_apart(*words, "--json", MUJOCO_GL="nowhere")
    assert done.returncode == 0
    (warning,) = [line for line in done.stderr.splitlines() if line.startswith("warning:")]
    assert "no pictures" in warning
    assert "libegl1" in warning
    told = json.loads(done.stdout)
    assert told["centre"]["inserted"] == 1
    # A seed repeats a trial, in another program as well.
    once = simulate("insertion", "--model", "true", "--trials", "1")
    assert {key: told[key] for key in once} == once
    assert {file.name for file in out.iterdir()} == {"report.html", "simulation.json"}
    assert "data:image/" not in (out / "report.html").read_text()


def test_a_missing_package_is_named(tmp_path):
    # A module that is not there, as on a machine without the extra.
    (tmp_path / "mujoco.py").write_text("raise ImportError('nothing', name='mujoco')")
    paths = [str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])]
    done = simulate_apart("drawing", PYTHONPATH=os.pathsep.join(paths))
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "mujoco is not installed" in line
    assert "mukca[simulation]" in line


def test_a_model_of_another_arm_is_named(refused, tmp_path):
    other = str(tmp_path / "ur5e.urdf")
    Path(other).write_bytes(mukca.load_robot("ur5e").text.data)
    line = refused(other, "simulate", "insertion", "--model", other)
    assert "shoulder_pan_joint" in line and "panda_joint1" in line
