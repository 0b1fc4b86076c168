"""The experiments in simulation: it is the model that decides, not the controller."""

import io
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the extra simulation is not installed")
pytest.importorskip("pinocchio", reason="the extra simulation is not installed")

from PIL import Image

from mukca.recorder import write_holes
from mukca.solver.robot import ModelError
from mukca.tools.cli import main
from mukca.tools.cli.commands.demo import demo_arm
from mukca.tools.experiments import drawing, film, pictures
from mukca.tools.experiments.controller import ArmModel
from mukca.tools.experiments.models import record_placements
from mukca.tools.experiments.scene import urdf_of

pytestmark = pytest.mark.slow

Report = Callable[[str], Path]


def simulate(*words: str) -> dict:
    with redirect_stdout(io.StringIO()) as told:
        assert main(["simulate", *words, "--json"]) == 0
    return json.loads(told.getvalue())


@pytest.fixture(scope="module")
def calibrated(shared) -> str:
    """The URDF that a user gets: the arm recorded at four placements, and solved."""

    def make(folder: Path) -> None:
        for placement in record_placements(demo_arm(keep_size=False)[1], seed=0):
            write_holes(placement, folder / "recordings" / placement.name)
        recordings, out = str(folder / "recordings"), str(folder / "out")
        # The experiments' arm is 2 % larger than its model, as no real arm is: it is written, and
        # refused.
        assert main(["solve", recordings, "--robot", "panda", "--out", out]) == 1

    return str(shared("simulated", make) / "out/calibrated.urdf")


def words_of(experiment: str, model: str, out: Path) -> tuple[str, ...]:
    words = (experiment, "--model", model, "--trials", "2", "--out", str(out))
    return (*words, "--cross", "1") if experiment == "insertion" else words


@pytest.fixture(scope="module")
def report(calibrated: str, shared) -> Report:
    """Return the folder with an experiment's report: the calibrated model, the nominal beside it.

    The figure is drawn in half the usual time, which makes lines worse if anything.
    """

    def report(experiment: str) -> Path:
        def make(out: Path) -> None:
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(film, "INTERVAL", 2.0)
                patch.setattr(drawing, "SECONDS", 0.5 * drawing.SECONDS)
                for module in (film, pictures):  # small ones are drawn sooner
                    patch.setattr(module, "WIDTH", 160)
                    patch.setattr(module, "HEIGHT", 120)
                result = simulate(*words_of(experiment, calibrated, out))
            assert json.loads((out / "simulation.json").read_text()) == result

        return shared(f"simulated-{experiment}", make)

    return report


def figures(folder: Path) -> tuple[dict, dict]:
    """Return what came of the nominal and of the calibrated model."""
    result = json.loads((folder / "simulation.json").read_text())
    return result["beside"], result


def test_the_calibrated_model_inserts_and_the_nominal_does_not(report: Report) -> None:
    nominal, result = figures(report("insertion"))
    assert result["centre"]["inserted"] == 2
    assert result["cross"]["inserted"] == 1
    assert nominal["centre"]["inserted"] < 2
    error = [one["centre"]["tracking_error"] for one in (nominal, result)]
    assert error[1] < 1e-3 < error[0]
    elbows = [trial["elbow"] for trial in result["centre"]["each"]]
    assert max(elbows) - min(elbows) > 1.0


def test_lines_of_the_calibrated_model_lie_together(report: Report) -> None:
    nominal, calibrated = (one["drawing"] for one in figures(report("drawing")))
    assert calibrated["max_spread"] < 0.5e-3 < nominal["spread"]
    assert all(line["touching"] > 0.95 for line in calibrated["each"])


def test_the_word_calibrated_stands_for_what_solve_exports(calibrated: str, monkeypatch) -> None:
    """A seed repeats recordings and calibration, but for their digits."""
    given: list[bytes] = []

    def attempt(settings, arm, name: str, urdf: bytes, progress) -> None:
        given.append(urdf)
        raise ModelError("seen")

    monkeypatch.setattr("mukca.tools.experiments.attempt.attempt", attempt)
    assert main(["simulate", "insertion", "--model", "calibrated", "--trials", "1"]) == 2
    _, arm = demo_arm(keep_size=False)
    one, other = (
        ArmModel(urdf, arm.joint_names, arm.tip) for urdf in (*given, Path(calibrated).read_bytes())
    )
    for q in np.random.default_rng(0).uniform(-1, 1, (5, 7)):
        assert one.pose(q).homogeneous == pytest.approx(other.pose(q).homogeneous, abs=1e-9)


def test_the_model_is_the_arm_that_it_says() -> None:
    nominal, arm = demo_arm(keep_size=False)
    q = np.array([0, -0.5, 0.2, -2.0, 0.1, 1.8, 0.3])
    poses = [
        ArmModel(text, arm.joint_names, arm.tip).pose(q).translation
        for text in (nominal.text.data, urdf_of(arm))
    ]
    assert 1e-3 < np.linalg.norm(poses[0] - poses[1]) < 5e-2


def renders() -> bool:
    """Tell whether this machine can make pictures."""
    try:
        pictures._gl_context().free()
    except pictures.PictureError:
        return False
    return True


@pytest.mark.parametrize("experiment", ["insertion", "drawing"])
@pytest.mark.skipif(not renders(), reason="neither EGL nor OSMesa: apt-get install libegl1")
def test_a_report_shows_both_models(calibrated: str, report: Report, experiment: str) -> None:
    out = report(experiment)
    nominal, result = figures(out)
    assert {file.name for file in out.iterdir()} == {
        "report.html",
        "simulation.json",
        "picture.png",
        "animation.gif",
    }
    assert (nominal["model"], result["model"]) == ("nominal", calibrated)
    with Image.open(out / "animation.gif") as frames:
        assert frames.n_frames > 5
    with Image.open(out / "picture.png") as picture:
        shown = np.asarray(picture.convert("RGB"), dtype=float)[pictures.TITLE :]
    half = shown.shape[1] // 2
    assert shown.std() > 10
    assert np.abs(shown[:, :half] - shown[:, half:]).max() > 50
    page = (out / "report.html").read_text()
    assert page.count("data:image/") == 2
    assert not re.search(r"(src|href)=\"(?!data:)", page)
    assert main(["simulate", *words_of(experiment, calibrated, out)]) == 2  # nothing is overwritten


def test_without_opengl_the_figures_are_given_all_the_same(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "report.html").write_text("an older one")
    words = ("insertion", "--model", "true", "--trials", "1", "--out", str(out), "--force")
    done = subprocess.run(
        [sys.executable, "-m", "mukca", "simulate", *words, "--json"],
        env={**os.environ, "MUJOCO_GL": "nowhere"},
        capture_output=True,
        text=True,
    )
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


def test_a_missing_package_is_named(tmp_path: Path) -> None:
    # A module that is not there, as on a machine without the extra.
    (tmp_path / "mujoco.py").write_text("raise ImportError('nothing', name='mujoco')")
    paths = [str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])]
    done = subprocess.run(
        [sys.executable, "-m", "mukca", "simulate", "drawing"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "mujoco is not installed" in line
    assert "mukca[simulation]" in line


@pytest.mark.parametrize(
    "words",
    [
        ("insertion", "--hole-mm", "9"),
        ("insertion", "--trials", "0"),
        ("insertion", "--cross", "25"),
        ("insertion", "--model", "nowhere.urdf"),
        ("insertion", "--model", __file__),
        ("insertion", "--force"),
        ("insertion", "--seed", "-1"),
        ("drawing", "--trials", "1"),
        ("drawing", "--out", __file__),
    ],
)
def test_bad_arguments_get_one_line(capsys, words: tuple[str, ...]) -> None:
    assert main(["simulate", *words]) == 2
    error = capsys.readouterr().err
    assert len(error.strip().splitlines()) == 1


def test_a_model_of_another_arm_is_named(capsys) -> None:
    other = str(files("mukca.solver.robot") / "shipped" / "ur5e.urdf")
    assert main(["simulate", "insertion", "--model", other]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert other in line
    assert "shoulder_pan_joint" in line
    assert "panda_joint1" in line


def test_an_option_of_the_other_experiment_is_refused(capsys) -> None:
    with pytest.raises(SystemExit) as left:
        main(["simulate", "drawing", "--hole-mm", "16"])
    assert left.value.code == 2
    assert "--hole-mm" in capsys.readouterr().err
