"""The examples run as they stand, from any folder, and use nothing but the public face."""

import ast
import json
import re
import runpy
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from terminal_session import PATIENCE

import mukca
from mukca.tools.cli import main

pytestmark = pytest.mark.slow

EXAMPLES = Path(__file__).parents[1] / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run an example in a folder of its own, and return what it printed."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")

    def run(script, *words):
        monkeypatch.setattr(sys, "argv", [script, *words])
        runpy.run_path(str(EXAMPLES / script), run_name="__main__")
        return capsys.readouterr().out

    return run


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda file: file.name)
def test_an_example_is_short_and_uses_the_public_face_alone(script):
    text = script.read_text()
    nodes = list(ast.walk(ast.parse(text)))
    imported = {a.name for node in nodes if isinstance(node, ast.Import) for a in node.names}
    imported |= {node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)}
    assert imported <= {"mukca", "numpy", "pathlib", "pinocchio", "sys", "tempfile"}
    assert set(re.findall(r"\bmukca\.(\w+)", text)) <= set(mukca.__all__)
    assert 15 <= len(text.splitlines()) <= 40


def test_calibrate_from_csv(run, tmp_path):
    shown = run("calibrate_from_csv.py")
    placements = mukca.read_placements(tmp_path / "recordings")
    assert [len(p.samples) for p in placements] == [24, 24, 24]
    calibration = mukca.load_calibration(tmp_path / "calibrated" / "calibration.json")
    assert [e.role for e in calibration.errors] == 3 * ["train"] + 3 * ["left_out"]
    assert calibration.errors.summary.left_out.removed_error > 0.9
    assert "left out" in shown and "report.html" in shown


def test_own_urdf(run, tmp_path):
    shown = run("own_urdf.py")
    assert "6 joints, base_link -> ball_link" in shown
    calibration = mukca.load_calibration(tmp_path / "my_arm_calibrated" / "calibration.json")
    assert calibration.errors.summary.test.removed_error > 0.9
    names = [p.name for p in calibration.document.parameters]
    assert "waist.roll" in names and "waist.x" not in names
    assert re.search(r"\w+\.[xyz] changed most: by [+-]\d\.\d\d mm", shown)


def test_stream_arm(tmp_path):
    """As a program of its own."""
    words = [sys.executable, "-W", "error", str(EXAMPLES / "stream_arm.py")]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    names, *states = done.stdout.splitlines()
    rows = np.array([[float(word) for word in line.split() if word not in ("s", "deg")]
                     for line in states])  # fmt: skip
    assert rows.shape == (20, 8) and len(names.split()) == 7
    assert np.diff(rows[:, 0]) == pytest.approx(0.02, abs=1e-6)
    assert np.all(np.ptp(rows[:, 1:], axis=0) > 1)


def test_use_in_pinocchio(run):
    pytest.importorskip("pinocchio", reason="the extra simulation is not installed")
    shown = run("use_in_pinocchio.py")
    difference, nominal = re.findall(r"by ([\d.e+-]+) m", shown)
    assert float(difference) < 1e-9 and float(nominal) > 0.5
    again = run("use_in_pinocchio.py", "calibrated")
    assert again == shown


def test_monte_carlo(run):
    _, *rows = run("monte_carlo.py", "1", "5", "15").splitlines()
    few, many = ([float(word) for word in row.split()] for row in rows)
    assert (few[0], many[0]) == (5, 15)
    assert 0.05 < many[1] < few[1] < 2  # the noise is 0.05 mm per axis
    assert 0 < many[2] < 2  # by the nominal model it is some 10 mm


def snippets(page):
    """Return the Python code on a page, block by block."""
    text = (EXAMPLES.parent / "docs" / page).read_text()
    return re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)


def test_what_pages_simulate_can_be_tried(tmp_path, monkeypatch, command):
    """A motor that changed, touches of a tool, and recordings of one's own URDF."""
    monkeypatch.chdir(tmp_path)
    (changed,) = snippets("zeros.md")
    rigid = "places, without=['compliance', 'tilt', 'transmission'])"
    exec(changed.replace("places)", rigid), {})
    status, out, _ = command("rezero", "calibrated", "today", "--joint", "panda_joint4")
    (degrees,) = re.findall(r"\((-\S+) deg\) to what it reads", out)
    assert status == 0 and abs(float(degrees) + 2) < 0.1
    shutil.rmtree("calibrated")
    touched, *_ = snippets("hold.md")
    exec(touched.replace("places)", rigid), {})
    status, out, _ = command("tool", "calibrated", "spike.csv", "--json")
    assert np.allclose(json.loads(out)["xyz"], (0.02, -0.01, 0.12), atol=1e-3), out
    shipped = EXAMPLES.parent / "solver/identification/robot/shipped/ur5e.urdf"
    shutil.copy(shipped, "my_arm.urdf")
    recorded, *_ = snippets("new-arm.md")
    exec(recorded, {})
    read = mukca.read_placements("recordings")
    assert [placement.distance for placement in read] == [0.1001] * 3


def test_the_code_in_the_documents_runs(tmp_path, session, monkeypatch):
    for name in ("front", "left", "right"):
        shutil.copytree(session / name, tmp_path / "recordings" / name)
    shutil.copytree(session / "left", tmp_path / "july")
    monkeypatch.chdir(tmp_path)
    code = "\n".join(snippets("python.md")).replace("samples=30", "samples=8")
    code = code.replace("recordings/july", "july")
    code = code.replace("franka:172.16.0.2", "mock:recordings/front")
    names = {}
    exec(code, names)
    assert len(names["state"].position) == 7
    q = names["q"]
    real, predicted = (
        np.linalg.norm(np.diff(names[model].ball(q), axis=0), axis=1)
        for model in ("truth", "calibration")
    )
    assert np.abs(real - predicted).mean() < 5e-3
    names = {"q": q, "effort": np.zeros_like(q)}
    (last,) = snippets("model.md")
    exec(last, names)
    assert names["calibration"].robot.name == "panda"


TOURS = (EXAMPLES.parent / "docs" / "tours.md").read_text().split("\n## ")[1:]
TOUR_ENDS = {
    "A student with a Panda": ["panda-calibrated/report.html"],
    "A lab with six arms": ["fleet-report/fleet.html"],
    "An integrator with two UR under a tracker": [
        "cell/arms.urdf",
        "sheet_left.html",
        "sheet_right.html",
    ],
    "An SO-101 owner with lerobot": ["my_arm_new.json"],
}
NUMBER = r"\d+\.\d+"
SMALLER = {"range(1, 7)": "range(1, 3)", "samples=20": "samples=12", '"train", 80': '"train", 40'}


@pytest.mark.parametrize("tour", TOURS, ids=lambda tour: tour.partition("\n")[0])
def test_a_tour_runs_from_its_heading(tour, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for words, fewer in SMALLER.items():
        tour = tour.replace(words, fewer)
    names = {}
    for kind, block in re.findall(r"^```(\w*)\n(.*?)^```", tour, re.M | re.S):
        if kind == "python":
            exec(block, names)
            continue
        if kind == "text":
            printed = {
                re.sub(NUMBER, "#", line): line for line in capsys.readouterr().out.split("\n")
            }
            for line in block.splitlines():
                values = map(float, re.findall(NUMBER, printed[re.sub(NUMBER, "#", line)]))
                assert list(map(float, re.findall(NUMBER, line))) == pytest.approx(
                    list(values), abs=0.02
                )
            continue
        for line in block.splitlines():
            assert main(shlex.split(line)[1:]) in (0, 3), line
    assert not re.search(r"Robot \w+\nRobot", capsys.readouterr().out)
    kept = (Path(name) for name in TOUR_ENDS[tour.partition("\n")[0]])
    assert all(file.exists() for file in kept)
    if "truth" in names:
        assert names["calibrated"] < 0.1 * names["nominal"]


def test_the_notebook_runs_from_top_to_bottom(tmp_path, monkeypatch):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    notebook = json.loads((EXAMPLES.parent / "docs" / "notebook.ipynb").read_text())
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    monkeypatch.chdir(tmp_path)
    names = {}
    exec("\n".join(cells).replace("samples=30", "samples=12"), names)
    before, after = (np.mean(names["spread"][name]) for name in ("nominal", "calibrated"))
    assert after < 0.2 < before
    assert Path(names["outputs"]["urdf"]).is_file()
    assert all(not cell.get("outputs") for cell in notebook["cells"])
